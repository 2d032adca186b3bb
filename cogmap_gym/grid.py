"""Cells of 0.1 m over a floor plan: the truth that rewards and scores count in."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, Points, Segments
from cogmap_gym.raycast_kernel import compiled

CELL_M = 0.1
"""Side of a cell [m]."""
BORDER_M = 0.5
"""Empty border around the outermost walls [m]."""
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Grid:
    """Square cells; cell (row, column) holds y from ``y0 + row CELL_M``, x likewise."""

    x0: float
    """Left edge [m]."""
    y0: float
    """Lower edge [m]."""
    rows: int
    """Number of rows, upwards."""
    columns: int
    """Number of columns, to the right."""

    @classmethod
    def over(cls, segments: Segments) -> Grid:
        """The grid that covers some segments with a border."""
        low = segments.min(axis=(0, 1)) - BORDER_M
        high = segments.max(axis=(0, 1)) + BORDER_M
        columns, rows = np.ceil((high - low) / CELL_M).astype(int)
        return cls(float(low[0]), float(low[1]), int(rows), int(columns))

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    def centres(self) -> tuple[Array, Array]:
        """The x and y of the cells' centres, each of shape (rows, columns) [m]."""
        x = self.x0 + CELL_M * (np.arange(self.columns) + 0.5)
        y = self.y0 + CELL_M * (np.arange(self.rows) + 0.5)
        xs, ys = np.meshgrid(x, y)
        return xs, ys

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """The cell that holds a point, brought inside the grid."""
        row = min(max(math.floor((y - self.y0) / CELL_M), 0), self.rows - 1)
        column = min(max(math.floor((x - self.x0) / CELL_M), 0), self.columns - 1)
        return row, column

    def near(self, segments: Segments, distance: float) -> Mask:
        """Which cell centres lie nearer than ``distance`` [m] to any segment."""
        mask = np.zeros(self.shape, dtype=np.bool_)
        _mark_near(mask, self.x0, self.y0, np.ascontiguousarray(segments), distance)
        return mask


@compiled
def _mark_near(mask: Mask, x0: float, y0: float, segments: Segments, distance: float) -> None:
    """Mark the cells whose centre is nearer than ``distance`` to a segment."""
    rows, columns = mask.shape
    for n in range(segments.shape[0]):
        px, py = segments[n, 0, 0], segments[n, 0, 1]
        dx, dy = segments[n, 1, 0] - px, segments[n, 1, 1] - py
        squared = dx * dx + dy * dy
        low = max(int((min(py, py + dy) - distance - y0) / CELL_M) - 1, 0)
        high = min(int((max(py, py + dy) + distance - y0) / CELL_M) + 2, rows)
        left = max(int((min(px, px + dx) - distance - x0) / CELL_M) - 1, 0)
        right = min(int((max(px, px + dx) + distance - x0) / CELL_M) + 2, columns)
        for row in range(low, high):
            y = y0 + CELL_M * (row + 0.5) - py
            for column in range(left, right):
                x = x0 + CELL_M * (column + 0.5) - px
                t = 0.0
                if squared > 0.0:
                    t = min(max((x * dx + y * dy) / squared, 0.0), 1.0)
                if math.hypot(x - t * dx, y - t * dy) < distance:
                    mask[row, column] = True


@compiled
def mark_seen(
    seen: Mask, x0: float, y0: float, origin: Points, directions: Array, ranges: Array
) -> int:
    """Mark the cells that beams pass through; answer how many were new.

    Args:
        seen: (rows, columns), changed in place; cells that do not count come marked.
        x0: left edge of the grid [m].
        y0: lower edge of the grid [m].
        origin: (2,), where the beams start [m].
        directions: (B,), world frame [rad].
        ranges: (B,), how far each beam goes [m].
    """
    rows, columns = seen.shape
    new = 0
    for b in range(directions.shape[0]):
        step_x = 0.5 * math.cos(directions[b])
        step_y = 0.5 * math.sin(directions[b])
        x = (origin[0] - x0) / CELL_M
        y = (origin[1] - y0) / CELL_M
        for _ in range(int(2.0 * ranges[b] / CELL_M) + 1):
            row, column = math.floor(y), math.floor(x)
            if row < 0 or column < 0 or row >= rows or column >= columns:
                break
            if not seen[row, column]:
                seen[row, column] = True
                new += 1
            x += step_x
            y += step_y
    return new
