"""Boxes and chairs that the robot can push, and the body that pushes them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pymunk

from cogmap_gym.body import BODY, SOLID, Body
from cogmap_gym.geometry import Array, Points, Pose, Segments
from cogmap_gym.observation import RobotSpec

BOX_MASS = 0.03
"""Mass of a box, the robot's being 1: three at once still move [1]. Ours."""
CHAIR_CORNERS, CHAIR_RADIUS_M = 5, 0.25
"""The foot of a chair: a star's five corners [m]."""
LEAST_M, MOST_M = 0.35, 0.55
"""Least and largest side of a box [m]."""
DEEPEST_M = 0.004
"""A push ends before anything is deeper than this in something else [m]. Ours: without, a robot
that kept on driving at a jammed box went 3 mm farther into it with every move."""
BOX_REACH_M = MOST_M / math.sqrt(2.0)
"""No corner of a box or chair is farther from its middle than this [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """Something that stands about and slides when it is pushed."""

    shape: Points
    """Its corners (K, 2) in its own frame, convex, counter-clockwise [m]."""
    pose: Pose
    """Where it stands, ``plan_from_box``."""
    outline: Points = field(init=False)
    """Its corners (K, 2) in the plan's frame [m]."""

    def __post_init__(self) -> None:
        """Few boxes move at a time, so the corners are computed once."""
        object.__setattr__(self, "outline", self.pose.apply(self.shape))


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


def edges(outlines: Sequence[Points] | Array) -> Segments:
    """The edges of some polygons (K, 2), (N, 2, 2) [m]."""
    if not len(outlines):
        return np.zeros((0, 2, 2))
    corners, ends = np.concatenate(outlines), np.cumsum([len(ring) for ring in outlines])
    following = np.arange(1, len(corners) + 1)
    following[ends - 1] = (0, *ends[:-1])
    return np.stack((corners, corners[following]), axis=1)


class PushingBody(Body):
    """A disc among segments, boxes that it pushes, and people whom it does not.

    A box moves only while it is pushed: nothing has a velocity that outlives a step.

    Args:
        robot: radius and top speeds.
        segments: (N, 2, 2), all solid [m].
        boxes: what can be pushed, by number.
        people: corners of each person, as they stand now, by number.
    """

    def __init__(
        self,
        robot: RobotSpec,
        segments: Segments,
        boxes: Mapping[int, Box],
        people: Mapping[int, Points],
    ) -> None:
        """Put all in place, and the disc at the origin."""
        super().__init__(robot, segments)
        self._space.damping = 0.0  # each step forgets a box's velocity; contact gives it anew
        self._boxes = dict(boxes)
        self._loose = {number: self._new_box(box) for number, box in boxes.items()}
        self._people = {number: self._new_person(corners) for number, corners in people.items()}
        self._depth = 0.0

    def moved_boxes(self) -> dict[int, Box]:
        """Those of the boxes that were moved since this was last asked, by number."""
        now = {number: _moved(box, self._loose[number]) for number, box in self._boxes.items()}
        moved = {number: box for number, box in now.items() if box is not self._boxes[number]}
        self._boxes = now
        return moved

    def set_people(self, outlines: Sequence[Points]) -> None:
        """People stand elsewhere now; the outlines are those of all of them, by number."""
        for number, shape in self._people.items():
            shape.unsafe_set_vertices(outlines[number].tolist())
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
        """As for a still world, but taken back where it would squeeze things into one another."""
        if not touching:
            self._depth = math.inf  # the first step moves nothing
            for body in self._loose.values():
                body.velocity, body.angular_velocity = (0.0, 0.0), 0.0
        before = [(body.position, body.angle) for body in self._loose.values()]
        here, deepest = self._body.position, max(self._depth, DEEPEST_M)
        left, opposed = super()._substep(ux, uy, left, touching)
        self._depth = self._overlap()
        if self._depth > deepest:
            self._body.position = here
            for body, (position, angle) in zip(self._loose.values(), before, strict=True):
                body.position, body.angle = position, angle
        return left, opposed or self._depth > deepest

    def _overlap(self) -> float:
        """How deep the robot or a box is in anything, at most [m]."""
        depths = [0.0]

        def note(arbiter: pymunk.Arbiter) -> None:
            depths.extend(-point.distance for point in arbiter.contact_point_set.points)

        for body in (self._body, *self._loose.values()):
            body.each_arbiter(note)
        return max(depths)


def _moved(box: Box, body: pymunk.Body) -> Box:
    """The box where its body is; the same box if it did not move, to the bit."""
    now, pose = (*body.position, body.angle), box.pose
    return box if now == (pose.x, pose.y, pose.theta) else Box(box.shape, Pose() @ Pose(*now))
