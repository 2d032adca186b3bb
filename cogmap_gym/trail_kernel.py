"""The compiled twins of ``FloorPlan.room_at`` and of ``cogmap_gym.trail``."""

from __future__ import annotations

import math
from typing import Final

from cogmap_gym.disc_kernel import _squared_gap
from cogmap_gym.geometry import Array, Points
from cogmap_gym.kernel_parts import part
from cogmap_gym.raycast_kernel import Ints
from cogmap_gym.trail import ENTERED_M, TRAIL_STEP_M

NOWHERE: Final = -1
"""The row of no room."""
MOST_ENTERED: Final = 31
"""Rooms that one move may enter [-]: twice a sample of 3 m."""


@part
def room_at(
    x: float, y: float, boxes: Array, corners: Ints, edges: Array, room: int, end: int
) -> int:  # fmt: skip
    """Which of the rooms ``room`` to ``end`` holds (x, y) first, from 0; or NOWHERE.

    Args:
        x: [m].
        y: [m].
        boxes: (R, 4), about each room: x least, y least, x most, y most [m].
        corners: (R + 1,), where the edges of each room begin.
        edges: (E, 4), from one corner to the next [m].
        room: the first of the plan's rooms in ``boxes``.
        end: one past its last.
    """
    for n in range(room, end):
        if x < boxes[n, 0] or x > boxes[n, 2] or y < boxes[n, 1] or y > boxes[n, 3]:
            continue
        inside = False
        for k in range(corners[n], corners[n + 1]):
            px, py, qx, qy = edges[k]
            if (py > y) != (qy > y) and x < px + (y - py) * (qx - px) / (qy - py):
                inside = not inside
        if inside:
            return int(n - room)
    return NOWHERE


@part
def door_gap(x: float, y: float, segments: Array, begin: int, end: int) -> float:
    """Distance from (x, y) to the nearest of the rows begin..end of ``segments`` (N, 4) [m]."""
    squared = math.inf
    for k in range(begin, end):
        px, py, qx, qy = segments[k]
        squared = min(squared, _squared_gap(x, y, px, py, qx, qy))
    return math.sqrt(squared)


@part
def follow(
    path: Points, points: int, last: int, boxes: Array, corners: Ints, edges: Array,
    first_room: int, end_room: int, segments: Array, begin: int, end: int, entered: Ints,
) -> float:  # fmt: skip
    """Note the rooms that a path enters, and answer its length [m]; see ``Trail.follow``.

    Args:
        path: (points, 2) or longer [m].
        points: how many there are.
        last: the room that was entered last, or NOWHERE.
        boxes: as in ``room_at``.
        corners: as there.
        edges: as there.
        first_room: as there.
        end_room: as there.
        segments: (N, 4), of which rows begin..end are the doors [m].
        begin: the first door.
        end: one past the last.
        entered: (MOST_ENTERED + 1,), written: how many rooms, then which.
    """
    length = 0.0
    for k in range(1, points):
        length += math.hypot(path[k, 0] - path[k - 1, 0], path[k, 1] - path[k - 1, 1])
    samples = max(math.ceil(length / TRAIL_STEP_M), 1)
    entered[0], k, along, step = 0, 1, 0.0, 0.0
    for n in range(1, samples + 1):
        x, y = path[points - 1, 0], path[points - 1, 1]
        at = length * n / samples
        if n < samples:
            step = math.hypot(path[k, 0] - path[k - 1, 0], path[k, 1] - path[k - 1, 1])
            while along + step < at and k < points - 1:
                along += step
                k += 1
                step = math.hypot(path[k, 0] - path[k - 1, 0], path[k, 1] - path[k - 1, 1])
            share = (at - along) / step if step > 0.0 else 0.0
            x = path[k - 1, 0] + share * (path[k, 0] - path[k - 1, 0])
            y = path[k - 1, 1] + share * (path[k, 1] - path[k - 1, 1])
        room = room_at(x, y, boxes, corners, edges, first_room, end_room)
        if room in (NOWHERE, last) or entered[0] >= MOST_ENTERED:
            continue
        if door_gap(x, y, segments, begin, end) >= ENTERED_M:
            entered[0] += 1
            entered[entered[0]] = room
            last = room
    return length
