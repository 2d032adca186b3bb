"""The compiled twin of ``grid.mark_seen`` for many robots: it visits cells, not beams.

What one robot has not seen yet is kept as tiles of 8 by 8 cells, a bit a cell, and blocks of
4 by 4 tiles, each with the number of its tiles that are not empty. A look passes over blocks
and tiles that no beam can reach, and asks of each cell left whether a sample of a beam falls
into it. The samples are those of ``mark_seen``, up to rounding.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array
from cogmap_gym.grid import CELL_M, Mask
from cogmap_gym.raycast_kernel import _angle, _cell_beams, compiled

TILE: Final = 8
"""Cells along a side of a tile: 64 bits."""
BLOCK: Final = 4
"""Tiles along a side of a block. Ours."""
SPAN: Final = 8
"""Beams whose longest range is kept together. Ours."""
SAMPLE: Final = 0.5
"""From one sample of a beam to the next, in cells; as in ``mark_seen``."""
NARROWEST: Final = 1e-12
"""A beam's direction cosines are at least this, so that none divides by nothing."""
STEP_X, STEP_Y, INVERSE_X, INVERSE_Y, SAMPLES = range(5)
"""Rows of ``beams``: cells a sample, their inverses, and how many samples a beam has."""
_ONE, _NONE, _ROW_BITS = np.uint64(1), np.uint64(0), np.uint64(255)
Tiles = NDArray[np.uint64]


def tiles_of(cells: Mask) -> Tiles:
    """Cells (rows, columns) as tiles (R, C), R and C multiples of ``BLOCK``; bit 8 r + c."""
    side = TILE * BLOCK
    rows, columns = (-(-n // side) * side for n in cells.shape)
    padded = np.zeros((rows, columns), dtype=np.uint64)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    parts = padded.reshape(rows // TILE, TILE, columns // TILE, TILE)
    bits = _ONE << np.arange(TILE * TILE, dtype=np.uint64).reshape(TILE, TILE)
    return np.asarray((parts * bits[None, :, None, :]).sum(axis=(1, 3), dtype=np.uint64))


def blocks_of(tiles: Tiles) -> NDArray[np.uint8]:
    """How many tiles of each block are not empty, (R / 4, C / 4)."""
    parts = (tiles != 0).reshape(tiles.shape[0] // BLOCK, BLOCK, -1, BLOCK)
    return np.asarray(parts.sum(axis=(1, 3), dtype=np.uint8))


@compiled
def look(
    unseen: Tiles, blocks: NDArray[np.uint8], x: float, y: float, heading: float,
    fan: Array, last: int, step: float, ranges: Array, beams: Array, longest: Array,
) -> int:  # fmt: skip
    """Clear the bits of the cells that beams pass through; answer how many there were.

    Args:
        unseen: (R, C), of one robot.
        blocks: (R / 4, C / 4), of the same.
        x: of the laser, in cells from the corner of the grid.
        y: the same.
        heading: of the middle of the fan [rad].
        fan: (2, beams) or wider, cosines and sines in the fan frame.
        last: the last beam.
        step: from a beam to the next [rad].
        ranges: (beams,), without noise [m].
        beams: (5, beams), scratch.
        longest: (beams / SPAN + 1,), scratch.
    """
    c, s = math.cos(heading), math.sin(heading)
    low_x = high_x = x
    low_y = high_y = y
    for b in range(np.uint64(last + 1)):
        step_x = SAMPLE * (c * fan[0, b] - s * fan[1, b])
        step_y = SAMPLE * (s * fan[0, b] + c * fan[1, b])
        samples = math.floor(ranges[b] / (SAMPLE * CELL_M))
        beams[STEP_X, b], beams[STEP_Y, b], beams[SAMPLES, b] = step_x, step_y, samples
        step_x = step_x if abs(step_x) > NARROWEST else NARROWEST
        step_y = step_y if abs(step_y) > NARROWEST else NARROWEST
        beams[INVERSE_X, b], beams[INVERSE_Y, b] = 1.0 / step_x, 1.0 / step_y
        end_x, end_y = x + samples * step_x, y + samples * step_y
        low_x, high_x = min(low_x, end_x), max(high_x, end_x)
        low_y, high_y = min(low_y, end_y), max(high_y, end_y)
    _find_longest(beams, last, longest)
    side = float(TILE * BLOCK)
    low, high = max(math.floor(low_y / side), 0), min(math.floor(high_y / side) + 1, len(blocks))
    left = max(math.floor(low_x / side), 0)
    right = min(math.floor(high_x / side) + 1, blocks.shape[1])
    new = 0
    for j in range(low, high):
        for i in range(left, right):
            if blocks[j, i] == 0:
                continue
            dx, dy = (i + 0.5) * side - x, (j + 0.5) * side - y
            if not _reached(c * dx + s * dy, c * dy - s * dx, side, step, last, longest):
                continue
            for row in range(BLOCK * j, BLOCK * (j + 1)):
                for column in range(BLOCK * i, BLOCK * (i + 1)):
                    if unseen[row, column] == _NONE:
                        continue
                    new += _look_at_tile(
                        unseen, row, column, x, y, c, s, step, last, beams, longest
                    )
                    if unseen[row, column] == _NONE:
                        blocks[j, i] -= 1
    return new


@compiled
def _find_longest(beams: Array, last: int, longest: Array) -> None:
    """The longest reach of each ``SPAN`` beams, in cells."""
    for k in range(last // SPAN + 1):
        most = 0.0
        for b in range(np.uint64(k * SPAN), np.uint64(min((k + 1) * SPAN, last + 1))):
            most = max(most, beams[SAMPLES, b])
        longest[k] = SAMPLE * most


@compiled
def _reached(x: float, y: float, side: float, step: float, last: int, longest: Array) -> bool:
    """Whether some beam may enter the square about (x, y) of the fan frame, in cells."""
    nearest = math.sqrt(x * x + y * y) - math.sqrt(0.5) * side
    low, high, over = _cell_beams(x, y, side, step, last)
    reached = False
    for k in range(low // SPAN, min(high, last) // SPAN + 1):
        reached = reached or longest[k] >= nearest
    for k in range(over // SPAN + 1):
        reached = reached or longest[k] >= nearest
    return reached


@compiled
def _look_at_tile(
    unseen: Tiles, row: int, column: int, x: float, y: float, c: float, s: float,
    step: float, last: int, beams: Array, longest: Array,
) -> int:  # fmt: skip
    """``look`` at one tile."""
    dx, dy = (column + 0.5) * TILE - x, (row + 0.5) * TILE - y
    if not _reached(c * dx + s * dy, c * dy - s * dx, float(TILE), step, last, longest):
        return 0
    bits, left, new = unseen[row, column], unseen[row, column], 0
    for r in range(TILE):
        if (bits >> np.uint64(TILE * r)) & _ROW_BITS == _NONE:
            continue
        for i in range(TILE):
            bit = _ONE << np.uint64(TILE * r + i)
            if bits & bit == _NONE:
                continue
            dx, dy = TILE * column + i - x, TILE * row + r - y
            if _sampled(dx, dy, c, s, step, last, beams):
                left ^= bit
                new += 1
    unseen[row, column] = left
    return new


@compiled
def _sampled(dx: float, dy: float, c: float, s: float, step: float, last: int, beams: Array) -> bool:
    """Whether a sample of a beam falls into the cell whose lower left corner is (dx, dy)."""
    mx, my = dx + 0.5, dy + 0.5
    fx, fy = c * mx + s * my, c * my - s * mx
    low, high, over = _cell_beams(fx, fy, 1.0, step, last)
    # The middle beam meets almost every cell that any beam meets.
    middle = math.floor(_angle(fx, fy) / step + 0.5 * last + 0.5)
    if 0 <= middle <= last and _meets(dx, dy, middle, beams):
        return True
    for b in range(low, high + 1):
        if _meets(dx, dy, b, beams):
            return True
    for b in range(over + 1):
        if _meets(dx, dy, b, beams):
            return True
    return False


@compiled
def _meets(dx: float, dy: float, b: int, beams: Array) -> bool:
    """Whether a sample of beam b falls into the cell."""
    x0, x1 = dx * beams[INVERSE_X, b], (dx + 1.0) * beams[INVERSE_X, b]
    y0, y1 = dy * beams[INVERSE_Y, b], (dy + 1.0) * beams[INVERSE_Y, b]
    begin = max(max(min(x0, x1), min(y0, y1)), 0.0)
    end = min(min(max(x0, x1), max(y0, y1)), beams[SAMPLES, b])
    return math.ceil(begin) <= end
