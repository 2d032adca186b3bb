"""Ways over the grid: to the nearest frontier, to a spot, to what was not seen for long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.frontier import params
from agents.frontier.flood_kernel import (
    STRAIGHT,
    UNREACHED,
    Prices,
    flood,
    frontier_cells,
    price_cells,
)
from agents.frontier.grid import OccupancyGrid
from cogmap_gym.geometry import Points

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way over the grid."""

    points: Points
    """Centres of its cells from the robot's to the last, (K, 2) [m]."""
    cost: float
    """Metres, those in narrow places counted several times."""
    target: Points
    """What it is for, (2,) [m]: its last cell, a mark in it, or what is looked at from there."""
    through_unknown: bool = False
    """Whether it may lead through cells never seen."""

    def ahead(self, position: Points) -> Points:
        """What is left of the way from about ``position`` (2,) on, (K', 2)."""
        return self.points[int(np.argmin(np.hypot(*(self.points - position).T))) :]


def prices(
    grid: OccupancyGrid, numbers: params.Planner, now: int, *, through_unknown: bool
) -> Prices:
    """What it costs to enter each cell, (H, W), tenths of a free one; 0 for no way.

    Args:
        grid: what is known.
        numbers: the robot's size and its tastes.
        now: number of the step; what was barred long ago is so no more.
        through_unknown: whether cells never seen may be entered.
    """
    gaps = np.array((numbers.wall, numbers.body, numbers.comfort)) / grid.cell
    costs = np.array((numbers.crowded, numbers.tight, numbers.unknown if through_unknown else 0.0))
    since = now - numbers.barred
    return price_cells(grid.votes, grid.clearance, grid.barred, since, gaps, STRAIGHT * costs)


def frontiers(grid: OccupancyGrid, numbers: params.Planner) -> Mask:
    """The free cells beside the unknown, (H, W), but those looked at in vain."""
    off_wall = numbers.off_wall / grid.cell
    return frontier_cells(grid.votes, grid.clearance, grid.ignored, off_wall, numbers.fewest)


def way_to(grid: OccupancyGrid, price: Prices, start: Points, ends: Mask) -> Way | None:
    """The cheapest way from a point (2,) to any of the ``ends`` (H, W); None if there is none."""
    width = price.shape[1]
    costs, origin, end = flood(price, index_of(grid, start), ends)
    if end < 0:
        return None
    cells = [end]
    while origin[cells[-1]] >= 0:
        cells.append(int(origin[cells[-1]]))
    index = np.stack(np.divmod(np.array(cells[::-1]), width), axis=1)
    points = grid.centres(index)
    return Way(points, float(costs[end]) * grid.cell / STRAIGHT, points[-1])


def reached_from(grid: OccupancyGrid, price: Prices, start: Points) -> Mask:
    """The cells to which there is a way from a point (2,), (H, W)."""
    costs, _, _ = flood(price, index_of(grid, start), np.zeros(price.shape, dtype=np.bool_))
    return np.asarray(costs != UNREACHED).reshape(price.shape)


def index_of(grid: OccupancyGrid, point: Points) -> int:
    """The index of the cell of a point (2,) in the flat grid."""
    rows, columns = grid.cells(point[None])
    return int(rows[0] * grid.votes.shape[1] + columns[0])


def is_open(grid: OccupancyGrid, price: Prices, points: Points) -> bool:
    """Whether a way (K, 2) can still be taken."""
    return bool((price[grid.cells(points)] > 0).all())


def straight_reach(grid: OccupancyGrid, price: Prices, points: Points, start: Points) -> int:
    """The farthest point of a way that the straight line from ``start`` (2,) leads to.

    The line must lead over no dearer cell than the way does up to there.

    Returns:
        Its row; 0 if the line leads to none.
    """
    dearest = np.maximum.accumulate(price[grid.cells(points)])
    for row in range(len(points) - 1, 0, -1):
        length = float(np.hypot(*(points[row] - start)))
        share = np.linspace(0.0, 1.0, int(length / (0.5 * grid.cell)) + 2)
        line = price[grid.cells(start + share[:, None] * (points[row] - start))]
        if line[1:].min() > 0 and line[1:].max() <= dearest[row]:
            return row
    return 0
