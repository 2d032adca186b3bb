"""Which door of a living office may shut by itself now."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cogmap_gym.events import Event
from cogmap_gym.geometry import Points, Pose, point_segment_distances
from cogmap_gym.routes import Routes
from cogmap_gym.world import World

SHUT_S, OPEN_S = (10.0, 30.0), (15.0, 45.0)
"""Least and longest time for which a door stays shut, and all stay open [s]."""
RETRY_S = 1.0
"""When a door that could not shut is thought of again [s]."""
BESIDE_DOOR_M = 0.6
"""A door may shut by itself where one can walk from this far before it to as far behind [m]."""
CLEAR_OF_DOORS_M = 0.6
"""A door waits while somebody, or a box's corner, is nearer to it than this [m]."""


def may_shut(world: World, routes: Routes, name: str, about: Sequence[Points]) -> bool:
    """Whether a door is clear, and no place is cut off without it.

    Args:
        world: with the robot and the doors.
        routes: its ways.
        name: of the door, which is open.
        about: corners of boxes, and where people are, (K, 2) each [m].
    """
    leaf = world.segment(name)
    gaps = [point_segment_distances(points, leaf).min() for points in about if len(points)]
    if not Event("shut", name).is_clear(world) or min(gaps, default=math.inf) < CLEAR_OF_DOORS_M:
        return False
    (a, b) = leaf[0]
    normal = np.array((a[1] - b[1], b[0] - a[0])) / math.dist(a, b)
    sides = [(a + b) / 2.0 + sign * BESIDE_DOOR_M * normal for sign in (1.0, -1.0)]
    before, behind = (Pose(float(x), float(y)) for x, y in sides)
    return math.isfinite(routes.distance(before, behind, world.shut_doors | {name}))
