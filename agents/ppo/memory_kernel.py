"""Compiled loops over a robot's memory of cells: to draw a scan, and to look at what is known.

Lengths are cells, and so are positions: x along the columns, y along the rows.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

UNKNOWN, FREE, WALL = 0, 1, 2
"""What a cell holds."""
SHIFT = 2
"""Visits are counted in squares of 2 ** SHIFT cells a side."""
Cells = NDArray[np.uint8]
Counts = NDArray[np.float32]
Floats = NDArray[np.float32]
Array = NDArray[np.float64]


@njit(cache=True)
def draw(
    cells: Cells, eye: tuple[float, float, float], angles: Array, ranges: Array, far: float
) -> None:
    """Mark what beams pass through as free, then where they end as wall; the newest wins.

    Args:
        cells: (S, S), changed in place.
        eye: x, y [cells] and direction [rad] of the laser.
        angles: (B,), of the beams in the laser's frame [rad].
        ranges: (B,) [cells]; 0 is no evidence.
        far: nothing is drawn beyond [cells].
    """
    side = cells.shape[0]
    x, y, theta = eye
    for b in range(len(angles)):
        c, s = math.cos(theta + angles[b]), math.sin(theta + angles[b])
        for n in range(int(2.0 * min(ranges[b], far))):
            row, column = math.floor(y + 0.5 * n * s), math.floor(x + 0.5 * n * c)
            if row < 0 or column < 0 or row >= side or column >= side:
                break
            cells[row, column] = FREE
    for b in range(len(angles)):
        if 0.0 < ranges[b] < far:
            row = math.floor(y + ranges[b] * math.sin(theta + angles[b]))
            column = math.floor(x + ranges[b] * math.cos(theta + angles[b]))
            if 0 <= row < side and 0 <= column < side:
                cells[row, column] = WALL


@njit(cache=True)
def look_around(
    cells: Cells, pose: tuple[float, float, float], far: float, walls: Floats, unknowns: Floats
) -> None:
    """How far it is to a remembered wall, and to what is unknown before it, all around.

    Args:
        cells: (S, S).
        pose: x, y [cells] and heading [rad] of the robot.
        far: nothing is looked for beyond [cells].
        walls: (D,), written: 0 at the robot to 1 at ``far`` and beyond, direction 0 ahead,
            then counter-clockwise.
        unknowns: (D,), written the same way; 1 where there is nothing unknown before the wall.
    """
    side, count = cells.shape[0], len(walls)
    x, y, theta = pose
    for k in range(count):
        c = math.cos(theta + 2.0 * math.pi * k / count)
        s = math.sin(theta + 2.0 * math.pi * k / count)
        walls[k], unknowns[k] = 1.0, 1.0
        for n in range(int(far)):
            row, column = math.floor(y + n * s), math.floor(x + n * c)
            if row < 0 or column < 0 or row >= side or column >= side:
                break
            if cells[row, column] == UNKNOWN and unknowns[k] == 1.0:
                unknowns[k] = n / far
            if cells[row, column] == WALL:
                walls[k] = n / far
                break


@njit(cache=True)
def paint(
    cells: Cells,
    visits: Counts,
    pose: tuple[float, float, float],
    step: float,
    samples: int,
    picture: Floats,
) -> None:
    """A coarse picture of the memory about the robot, which stands in the middle and looks up.

    Args:
        cells: (S, S).
        visits: (S >> SHIFT, S >> SHIFT), how often the robot was in each square.
        pose: x, y [cells] and heading [rad] of the robot.
        step: from one sample to the next [cells].
        samples: along a side of a field.
        picture: (3, P, P), written: the share of samples that are free, that are free beside
            what is unknown, and how often the robot was there, 0 to 1.
    """
    side, fields = cells.shape[0], picture.shape[1]
    x, y, theta = pose
    c, s = math.cos(theta) * step, math.sin(theta) * step
    share = np.float32(1.0 / (samples * samples))
    half = 0.5 * fields * samples - 0.5
    for p in range(fields):
        for q in range(fields):
            free, edge, visited = 0, 0, np.float32(0.0)
            for i in range(samples):
                ahead = half - (p * samples + i)
                for j in range(samples):
                    left = half - (q * samples + j)
                    column = math.floor(x + c * ahead - s * left)
                    row = math.floor(y + s * ahead + c * left)
                    if row < 1 or column < 1 or row >= side - 1 or column >= side - 1:
                        continue
                    if cells[row, column] != FREE:
                        continue
                    free += 1
                    edge += (
                        cells[row - 1, column] == UNKNOWN
                        or cells[row + 1, column] == UNKNOWN
                        or cells[row, column - 1] == UNKNOWN
                        or cells[row, column + 1] == UNKNOWN
                    )
                    times = visits[row >> SHIFT, column >> SHIFT]
                    visited += times / (times + np.float32(2.0))
            picture[0, p, q] = share * free
            picture[1, p, q] = share * edge
            picture[2, p, q] = share * visited
