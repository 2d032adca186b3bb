"""Compiled loops over the cells of the occupancy grid."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cogmap_gym.geometry import Array

Votes = NDArray[np.int8]
Steps = NDArray[np.int32]
Floats32 = NDArray[np.float32]
Window = tuple[int, int, int, int]
"""First and past-the-last row, first and past-the-last column."""


@njit(cache=True)
def carve(
    votes: Votes,
    stamps: Steps,
    visits: Steps,
    window: Window,
    origin: tuple[float, float, float],
    eye: tuple[float, float, float],
    ranges: Array,
    fan: tuple[float, float],
    limits: tuple[float, float, float],
    most: int,
    now: int,
) -> None:
    """Vote for the cells of which every beam through them tells that they are free.

    Args:
        votes: (H, W), changed in place: above 0 occupied, below free, 0 never seen.
        stamps: (H, W), changed in place: the step at which a cell was last seen.
        visits: (H, W), changed in place: the step at which the robot last was near a cell.
        window: the cells to look at.
        origin: x and y of the grid's corner, and the side of a cell [m].
        eye: pose of the laser in the grid's frame [m, rad].
        ranges: (beams,), 0 for no evidence [m].
        fan: the first beam's direction and the step to the next [rad].
        limits: reach, the margin by which a beam must end behind the cell, and what is near [m].
        most: votes for being free never go beyond.
        now: number of this step.
    """
    x0, y0, cell = origin
    first, step = fan
    reach, margin, near = limits
    around = 0.75 * cell  # Half the diagonal of a cell, rounded up.
    for i in range(window[0], window[1]):
        dy = y0 + (i + 0.5) * cell - eye[1]
        for j in range(window[2], window[3]):
            dx = x0 + (j + 0.5) * cell - eye[0]
            distance = math.sqrt(dx * dx + dy * dy)
            if distance > reach or distance <= around:
                continue
            bearing = (math.atan2(dy, dx) - eye[2] - first) % math.tau
            half = around / distance
            low = math.floor((bearing - half) / step)
            high = math.ceil((bearing + half) / step)
            if low < 0 or high >= len(ranges):
                continue
            free = True
            for beam in range(low, high + 1):
                free = free and ranges[beam] > distance + around + margin
            if free:
                vote = votes[i, j] - 1
                votes[i, j] = max(-most, vote if vote != 0 else -1)
                stamps[i, j] = now
                if distance < near:
                    visits[i, j] = now


@njit(cache=True)
def stamp_hits(
    votes: Votes,
    stamps: Steps,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    occupied: int,
    now: int,
) -> None:
    """Make the cells in which beams ended occupied, in place."""
    for k in range(len(rows)):
        votes[rows[k], columns[k]] = occupied
        stamps[rows[k], columns[k]] = now


@njit(cache=True)
def update_clearance(clearance: Floats32, votes: Votes, window: Window, cap: int) -> None:
    """Distances to the nearest occupied cell, in cells and up to ``cap``, in a window.

    Exact: along the rows first, then the least over the columns.

    Args:
        clearance: (H, W), changed in place inside the window [cells].
        votes: (H, W).
        window: where it is brought up to date.
        cap: nothing farther is told apart [cells].
    """
    height, width = votes.shape
    top, bottom = max(0, window[0] - cap), min(height, window[1] + cap)
    left, right = max(0, window[2] - cap), min(width, window[3] + cap)
    along = np.empty((bottom - top, right - left), dtype=np.float32)
    for i in range(top, bottom):
        run = float(cap)
        for j in range(left, right):
            run = 0.0 if votes[i, j] > 0 else min(run + 1.0, float(cap))
            along[i - top, j - left] = run
        run = float(cap)
        for j in range(right - 1, left - 1, -1):
            run = 0.0 if votes[i, j] > 0 else min(run + 1.0, float(cap))
            along[i - top, j - left] = min(along[i - top, j - left], run)
    for i in range(window[0], window[1]):
        low, high = max(top, i - cap), min(bottom, i + cap + 1)
        for j in range(window[2], window[3]):
            best = float(cap * cap)
            for k in range(low, high):
                side = along[k - top, j - left]
                best = min(best, side * side + (k - i) * (k - i))
            clearance[i, j] = math.sqrt(best)
