"""A building elsewhere: the same plan turned and shifted, or seen in a mirror."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose

_MIRROR = np.array((1.0, -1.0))


def moved(plan: FloorPlan, new_from_old: Pose) -> FloorPlan:
    """The plan turned and shifted as a whole, home with it."""
    return _mapped(plan, new_from_old.apply, new_from_old @ plan.home)


def mirrored(plan: FloorPlan) -> FloorPlan:
    """The plan with y turned to -y, home with it; what was on the left is on the right.

    Polylines and polygons run the other way round, so that what lay on their left still does.
    """
    home = Pose(plan.home.x, -plan.home.y, -plan.home.theta)
    return _mapped(plan, lambda points: (points * _MIRROR)[::-1], Pose() @ home)


def drawn_motion(rng: np.random.Generator, farthest: float = 50.0) -> Pose:
    """Any turn, and a shift of at most ``farthest`` [m] along x and y."""
    x, y, turn = rng.uniform((-farthest, -farthest, -np.pi), (farthest, farthest, np.pi))
    return Pose(float(x), float(y), float(turn))


def _mapped(plan: FloorPlan, change: Callable[[Points], Points], home: Pose) -> FloorPlan:
    return replace(
        plan,
        walls=tuple(map(change, plan.walls)),
        furniture=tuple(map(change, plan.furniture)),
        doors={name: change(leaf) for name, leaf in plan.doors.items()},
        barriers={name: change(barrier) for name, barrier in plan.barriers.items()},
        rooms={name: change(room) for name, room in plan.rooms.items()},
        home=home,
    )
