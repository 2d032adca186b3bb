"""Where to look again: when all is known, and when the way that was known is none any more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import distance_transform_edt

from agents.frontier import params
from agents.frontier.flood_kernel import Prices
from agents.frontier.grid import NEVER, OccupancyGrid
from agents.frontier.planner import Mask, Way, reached_from, way_to
from cogmap_gym.geometry import Points


def way_to_unvisited(
    grid: OccupancyGrid, numbers: params.Planner, price: Prices, start: Points
) -> Way | None:
    """To the nearest spot that the robot never was near; else to what it left longest ago.

    Args:
        grid: what is known.
        numbers: of the planner.
        price: (H, W) of the cells.
        start: where the robot is, (2,) [m].
    """
    roomy = grid.clearance * grid.cell >= numbers.body
    spots = (grid.votes < 0) & (grid.barred == NEVER) & roomy
    gaps = distance_transform_edt(grid.visits == NEVER, sampling=grid.cell)
    for gap in numbers.unvisited:
        way = way_to(grid, price, start, spots & (gaps > gap))
        if way is not None:
            return way
    spots &= reached_from(grid, price, start)
    visits = np.where(spots, grid.visits, np.iinfo(np.int32).max)
    return way_to(grid, price, start, visits == visits.min())


def way_to_doubtful_wall(
    grid: OccupancyGrid,
    numbers: params.Planner,
    price: Prices,
    ends: tuple[Points, Points],
    since: int,
) -> Way | None:
    """To the nearest wall, not seen since a step, between where the robot can be and its mark.

    If a door has opened, it is in one of these.

    Args:
        grid: what is known.
        numbers: of the planner.
        price: (H, W) of the cells.
        ends: where the robot and the mark are, (2,) each [m].
        since: number of a step.
    """
    here, there = (reached_from(grid, price, end) for end in ends)
    if (here & there).any():
        return None
    doubtful = (grid.votes > 0) & ((grid.stamps < since) | (grid.votes == 1))
    doubtful &= ~here & _within(grid, here, numbers.beside) & _within(grid, there, numbers.behind)
    way = way_to(grid, price, ends[0], here & _within(grid, doubtful, numbers.beside))
    if way is None:
        return None
    walls = grid.centres(np.argwhere(doubtful))
    nearest = np.argmin(np.hypot(*(walls - way.target).T))
    return replace(way, target=walls[nearest])


def way_to_stale(grid: OccupancyGrid, price: Prices, start: Points, since: int) -> Way | None:
    """To the nearest spot that was not seen since a step; None if all that can be has been."""
    return way_to(grid, price, start, (grid.votes < 0) & (grid.stamps < since))


def _within(grid: OccupancyGrid, mask: Mask, distance: float) -> Mask:
    """The cells nearer than a distance [m] to those of the mask, (H, W)."""
    if not mask.any():
        return mask
    gaps = distance_transform_edt(~mask, sampling=grid.cell)
    return np.asarray(gaps <= distance)
