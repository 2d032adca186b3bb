"""What was seen to be free from a place, as cells of the MFIS, and coarse ways over it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from skimage.graph import MCP_Geometric

from agents.cogmap.params import Curiosity
from agents.cogmap.view import View
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import LaserSpec

Cells = NDArray[np.int64]
"""Cells known by one number each, (C,), in order."""
HALF = 32
"""Bits of a cell's number that its second index takes [1]."""


def cells_of(points: Points, params: Curiosity) -> Cells:
    """The cells in which points (..., 2) of the MFIS lie, (...)."""
    index = np.floor(points / params.cell).astype(np.int64)
    return np.asarray((index[..., 0] << HALF) + index[..., 1])


def middles_of(cells: Cells, params: Curiosity) -> Points:
    """The middles (C, 2) of cells in the MFIS."""
    return np.asarray((_indexes(cells) + 0.5) * params.cell)


def free_cells(view: View, pose: Pose, laser: LaserSpec, params: Curiosity) -> Cells:
    """The cells of the MFIS that the beams of a view go through.

    Args:
        view: the view.
        pose: ``mfis_from_robot``.
        laser: the laser.
        params: a cell is a square of side ``params.cell``.
    """
    ends = view.points[np.isfinite(view.points).all(axis=1)]
    eye = laser.robot_from_laser.position
    along = ends - eye
    size = np.hypot(along[:, 0], along[:, 1])
    steps = np.arange(params.cell, params.reach, params.cell)
    short = steps < (size - 0.5 * params.cell)[:, None]
    rows, columns = np.nonzero(short)
    points = eye + along[rows] * (steps[columns] / size[rows])[:, None]
    return np.unique(cells_of(pose.apply(points), params))


def spot_on_the_way(free: Cells, start: Points, goal: Points, params: Curiosity) -> Points | None:
    """A spot (2,) on a coarse way over free cells, no farther than a local plan reaches.

    Args:
        free: what was seen to be free.
        start: (2,) in the MFIS.
        goal: (2,) in the MFIS.
        params: sizes.

    Returns:
        None where start and goal do not hang together.
    """
    if not len(free):
        return None
    index = _indexes(free)
    low = index.min(axis=0) - 1
    grid = np.zeros(index.max(axis=0) - low + 2, dtype=np.bool_)
    grid[tuple((index - low).T)] = True
    ends = [_nearest(index, p, params) for p in (start, goal)]
    if ends[0] is None or ends[1] is None:
        return None
    # Cells beside what is not free cost more: a body is as wide as two.
    costs = np.where(grid, 1.0 + params.edge_cost * (distance_transform_edt(grid) < 2.0), -1.0)
    search = MCP_Geometric(costs)
    begin, end = (tuple((e - low).tolist()) for e in ends)
    reached, _ = search.find_costs([begin], [end])
    if not math.isfinite(reached[end]):
        return None
    way = (np.array(search.traceback(end)) + low + 0.5) * params.cell
    along = np.concatenate(((0.0,), np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
    return np.asarray(way[np.flatnonzero(along <= params.leg)[-1]])


def _indexes(cells: Cells) -> NDArray[np.int64]:
    """The two indexes of each cell, (C, 2)."""
    half = 1 << (HALF - 1)
    second = ((cells + half) & ((1 << HALF) - 1)) - half
    return np.stack(((cells - second) >> HALF, second), axis=-1)


def _nearest(
    index: NDArray[np.int64], point: Points, params: Curiosity
) -> NDArray[np.int64] | None:
    """The free cell (2,) nearest to a point, None where all are too far."""
    gaps = np.hypot(*((index + 0.5) * params.cell - point).T)
    row = int(gaps.argmin())
    return np.asarray(index[row]) if gaps[row] <= params.near_free else None
