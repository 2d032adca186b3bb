"""The laser beams of the world: exact ranges on walls, and on doors that open and shut."""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import NO_SEGMENTS, Array, Pose, Segments
from cogmap_gym.raycast_kernel import LANES, Ints, cast_rays
from cogmap_gym.wall_cells import file_in_cells, lay_out_cells

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
        self._grid, self._columns, self._lines = lay_out_cells(self._segments)
        self._first, self._rows = file_in_cells(
            self._segments, self._grid, self._columns, self._lines
        )
        self._laser: Fan | None = None
        self._last_pose: Pose | None = None
        self._last_ranges: Array = np.zeros(0)

    def set_solid(self, row: int, solid: bool) -> None:
        """Put movable segment ``row`` in its place, or take it away.

        Raises:
            IndexError: if there is no such row.
        """
        if not 0 <= row < self._movable:
            raise IndexError(f"RayCaster: expected a movable row < {self._movable}, got {row}")
        self._seen[len(self._seen) - self._movable + row] = 0 if solid else ABSENT
        self._last_pose = None

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
        elif laser_pose == self._last_pose:  # As a step looks twice: what is seen, and the scan.
            return self._last_ranges.copy()
        self._stamp += 1
        self._last_pose = laser_pose
        self._last_ranges = cast_rays(
            self._segments,
            self._first,
            self._rows,
            self._seen,
            self._stamp,
            self._grid,
            self._columns,
            self._lines,
            self._fan,
            self._last,
            self._step,
            self._range_max,
            float(laser_pose.x),
            float(laser_pose.y),
            laser_pose.theta + self._middle,
        )
        return self._last_ranges.copy()

    def _aim(self, laser: Fan) -> None:
        """Tabulate the beams of ``laser`` about the middle of its fan."""
        self._laser = laser
        self._last, self._step = laser.beams - 1, float(laser.step)
        self._range_max = float(laser.range_max)
        self._middle = laser.first_angle + 0.5 * self._last * self._step
        angles = (np.arange(laser.beams) - 0.5 * self._last) * self._step
        self._fan = np.zeros((2, -(-laser.beams // LANES) * LANES))
        self._fan[:, : laser.beams] = np.cos(angles), np.sin(angles)
