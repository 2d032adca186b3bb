"""Where boxes stand and people are when an episode begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cogmap_gym.boxes import Box, drawn_box
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points
from cogmap_gym.grid import Grid
from cogmap_gym.people import Person
from cogmap_gym.world import World

FREE_M = 0.45
"""Spots are this far from walls and furniture [m]."""
WALKABLE_M = 0.3
"""Spots hang together over cells that are this far from walls [m]."""
ALONG_WALLS_M = 0.8
"""Boxes stand nearer to a wall than this, out of the way [m]."""
CLEAR_OF_DOORS_M = 1.2
"""Nothing begins nearer to a door than this [m]."""
CLEAR_OF_HOME_M = 1.5
"""Nothing begins nearer to the robot than this [m]."""
APART_M = 1.0
"""Things and people are this far from one another at first [m]."""
EVERY_CELL = 3
"""Spots lie this many cells apart, so that there are not too many."""
MOST_BOXES, MOST_PEOPLE = 40, 12
"""More would be slow."""


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """Where something or somebody can stand."""

    points: Points
    """(P, 2) [m]."""
    along_walls: NDArray[np.bool_]
    """(P,): which are near to a wall."""


def free_spots(world: World) -> Spots:
    """The spots that can be reached from home with the doors as the plan has them."""
    plan, solid = world.plan, world.solid_segments
    grid = Grid.over(solid)
    labels, _ = ndimage.label(~grid.near(solid, WALKABLE_M))
    inside = labels == labels[grid.cell(plan.home.x, plan.home.y)]
    free = inside & ~grid.near(solid, FREE_M)
    doors = plan.door_segments()
    if len(doors):
        free &= ~grid.near(doors, CLEAR_OF_DOORS_M)
    near = grid.near(solid, ALONG_WALLS_M)
    chosen = np.zeros_like(free)
    chosen[::EVERY_CELL, ::EVERY_CELL] = free[::EVERY_CELL, ::EVERY_CELL]
    xs, ys = grid.centres()
    return Spots(np.stack((xs[chosen], ys[chosen]), axis=-1), near[chosen])


def drawn_boxes(
    plan: FloorPlan, spots: Spots, home: Points, area: float, rng: np.random.Generator
) -> tuple[Box, ...]:
    """Boxes and chairs along the walls, one for each ``area`` [m^2] of free space; 0: none."""
    count = min(max(round(plan.area / area), 1), MOST_BOXES) if area else 0
    points = spots.points[spots.along_walls]
    places = _scattered(points, count, home[None], rng)
    return tuple(drawn_box((float(x), float(y)), rng) for x, y in places)


def drawn_people(
    plan: FloorPlan,
    spots: Spots,
    home: Points,
    boxes: tuple[Box, ...],
    area: float,
    rng: np.random.Generator,
) -> tuple[Person, ...]:
    """People anywhere, one for each ``area`` [m^2] of free space; 0: nobody."""
    count = min(max(round(plan.area / area), 1), MOST_PEOPLE) if area else 0
    taken = np.array([home, *(box.pose.position for box in boxes)])
    places = _scattered(spots.points, count, taken, rng)
    return tuple(Person((float(x), float(y))) for x, y in places)


def _scattered(points: Points, count: int, taken: Points, rng: np.random.Generator) -> Points:
    """Up to ``count`` of the points, each clear of what is taken (T, 2) and of the others.

    The first of ``taken`` is the robot, which gets more room.
    """
    chosen: list[Points] = []
    for point in points[rng.permutation(len(points))] if count else ():
        others = np.array([*taken[1:], *chosen]).reshape(-1, 2)
        lonely = not len(others) or np.hypot(*(others - point).T).min() >= APART_M
        if lonely and np.hypot(*(taken[0] - point)) >= CLEAR_OF_HOME_M:
            chosen.append(point)
        if len(chosen) == count:
            break
    return np.array(chosen).reshape(-1, 2)
