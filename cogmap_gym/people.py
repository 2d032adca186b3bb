"""People who walk between rooms: discs that stop or go round, and never run into the robot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cogmap_gym.geometry import Points, Segments
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

    @property
    def outline(self) -> Points:
        """The corners (CORNERS, 2) of what laser and robot meet [m]."""
        angles = math.tau * np.arange(CORNERS) / CORNERS
        return np.array(self.at) + RADIUS_M * np.stack((np.cos(angles), np.sin(angles)), axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What a person heeds."""

    robot: Point
    """Where the robot is [m]."""
    robot_radius: float
    """Radius of its body [m]."""
    others: Segments
    """Where the other people are, as segments of no length (P, 2, 2) [m]."""
    solid: Segments
    """Walls, furniture, shut doors, (N, 2, 2) [m]."""
    boxes: Segments
    """Edges of boxes, (M, 2, 2) [m]."""

    def refuse(self, now: Point, then: Point) -> bool:
        """Whether a step would bring a person too near to something, and nearer than it is."""
        off = RADIUS_M + self.robot_radius + KEEP_OFF_M
        if math.dist(then, self.robot) < min(off, math.dist(now, self.robot)):
            return True
        return (
            _nearer(now, then, self.others, 2.0 * RADIUS_M + GAP_M)
            or _nearer(now, then, self.solid, RADIUS_M - GAP_M)  # ways touch corners, nearly
            or _nearer(now, then, self.boxes, RADIUS_M + GAP_M)
        )


def _nearer(now: Point, then: Point, segments: Segments, least: float) -> bool:
    """Whether a step ends nearer than ``least`` to some segment, and nearer than it began."""
    gap = least_gap(then[0], then[1], segments, least)
    return bool(gap < least and gap < least_gap(now[0], now[1], segments, least))


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


def walk(
    person: Person,
    seconds: float,
    about: Surroundings,
    choose: Callable[[Point], tuple[Point, ...]],
) -> Person:
    """A person some moments later.

    Args:
        person: as they are.
        seconds: how long; short, for they look about once.
        about: what they heed.
        choose: a new way from a point.
    """
    if not person.way or person.waited >= PATIENCE_S:
        return Person(person.at, choose(person.at))
    (x, y), (gx, gy) = person.at, person.way[0]
    left, step = math.dist(person.at, person.way[0]), SPEED * seconds
    if left <= step:
        if about.refuse(person.at, (gx, gy)):
            return replace(person, waited=person.waited + seconds)
        return Person((gx, gy), person.way[1:])
    heading = math.atan2(gy - y, gx - x)
    for detour in DETOURS_RAD:
        then = x + step * math.cos(heading + detour), y + step * math.sin(heading + detour)
        if not about.refuse(person.at, then):
            waited = 0.0 if detour == 0.0 else person.waited + seconds
            return Person(then, person.way, waited)
    return replace(person, waited=person.waited + seconds)
