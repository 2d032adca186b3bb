"""A local grid of clearances round the robot, and the cheapest way over it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from skimage.graph import MCP_Geometric

from agents.cogmap.params import Navigation
from cogmap_gym.geometry import Array, Points

Cells = NDArray[np.int64]
"""Grid cells, shape (N, 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class ClearanceGrid:
    """Clearance over square cells; cell (0, 0) has its centre at ``corner``."""

    corner: Points
    cell: float
    clearance: Array

    def cells(self, points: Points) -> Cells:
        """The cell of each point (..., 2), held inside the grid."""
        index = np.rint((points - self.corner) / self.cell).astype(np.int64)
        return np.clip(index, 0, np.array(self.clearance.shape) - 1)

    def centres(self, cells: Cells) -> Points:
        """The centres of cells (..., 2)."""
        return np.asarray(self.corner + self.cell * cells)


def clearance_grid(
    obstacles: Points, start: Points, goal: Points, params: Navigation
) -> ClearanceGrid:
    """Distance from each cell's centre to the nearest obstacle, to a few millimetres."""
    low, high = np.minimum(start, goal), np.maximum(start, goal)
    most = np.maximum(params.max_grid, high - low + 2 * params.goal_reach)
    half = np.minimum(high - low + 2 * params.detour, most) / 2
    centre = (low + high) / 2
    shape = np.ceil(2 * half / params.cell).astype(np.int64) + 1
    # Cell centres fall on the start, so that the path does not depend on the origin.
    corner = start - params.cell * np.rint((start - (centre - half)) / params.cell)
    index = np.rint((obstacles - corner) / params.cell).astype(np.int64)
    inside = ((index >= 0) & (index < shape)).all(axis=1)
    row, column = index[inside].T
    if not len(row):
        return ClearanceGrid(corner, params.cell, np.full(tuple(shape), math.inf))
    empty = np.ones(shape, dtype=np.bool_)
    empty[row, column] = False
    held = np.zeros((*shape, 2))
    held[row, column] = obstacles[inside]
    nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
    centres = corner + params.cell * np.moveaxis(np.indices(tuple(shape)), 0, -1)
    gap = held[nearest[0], nearest[1]] - centres
    return ClearanceGrid(corner, params.cell, np.hypot(gap[..., 0], gap[..., 1]))


def free_cells(
    grid: ClearanceGrid, start: Points, safe: float, params: Navigation
) -> NDArray[np.bool_]:
    """Cells the disc may stand on; close to a cramped start, as cramped as the start is."""
    free = grid.clearance >= safe
    at = grid.cells(start)
    here = float(grid.clearance[at[0], at[1]])
    if here < safe:
        reach = math.ceil(params.leave_radius / grid.cell)
        rows = slice(max(at[0] - reach, 0), at[0] + reach + 1)
        columns = slice(max(at[1] - reach, 0), at[1] + reach + 1)
        free[rows, columns] |= grid.clearance[rows, columns] >= max(
            here - params.margin, params.cell
        )
        free[at[0], at[1]] = True
    return free


def nearest_free(
    grid: ClearanceGrid, free: NDArray[np.bool_], goal: Points, params: Navigation
) -> Cells | None:
    """The goal's cell if it is free, else the nearest free one within ``goal_reach``, or None."""
    at = grid.cells(goal)
    if free[at[0], at[1]]:
        return at
    cells = np.argwhere(free)
    distance = np.hypot(*(grid.centres(cells) - goal).T)
    if distance.min(initial=math.inf) > params.goal_reach:
        return None
    return np.asarray(cells[distance.argmin()])


def cheapest(
    grid: ClearanceGrid,
    free: NDArray[np.bool_],
    start: Points,
    target: Cells,
    safe: float,
    params: Navigation,
) -> Cells | None:
    """The cells (K, 2) of the cheapest way from start to target, or None if there is none."""
    lack = (params.soft_clearance - grid.clearance) / (params.soft_clearance - safe)
    costs = np.where(free, 1.0 + params.near_cost * np.maximum(lack, 0.0) ** 2, -1.0)
    search = MCP_Geometric(costs)
    end = (int(target[0]), int(target[1]))
    reached, _ = search.find_costs([tuple(grid.cells(start))], [end])
    if not math.isfinite(reached[end]):
        return None
    return np.asarray(search.traceback(end), dtype=np.int64)
