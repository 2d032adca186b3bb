"""The grid under the laser: which walls touch which square cell of the plane."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cogmap_gym.geometry import Array
from cogmap_gym.raycast_kernel import Ints, compiled

CELL: Final = 4.0
"""Side of a grid cell [m]. Ours: fastest of 2-12 m, from 150 to 100,000 walls of an office."""
MOST_CELLS: Final = 1_000_000
"""Cells of a grid, about; sparse, vast worlds get larger cells. Ours: 8 MB of indexes."""
CELL_MARGIN: Final = 1e-6
"""A segment is entered in the cells within this distance [m]. Ours: beyond all rounding."""


def lay_out_cells(segments: Array) -> tuple[Array, int, int]:
    """Choose a grid over ``segments`` (N, 4): (x0, y0, cell) in metres, columns, lines."""
    if not len(segments):
        return np.array((0.0, 0.0, CELL)), 1, 1
    points = segments.reshape(-1, 2)
    low = points.min(axis=0) - CELL_MARGIN
    width, height = points.max(axis=0) + CELL_MARGIN - low
    area_cell, side_cell = math.sqrt(width * height / MOST_CELLS), max(width, height) / MOST_CELLS
    cell = max(CELL, 2.0 * area_cell, 4.0 * side_cell)
    return np.array((low[0], low[1], cell)), int(width // cell) + 1, int(height // cell) + 1


def file_in_cells(segments: Array, grid: Array, columns: int, lines: int) -> tuple[Ints, Ints]:
    """List the rows of each cell: cell c holds ``rows[first[c]:first[c + 1]]``."""
    first = np.zeros(columns * lines + 1, dtype=np.int64)
    _register(segments, grid, columns, lines, first[1:], np.zeros(0, dtype=np.int64))
    first = np.cumsum(first)
    rows = np.zeros(first[-1], dtype=np.int64)
    _register(segments, grid, columns, lines, first[:-1].copy(), rows)
    return first, rows


@compiled
def _register(
    segments: Array, grid: Array, columns: int, lines: int, cursor: Ints, rows: Ints
) -> None:
    """Enter each segment in every cell it touches; with no ``rows``, only count."""
    cell = grid[2]
    for row in range(len(segments)):
        px, qx = segments[row, 0] - grid[0], segments[row, 2] - grid[0]
        py, qy = segments[row, 1] - grid[1], segments[row, 3] - grid[1]
        low = max(math.floor((min(py, qy) - CELL_MARGIN) / cell), 0)
        high = min(math.floor((max(py, qy) + CELL_MARGIN) / cell), lines - 1)
        for line in range(low, high + 1):
            t0, t1 = 0.0, 1.0
            if abs(qy - py) > CELL_MARGIN:
                ta = (line * cell - CELL_MARGIN - py) / (qy - py)
                tb = ((line + 1) * cell + CELL_MARGIN - py) / (qy - py)
                t0, t1 = max(min(ta, tb), 0.0), min(max(ta, tb), 1.0)
            xa, xb = px + t0 * (qx - px), px + t1 * (qx - px)
            left = max(math.floor((min(xa, xb) - CELL_MARGIN) / cell), 0)
            right = min(math.floor((max(xa, xb) + CELL_MARGIN) / cell), columns - 1)
            for c in range(line * columns + left, line * columns + right + 1):
                if len(rows) > 0:
                    rows[cursor[c]] = row
                cursor[c] += 1
