"""People who walk between rooms: discs that stop or go round, and never run into the robot."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cogmap_gym.geometry import Array, Points, Segments
from cogmap_gym.raycast_kernel import compiled

RADIUS_M = 0.25
"""Radius about a person [m]."""
SPEED = 0.8
"""How fast people walk [m/s]."""
KEEP_OFF_M = 0.4
"""Room that people leave between themselves and the robot [m]."""
GAP_M = 0.05
"""Room between people, and between them and what stands about [m]."""
PATIENCE_S = 3.0
"""After so long without getting on a person turns to another place [s]."""
DETOURS_RAD = (0.0, 0.7, -0.7, 1.4, -1.4)
"""Directions in which people try to get on, against that of their way [rad]."""
CORNERS = 8
"""A person is this many corners to the laser and to the robot's body."""
_ANGLES = math.tau * np.arange(CORNERS) / CORNERS
RING = RADIUS_M * np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=-1)
"""The corners of a person at the origin, (CORNERS, 2) [m]."""
STUCK, ASIDE, ON, THERE = range(4)
"""How a step came out: not at all, in another direction, straight on, up to the next point."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody on their way."""

    at: Point
    """Where they are [m]."""
    way: tuple[Point, ...] = ()
    """Where they go by, in order [m]; empty: they have not made up their mind."""
    waited: float = 0.0
    """How long they could not get on [s]."""


def places(people: Sequence[Person]) -> Points:
    """Where people are, (P, 2) [m]."""
    return np.array([person.at for person in people], dtype=np.float64).reshape(-1, 2)


def outlines(people: Sequence[Person]) -> Array:
    """The corners of what laser and robot meet of each, (P, CORNERS, 2) [m]."""
    return np.asarray(places(people)[:, None] + RING)


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What a person heeds."""

    robot: Point
    """Where the robot is [m]."""
    robot_radius: float
    """Radius of its body [m]."""
    people: Points
    """Where everybody is, they too (P, 2) [m]."""
    solid: Segments
    """Walls, furniture, shut doors, (N, 2, 2) [m]."""
    boxes: Segments
    """Edges of boxes, (M, 2, 2) [m]."""


@compiled
def least_gap(x: float, y: float, segments: Segments, most: float) -> float:
    """Distance from a point to the nearest of some segments (N, 2, 2), at most ``most`` [m]."""
    best = most * most
    for n in range(segments.shape[0]):
        px, py = segments[n, 0, 0] - x, segments[n, 0, 1] - y
        ex, ey = segments[n, 1, 0] - x - px, segments[n, 1, 1] - y - py
        squared, t = ex * ex + ey * ey, 0.0
        if squared > 0.0:
            t = min(max(-(px * ex + py * ey) / squared, 0.0), 1.0)
        best = min(best, (px + t * ex) ** 2 + (py + t * ey) ** 2)
    return math.sqrt(best)


@compiled
def _nearer(
    x: float, y: float, then_x: float, then_y: float, segments: Segments, least: float
) -> bool:
    """Whether a step ends nearer than ``least`` to some segment, and nearer than it began."""
    gap = least_gap(then_x, then_y, segments, least)
    return gap < least and gap < least_gap(x, y, segments, least)


@compiled
def _refused(
    x: float,
    y: float,
    then_x: float,
    then_y: float,
    off: float,
    robot: Point,
    people: Points,
    number: int,
    solid: Segments,
    boxes: Segments,
) -> bool:
    """Whether a step would bring person ``number`` too near to something, and nearer than now."""
    gap = math.hypot(then_x - robot[0], then_y - robot[1])
    touching = gap < off - KEEP_OFF_M  # round the robot, a corner would come where an edge was
    if touching or (gap < off and gap < math.hypot(x - robot[0], y - robot[1])):
        return True
    for other in range(people.shape[0]):
        px, py = people[other, 0], people[other, 1]
        gap = math.hypot(then_x - px, then_y - py)
        if other != number and gap < 2.0 * RADIUS_M + GAP_M and gap < math.hypot(x - px, y - py):
            return True
    return (
        _nearer(x, y, then_x, then_y, solid, RADIUS_M - GAP_M)  # ways touch corners, nearly
        or _nearer(x, y, then_x, then_y, boxes, RADIUS_M + GAP_M)
    )


@compiled
def _step(
    x: float,
    y: float,
    goal: Point,
    step: float,
    off: float,
    robot: Point,
    people: Points,
    number: int,
    solid: Segments,
    boxes: Segments,
) -> tuple[float, float, int]:
    """Where person ``number`` at (x, y) is after ``step`` [m], and how that came out."""
    gx, gy = goal
    if math.hypot(gx - x, gy - y) <= step:
        if _refused(x, y, gx, gy, off, robot, people, number, solid, boxes):
            return x, y, STUCK
        return gx, gy, THERE
    heading = math.atan2(gy - y, gx - x)
    for detour in DETOURS_RAD:
        then_x = x + step * math.cos(heading + detour)
        then_y = y + step * math.sin(heading + detour)
        if not _refused(x, y, then_x, then_y, off, robot, people, number, solid, boxes):
            return then_x, then_y, ON if detour == 0.0 else ASIDE
    return x, y, STUCK


def walk(
    person: Person,
    number: int,
    seconds: float,
    about: Surroundings,
    choose: Callable[[Point], tuple[Point, ...]],
) -> Person:
    """A person some moments later.

    Args:
        person: as they are.
        number: which of the people in the surroundings they are.
        seconds: how long; short, for they look about once.
        about: what they heed.
        choose: a new way from a point.
    """
    if not person.way or person.waited >= PATIENCE_S:
        return Person(person.at, choose(person.at))
    off = RADIUS_M + about.robot_radius + KEEP_OFF_M
    x, y, how = _step(
        *person.at, person.way[0], SPEED * seconds, off, about.robot,
        about.people, number, about.solid, about.boxes,
    )  # fmt: skip
    if how == THERE:
        return Person(person.way[0], person.way[1:])
    waited = 0.0 if how == ON else person.waited + seconds
    return Person((x, y), person.way, waited)
