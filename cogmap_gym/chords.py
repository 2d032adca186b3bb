"""Doors and rooms of a plan: which rooms can be visited, and what its shut doors join."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely
from shapely.geometry import LineString, Point, Polygon

from cogmap_gym.floor_plan import FloorPlan

DOOR_SIDE_M = 0.3
"""A door joins the rooms this far to either side of the middle of its leaf [m]. Ours."""
ARC_SIDES = 16
"""Sides of the polygon about a quarter of a circle [-]."""
KEPT_PLANS = 4096
"""For so many plans the rooms that can be visited are kept."""


def sides_of(plan: FloorPlan, door: str) -> tuple[str, str]:
    """The rooms on the two sides of a door; empty text where there is none."""
    (a, b), middle = plan.doors[door], plan.doors[door].mean(axis=0)
    aside = DOOR_SIDE_M * np.array((a[1] - b[1], b[0] - a[0])) / np.hypot(*(b - a))
    one, other = (plan.room_at(*(middle + sign * aside)) or "" for sign in (1.0, -1.0))
    return one, other


def doors_of(plan: FloorPlan, room: str) -> tuple[str, ...]:
    """The doors of a room, in the order of the plan."""
    return tuple(door for door in plan.doors if room in sides_of(plan, door))


def chords(plan: FloorPlan) -> tuple[tuple[str, ...], ...]:
    """The doors that are shut at first, in groups that open together.

    Doors of a room all of whose doors are shut are of one chord, since one alone leads
    nowhere: both doors of a hidden corridor, for example.
    """
    groups = [{door} for door in plan.closed]
    for room in plan.rooms:
        doors = set(doors_of(plan, room))
        if len(doors) > 1 and doors <= set(plan.closed):
            joined = [group for group in groups if group & doors]
            groups = [group for group in groups if group not in joined]
            groups.append(set().union(*joined))
    return tuple(sorted(tuple(door for door in plan.closed if door in group) for group in groups))


@lru_cache(maxsize=KEPT_PLANS)
def rooms_to_visit(plan: FloorPlan, radius: float, door_gap: float) -> tuple[str, ...]:
    """The rooms with a spot that can be reached from home with the doors as they are at first.

    Args:
        plan: the building; the room of home is left out.
        radius: of the robot [m].
        door_gap: how far from any door the spot must be [m].
    """
    shut = [plan.doors[name] for name in plan.closed]
    lines = shapely.linestrings([*plan.walls_and_furniture(), *shut])
    doors = shapely.union_all([LineString(leaf) for leaf in plan.doors.values()])
    # One by one and then united: a hundred times faster than the buffer of thousands as one.
    solid = shapely.union_all(shapely.buffer(lines, radius, quad_segs=ARC_SIDES))
    parts = shapely.get_parts(plan.free_space().difference(solid))
    home = Point(plan.home.position)
    reached = min(parts, key=lambda part: float(part.distance(home)))
    spots = reached.difference(doors.buffer(door_gap))
    at_home = plan.room_at(plan.home.x, plan.home.y)
    return tuple(
        name
        for name, points in plan.rooms.items()
        if name != at_home and Polygon(points).intersection(spots).area > radius**2
    )
