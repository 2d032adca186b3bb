"""The laser beams of the world: exact ranges on walls, and on doors that open and shut."""

from __future__ import annotations

import math
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import NO_SEGMENTS, Array, Pose, Segments
from cogmap_gym.raycast_kernel import CELL_MARGIN, Ints, cast, register

CELL: Final = 4.0
"""Side of a grid cell [m]. Ours: fastest of 2-12 m, from 150 to 100,000 walls of an office."""
MOST_CELLS: Final = 1_000_000
"""Cells of a grid, about; sparse, vast worlds get larger cells. Ours: 8 MB of indexes."""
ABSENT: Final = int(np.iinfo(np.int64).max)
"""Stamp of a movable segment that is not there: it counts as already drawn."""


class Fan(Protocol):
    """What a caster asks of a laser; ``observation.LaserSpec`` has it."""

    @property
    def first_angle(self) -> float:
        """Direction of beam 0 in the laser's frame [rad]."""

    @property
    def step(self) -> float:
        """Angle from one beam to the next, counter-clockwise [rad]."""

    @property
    def beams(self) -> int:
        """Number of beams."""

    @property
    def range_max(self) -> float:
        """Largest range; a beam that meets nothing reads this [m]."""


class RayCaster:
    """Casts laser beams on fixed segments and on doors that open and shut.

    Args:
        walls: (N, 2, 2), metres, in the frame of the poses given later.
        movable: (M, 2, 2), doors and barriers; all absent at first.

    Raises:
        ValueError: on a wrong shape or a number that is not finite.

    A caster keeps scratch memory: give each thread its own (pickle and deepcopy work).
    """

    def __init__(self, walls: Segments, movable: Segments = NO_SEGMENTS) -> None:
        for name, value in (("walls", walls), ("movable", movable)):
            if np.shape(value)[1:] != (2, 2) or not np.isfinite(value).all():
                raise ValueError(
                    f"RayCaster: {name}: expected finite numbers of shape (N, 2, 2), "
                    f"got shape {np.shape(value)}"
                )
        self._segments = np.concatenate((walls, movable)).astype(np.float64).reshape(-1, 4)
        self._seen: Ints = np.zeros(len(self._segments), dtype=np.int64)
        self._seen[len(walls) :] = ABSENT
        self._movable = len(movable)
        self._stamp = 0
        self._grid, self._columns, self._lines = _layout(self._segments)
        self._first, self._rows = _index(self._segments, self._grid, self._columns, self._lines)
        self._laser: Fan | None = None
        self._middle = 0.0
        self._fan = np.zeros((2, 0))

    def set_solid(self, row: int, solid: bool) -> None:
        """Put movable segment ``row`` in its place, or take it away.

        Raises:
            IndexError: if there is no such row.
        """
        if not 0 <= row < self._movable:
            raise IndexError(f"RayCaster: expected a movable row < {self._movable}, got {row}")
        self._seen[len(self._seen) - self._movable + row] = 0 if solid else ABSENT

    @property
    def solid(self) -> NDArray[np.bool_]:
        """Which movable segments are in place, shape (M,), a copy."""
        return np.asarray(self._seen[len(self._seen) - self._movable :] != ABSENT)

    def ranges(self, laser_pose: Pose, laser: Fan) -> Array:
        """Distances to the nearest segment along each beam.

        Args:
            laser_pose: of the laser, in the frame of the segments.
            laser: the fan of beams.

        Returns:
            (beams,), metres; exactly ``range_max`` where nothing nearer is met, 0 everywhere
            when the laser stands on a segment. A fresh array on every call.
        """
        if laser is not self._laser:
            self._aim(laser)
        self._stamp += 1
        return cast(
            self._segments,
            self._first,
            self._rows,
            self._seen,
            self._stamp,
            self._grid,
            self._columns,
            self._lines,
            self._fan,
            laser.step,
            laser.range_max,
            laser_pose.x,
            laser_pose.y,
            laser_pose.theta + self._middle,
        )

    def _aim(self, laser: Fan) -> None:
        """Tabulate the beam directions of ``laser`` about the middle of its fan."""
        angles = (np.arange(laser.beams) - 0.5 * (laser.beams - 1)) * laser.step
        self._fan = np.stack((np.cos(angles), np.sin(angles)))
        self._middle = laser.first_angle + 0.5 * (laser.beams - 1) * laser.step
        self._laser = laser


def _layout(segments: Array) -> tuple[Array, int, int]:
    """Choose a grid over ``segments`` (N, 4): (x0, y0, cell) in metres, columns, lines."""
    if not len(segments):
        return np.array((0.0, 0.0, CELL)), 1, 1
    points = segments.reshape(-1, 2)
    low = points.min(axis=0) - CELL_MARGIN
    width, height = points.max(axis=0) + CELL_MARGIN - low
    area_cell, side_cell = math.sqrt(width * height / MOST_CELLS), max(width, height) / MOST_CELLS
    cell = max(CELL, 2.0 * area_cell, 4.0 * side_cell)
    return np.array((low[0], low[1], cell)), int(width // cell) + 1, int(height // cell) + 1


def _index(segments: Array, grid: Array, columns: int, lines: int) -> tuple[Ints, Ints]:
    """List the rows of each cell: cell c holds ``rows[first[c]:first[c + 1]]``."""
    first = np.zeros(columns * lines + 1, dtype=np.int64)
    register(segments, grid, columns, lines, first[1:], np.zeros(0, dtype=np.int64))
    first = np.cumsum(first)
    rows = np.zeros(first[-1], dtype=np.int64)
    register(segments, grid, columns, lines, first[:-1].copy(), rows)
    return first, rows
