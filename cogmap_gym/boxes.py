"""Boxes and chairs that the robot can push, and the body that pushes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk

from cogmap_gym.body import BODY, SOLID, Body
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.observation import RobotSpec

BOX_MASS = 0.03
"""Mass of a box, the robot's being 1: three at once still move [1]. Ours."""
CHAIR_CORNERS, CHAIR_RADIUS_M = 5, 0.25
"""The foot of a chair: a star's five corners [m]."""
LEAST_M, MOST_M = 0.35, 0.55
"""Least and largest side of a box [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """Something that stands about and slides when it is pushed."""

    shape: Points
    """Its corners (K, 2) in its own frame, convex, counter-clockwise [m]."""
    pose: Pose
    """Where it stands, ``plan_from_box``."""

    @property
    def outline(self) -> Points:
        """Its corners (K, 2) in the plan's frame [m]."""
        return self.pose.apply(self.shape)


def drawn_box(at: tuple[float, float], rng: np.random.Generator) -> Box:
    """A box or a chair of a size and heading made by chance."""
    heading, chair = float(rng.uniform(-math.pi, math.pi)), bool(rng.random() < 0.5)
    half = rng.uniform(LEAST_M / 2.0, MOST_M / 2.0, 2)
    if chair:
        angles = math.tau * np.arange(CHAIR_CORNERS) / CHAIR_CORNERS
        shape = CHAIR_RADIUS_M * np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    else:
        shape = half * np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    return Box(shape, Pose(*at, heading))


def edges(outlines: Sequence[Points]) -> Segments:
    """The edges of some polygons (K, 2), (N, 2, 2) [m]."""
    rings = [np.stack((ring, np.roll(ring, -1, axis=0)), axis=1) for ring in outlines]
    return np.concatenate(rings) if rings else np.zeros((0, 2, 2))


class PushingBody(Body):
    """A disc among segments, boxes that it pushes, and people whom it does not.

    A box moves only while it is pushed: nothing has a velocity that outlives a step.

    Args:
        robot: radius and top speeds.
        segments: (N, 2, 2), all solid [m].
        boxes: what can be pushed.
        people: corners of each person, as they stand now.
    """

    def __init__(
        self, robot: RobotSpec, segments: Segments, boxes: Sequence[Box], people: Sequence[Points]
    ) -> None:
        """Put all in place, and the disc at the origin."""
        super().__init__(robot, segments)
        self._space.damping = 0.0  # each step forgets a box's velocity; contact gives it anew
        self._boxes = tuple(boxes)
        self._loose = [self._new_box(box) for box in boxes]
        self._people = [self._new_person(corners) for corners in people]

    @property
    def boxes(self) -> tuple[Box, ...]:
        """The boxes where they are now."""
        return tuple(map(_moved, self._boxes, self._loose))

    def set_person(self, number: int, corners: Points) -> None:
        """Somebody stands elsewhere now."""
        shape = self._people[number]
        shape.unsafe_set_vertices(corners.tolist())
        self._space.reindex_shape(shape)

    def _new_box(self, box: Box) -> pymunk.Body:
        corners = box.shape.tolist()
        body = pymunk.Body(BOX_MASS, pymunk.moment_for_poly(BOX_MASS, corners))
        body.position, body.angle = (box.pose.x, box.pose.y), box.pose.theta
        shape = pymunk.Poly(body, corners)
        shape.filter = pymunk.ShapeFilter(categories=SOLID, mask=SOLID | BODY)
        self._space.add(body, shape)
        return body

    def _new_person(self, corners: Points) -> pymunk.Poly:
        shape = pymunk.Poly(self._space.static_body, corners.tolist())
        shape.filter = pymunk.ShapeFilter(categories=SOLID)
        self._space.add(shape)
        return shape

    def _substep(self, ux: float, uy: float, left: float, touching: bool) -> tuple[float, bool]:
        if not touching:
            for body in self._loose:
                body.velocity, body.angular_velocity = (0.0, 0.0), 0.0
        return super()._substep(ux, uy, left, touching)


def _moved(box: Box, body: pymunk.Body) -> Box:
    """The box where its body is; the same box if it did not move, to the bit."""
    now, pose = (*body.position, body.angle), box.pose
    return box if now == (pose.x, pose.y, pose.theta) else Box(box.shape, Pose() @ Pose(*now))
