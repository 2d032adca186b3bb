"""The robot's body: a disc in a pymunk space, and how it moves among segments.

The disc never turns by contact: its heading is commanded and exact. A drive advances in
leaps as long as nothing is near (each leap is shorter than the free distance to the
nearest thing, so that no leap can meet anything) and in short physics sub-steps near
things.

Contact: a disc that grazes a wall or a jamb at less than 18 degrees slides along it; a
contact that takes more than a tenth of the commanded speed ends the motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pymunk
from numpy.typing import NDArray

from cogmap_gym.geometry import Pose, Segments, wrap_angle
from cogmap_gym.observation import RobotSpec

SUBSTEP_S = 0.008
"""Longest physics sub-step [s]: at 0.7 m/s it drives 5.6 mm (FINDINGS 6 used 0.02 s)."""
LEAP_MARGIN_M = 0.002
"""A leap ends at least this far from anything [m]."""
MIN_LEAP_M = 0.01
"""Leaps shorter than this are left to the physics [m]."""
TINY_M = 1e-9
"""Less than this is nothing left to drive [m]."""
MIN_SPEED_SHARE = 0.9
"""Below this share of the commanded speed a contact opposes the motion: cos^2(18.4 deg)."""
VELOCITY_SUBSTEPS = 5
"""Sub-steps of one velocity step, each driven at the heading of its middle."""
SLOP_M = 0.001
"""Overlap that the physics leaves alone [m]."""
SOLID, GHOST, BODY = 0b001, 0b010, 0b100
"""Collision categories: what stands in the way, what does not now, and the robot."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What the body truly did."""

    turned: float
    """Angle turned [rad], counter-clockwise positive."""
    driven: float
    """Distance the wheels rolled [m]: the displacement along the heading; backwards negative."""
    bump: bool
    """Whether contact that opposed the motion ended it."""
    path: NDArray[np.float64]
    """Where the centre went, world frame, shape (K, 2) with K >= 1 [m]; the first is the start."""

    @property
    def length(self) -> float:
        """How long the way of the centre was [m]."""
        return sum(math.dist(p, q) for p, q in pairwise(self.path.tolist()))


class Body:
    """A disc among segments that can each be solid or not.

    Args:
        robot: radius and top speeds.
        segments: (N, 2, 2), all solid at first [m].
    """

    def __init__(self, robot: RobotSpec, segments: Segments) -> None:
        """Put the disc at the origin."""
        self._robot = robot
        self._velocity = (0.0, 0.0)
        self._heading = 0.0
        self._space = pymunk.Space()
        self._space.collision_slop = SLOP_M
        still = self._space.static_body
        self._shapes = [
            pymunk.Segment(still, (px, py), (qx, qy), 0.0)
            for (px, py), (qx, qy) in segments.tolist()
        ]
        for row in range(len(segments)):
            self.set_solid(row, solid=True)
        self._space.add(*self._shapes)
        self._body = self._new_body()

    @property
    def pose(self) -> Pose:
        """The true pose."""
        x, y = self._body.position
        return Pose(x, y, self._heading)

    @pose.setter
    def pose(self, pose: Pose) -> None:
        self._body.position = (pose.x, pose.y)
        self._heading = wrap_angle(pose.theta)

    def set_solid(self, row: int, *, solid: bool) -> None:
        """Put a segment in the way, or let the disc pass through it."""
        self._shapes[row].filter = pymunk.ShapeFilter(categories=SOLID if solid else GHOST)

    def clearance(self, point: tuple[float, float]) -> float:
        """Metres between the disc, were it centred at ``point``, and the nearest solid thing.

        Distances beyond the longest move are not told apart.
        """
        reach = self._robot.max_forward + 2.0 * self._robot.radius
        hit = self._space.point_query_nearest(point, reach, pymunk.ShapeFilter(mask=SOLID))
        return (reach if hit is None else hit.distance) - self._robot.radius

    def move(self, turn: float, forward: float) -> Motion:
        """Turn by ``turn`` [rad] in place, then drive ``forward`` [m] or up to contact.

        The turn is exact; a free drive ends exactly ``forward`` from its start.
        """
        self._heading = wrap_angle(self._heading + turn)
        path = [tuple(self._body.position)]
        driven, bump = self._advance(self._heading, forward, path)
        return Motion(turn, driven, bump, np.array(path))

    def drive(self, v: float, omega: float) -> Motion:
        """Drive at ``v`` [m/s] turning at ``omega`` [rad/s] for one velocity step."""
        dt = self._robot.velocity_step / VELOCITY_SUBSTEPS
        path = [tuple(self._body.position)]
        longest = abs(v) * self._robot.velocity_step
        if self.clearance(self._body.position) > longest + 2.0 * LEAP_MARGIN_M:
            return self._glide(v * dt, omega * dt, path)
        driven, turned, bump = 0.0, 0.0, False
        while turned < VELOCITY_SUBSTEPS and not bump:
            middle = self._heading + 0.5 * omega * dt
            step, bump = self._advance(middle, v * dt, path)
            self._heading = wrap_angle(self._heading + omega * dt)
            driven += step
            turned += 1
        return Motion(turned * omega * dt, driven, bump, np.array(path))

    def _glide(self, distance: float, turn: float, path: list[tuple[float, ...]]) -> Motion:
        """``drive`` where nothing is near enough to be met: the sub-steps that it would make."""
        sign, left = math.copysign(1.0, distance), abs(distance)
        (x, y), driven = path[0], 0.0
        for _ in range(VELOCITY_SUBSTEPS):
            middle = self._heading + 0.5 * turn
            self._heading = wrap_angle(self._heading + turn)
            if left > TINY_M:
                ux, uy = sign * math.cos(middle), sign * math.sin(middle)
                fromx, fromy, x, y = x, y, x + left * ux, y + left * uy
                driven += sign * ((x - fromx) * ux + (y - fromy) * uy)
                path.append((x, y))
        self._body.position = x, y
        return Motion(VELOCITY_SUBSTEPS * turn, driven, False, np.array(path))

    def _advance(
        self, heading: float, distance: float, path: list[tuple[float, ...]]
    ) -> tuple[float, bool]:
        """Drive along ``heading``; append to ``path``; answer (driven, bump)."""
        sign = math.copysign(1.0, distance)
        ux, uy = sign * math.cos(heading), sign * math.sin(heading)
        left, touching, opposed = abs(distance), False, False
        x, y = start = path[-1]
        while left > TINY_M and not opposed:
            leap = min(left, self.clearance((x, y)) - LEAP_MARGIN_M)
            if leap >= min(left, MIN_LEAP_M):
                x, y = x + leap * ux, y + leap * uy
                self._body.position = x, y
                left, touching = left - leap, False
            else:
                left, opposed = self._substep(ux, uy, left, touching)
                touching = True
                x, y = self._body.position
            path.append((x, y))
        return sign * ((x - start[0]) * ux + (y - start[1]) * uy), opposed

    def _substep(self, ux: float, uy: float, left: float, touching: bool) -> tuple[float, bool]:
        """One physics sub-step along (ux, uy); answer (distance left, contact opposed it).

        A step moves by the velocity that the last one found free of contact. So the first
        one near a thing only finds that velocity, from rest and with a body that remembers
        no contact: the pose alone decides what follows.
        """
        speed = self._robot.max_speed
        dt = min(SUBSTEP_S, left / speed)
        if not touching:
            self._space.remove(*self._body.shapes, self._body)
            self._body = self._new_body(self._body.position)
        self._velocity = (speed * ux, speed * uy)
        self._space.step(dt)
        vx, vy = self._body.velocity
        opposed = vx * ux + vy * uy < MIN_SPEED_SHARE * speed
        return left - (speed * dt if touching else 0.0), opposed

    def _new_body(self, position: tuple[float, float] = (0.0, 0.0)) -> pymunk.Body:
        body = pymunk.Body(1.0, math.inf)
        body.position = position
        body.velocity_func = self._command_velocity
        disc = pymunk.Circle(body, self._robot.radius)
        disc.filter = pymunk.ShapeFilter(categories=BODY, mask=SOLID)
        self._space.add(body, disc)
        return body

    def _command_velocity(
        self, body: pymunk.Body, _gravity: tuple[float, float], _damping: float, _dt: float
    ) -> None:
        body.velocity = self._velocity
