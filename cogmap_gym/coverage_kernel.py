"""Which cells beams pass through: a compiled kernel that visits cells, not beams.

A beam is sampled twice a cell, from the laser to its end; a cell that holds a sample is seen.
What one robot has not seen yet is kept as tiles of 8 by 8 cells, a bit a cell, and blocks of
4 by 4 tiles, each with the number of its tiles that are not empty. A look passes over blocks
and tiles that no beam can reach, and asks of each cell left whether a sample of a beam falls
into it.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym import grid, kernel_parts, raycast_kernel
from cogmap_gym.geometry import Array
from cogmap_gym.grid import CELL_M, Mask
from cogmap_gym.kernel_parts import fingerprint, part, whole
from cogmap_gym.raycast_kernel import _cell_beams

TILE: Final = 8
"""Cells along a side of a tile: 64 bits."""
BLOCK: Final = 4
"""Tiles along a side of a block. Ours."""
SPAN: Final = 4
"""Beams whose longest range is kept together. Ours."""
SAMPLE: Final = 0.5
"""From one sample of a beam to the next, in cells."""
NARROWEST: Final = 1e-12
"""A beam's direction cosines are at least this, so that none divides by nothing."""
HALF_CELL: Final = 0.75
"""Half a cell's diagonal and a little, in cells."""
HALF_TURN: Final = math.pi + 1e-9
"""A fan no wider than this sees nothing behind the laser [rad]."""
BEAM_COST: Final = 2
"""Walking a beam through a tile costs as much as asking this many cells. Ours."""
_ONE, _NONE, _ROW_BITS = np.uint64(1), np.uint64(0), np.uint64(255)
_FIRST_COLUMN, _GATHER = np.uint64(0x0101010101010101), np.uint64(0x0102040810204080)
_LOWEST = np.array([0, *((k & -k).bit_length() - 1 for k in range(1, 256))])
_HIGHEST = np.array([0, *(k.bit_length() - 1 for k in range(1, 256))])
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


@part
def look(
    unseen: Tiles, blocks: NDArray[np.uint8], x: float, y: float, heading: float,
    fan: Array, last: int, step: float, ranges: Array, longest: Array,
) -> np.int64:  # fmt: skip
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
        longest: (beams / SPAN + 1,), scratch.
    """
    c, s = math.cos(heading), math.sin(heading)
    side = float(TILE * BLOCK)
    low_x, high_x, low_y, high_y = _find_longest(c, s, fan, last, step, ranges, longest)
    low = max(math.floor((y + low_y) / side), 0)
    high = min(math.floor((y + high_y) / side) + 1, blocks.shape[0])
    left = max(math.floor((x + low_x) / side), 0)
    right = min(math.floor((x + high_x) / side) + 1, blocks.shape[1])
    new = np.int64(0)
    for j in range(low, high):
        for i in range(left, right):
            if blocks[j, i] == 0:
                continue
            dx, dy = i * side - x, j * side - y
            reached = _reached(dx, dy, dx + side, dy + side, c, s, step, last, longest)
            if not reached[0]:
                continue
            for row in range(BLOCK * j, BLOCK * (j + 1)):
                for column in range(BLOCK * i, BLOCK * (i + 1)):
                    bits = unseen[row, column]
                    if bits == _NONE:
                        continue
                    dx, dy = column * TILE - x, row * TILE - y
                    new += _look_at_tile(
                        unseen, row, column, dx, dy, c, s, fan, step, last, ranges, longest
                    )
                    if unseen[row, column] == _NONE:
                        blocks[j, i] -= 1
    return new


@part
def _find_longest(
    c: float, s: float, fan: Array, last: int, step: float, ranges: Array, longest: Array
) -> tuple[float, float, float, float]:
    """The longest reach of each ``SPAN`` beams, and a box about all beams, in cells."""
    low_x = high_x = low_y = high_y = 0.0
    for k in range(last // SPAN + 1):
        most, begin = 0.0, k * SPAN
        for b in range(begin, min(begin + SPAN, last + 1)):
            most = max(most, ranges[b])
        longest[k] = most / CELL_M
        end_x = longest[k] * (c * fan[0, begin] - s * fan[1, begin])
        end_y = longest[k] * (s * fan[0, begin] + c * fan[1, begin])
        spread = longest[k] * SPAN * step + 1.0
        low_x, high_x = min(low_x, end_x - spread), max(high_x, end_x + spread)
        low_y, high_y = min(low_y, end_y - spread), max(high_y, end_y + spread)
    return low_x, high_x, low_y, high_y


@part
def _reached(
    left: float, low: float, right: float, high: float, c: float, s: float,
    step: float, last: int, longest: Array,
) -> tuple[bool, int, int, int]:  # fmt: skip
    """Whether some beam may enter a box that is laid out from the laser, in cells.

    Also which beams may: the first and the last, and the last beyond the seam behind the fan.
    """
    mx, my = 0.5 * (left + right), 0.5 * (low + high)
    fx, fy = c * mx + s * my, c * my - s * mx
    squared = 0.5 * ((right - left) ** 2 + (high - low) ** 2)
    if fx < 0.0 and fx * fx > squared and last * step < HALF_TURN:
        return False, 0, -1, -1  # Behind a fan that is no wider than half a turn.
    first, end, over = _cell_beams(fx, fy, math.sqrt(squared), step, last)
    dx, dy = max(left, -right, 0.0), max(low, -high, 0.0)
    nearest, most = dx * dx + dy * dy, 0.0
    for k in range(np.uint64(first // SPAN), np.uint64(min(end, last) // SPAN + 1)):
        most = max(most, longest[k])
    for k in range(np.uint64(over // SPAN + 1)):
        most = max(most, longest[k])
    return most * most >= nearest, first, min(end, last), over


@part
def _look_at_tile(
    unseen: Tiles, row: int, column: int, x: float, y: float, c: float, s: float,
    fan: Array, step: float, last: int, ranges: Array, longest: Array,
) -> np.int64:  # fmt: skip
    """``look`` at one tile whose corner is at (x, y) from the laser, in cells."""
    bits = unseen[row, column]
    columns = bits | (bits >> np.uint64(32))
    columns |= columns >> np.uint64(16)
    columns = (columns | (columns >> np.uint64(8))) & _ROW_BITS
    rows = bits | (bits >> np.uint64(4))
    rows |= rows >> np.uint64(2)
    rows = ((rows | (rows >> _ONE)) & _FIRST_COLUMN) * _GATHER >> np.uint64(56)
    low, high = _LOWEST[rows], _HIGHEST[rows] + 1
    left, right = _LOWEST[columns], _HIGHEST[columns] + 1
    x0, y0, x1, y1 = x + left, y + low, x + right, y + high
    reached, first, end, over = _reached(x0, y0, x1, y1, c, s, step, last, longest)
    if not reached:
        return np.int64(0)
    dx, dy = max(x0, -x1, 0.0), max(y0, -y1, 0.0)
    nearest, reaching = CELL_M * math.sqrt(dx * dx + dy * dy), 0
    for b in range(np.uint64(first), np.uint64(end + 1)):
        reaching += 1 if ranges[b] >= nearest else 0
    for b in range(np.uint64(over + 1)):
        reaching += 1 if ranges[b] >= nearest else 0
    if reaching == 0:
        return np.int64(0)
    found = _NONE
    if BEAM_COST * reaching < _count(bits):
        for b in range(first, end + 1):
            if ranges[b] >= nearest:
                found |= _along(b, x, y, x0, y0, x1, y1, c, s, fan, ranges)
        for b in range(over + 1):
            if ranges[b] >= nearest:
                found |= _along(b, x, y, x0, y0, x1, y1, c, s, fan, ranges)
        found &= bits
    else:
        for r in range(low, high):
            for i in range(left, right):
                bit = _ONE << np.uint64(TILE * r + i)
                if bits & bit and _sampled(x + i, y + r, c, s, fan, step, last, ranges):
                    found |= bit
    unseen[row, column] = bits ^ found
    return _count(found)


@part
def _count(bits: np.uint64) -> np.int64:
    """How many bits are set."""
    pairs = bits - ((bits >> _ONE) & np.uint64(0x5555555555555555))
    fours = np.uint64(0x3333333333333333)
    pairs = (pairs & fours) + ((pairs >> np.uint64(2)) & fours)
    bytes_ = (pairs + (pairs >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((bytes_ * _FIRST_COLUMN) >> np.uint64(56))


@part
def _along(
    b: int, x: float, y: float, x0: float, y0: float, x1: float, y1: float,
    c: float, s: float, fan: Array, ranges: Array,
) -> np.uint64:  # fmt: skip
    """The cells of a tile at (x, y), within the box, into which samples of beam b fall."""
    step_x = SAMPLE * (c * fan[0, b] - s * fan[1, b])
    step_y = SAMPLE * (s * fan[0, b] + c * fan[1, b])
    begin, end = _samples(x0, y0, x1, y1, step_x, step_y, ranges[b])
    found = _NONE
    for k in range(begin, end + 1):
        column, row = math.floor(k * step_x - x), math.floor(k * step_y - y)
        if 0 <= column < TILE and 0 <= row < TILE:
            found |= _ONE << np.uint64(TILE * row + column)
    return found


@part
def _samples(
    x0: float, y0: float, x1: float, y1: float, step_x: float, step_y: float, reach: float
) -> tuple[int, int]:
    """The first and the last sample of a beam in a box; the first is later where none is."""
    inverse_x = 1.0 / step_x if abs(step_x) > NARROWEST else 1.0 / NARROWEST
    inverse_y = 1.0 / step_y if abs(step_y) > NARROWEST else 1.0 / NARROWEST
    xa, xb, ya, yb = x0 * inverse_x, x1 * inverse_x, y0 * inverse_y, y1 * inverse_y
    begin = max(max(min(xa, xb), min(ya, yb)), 0.0)
    end = min(min(max(xa, xb), max(ya, yb)), reach / (SAMPLE * CELL_M))
    if end < begin:
        return 0, -1
    return math.ceil(begin), math.floor(end)


@part
def _sampled(
    x: float, y: float, c: float, s: float, fan: Array, step: float, last: int, ranges: Array
) -> bool:
    """Whether a sample of a beam falls into the cell whose corner is at (x, y) from the laser."""
    mx, my = x + 0.5, y + 0.5
    fx, fy = c * mx + s * my, c * my - s * mx
    low, high, across = _cell_beams(fx, fy, 1.0, step, last)
    nearest = CELL_M * (math.sqrt(mx * mx + my * my) - HALF_CELL)
    for b in range(low, min(high, last) + 1):
        if ranges[b] >= nearest and _meets(x, y, c, s, b, fan, ranges[b]):
            return True
    for b in range(across + 1):
        if ranges[b] >= nearest and _meets(x, y, c, s, b, fan, ranges[b]):
            return True
    return False


@part
def _meets(x: float, y: float, c: float, s: float, b: int, fan: Array, reach: float) -> bool:
    """Whether a sample of beam b falls into the cell whose corner is at (x, y) from the laser."""
    step_x = SAMPLE * (c * fan[0, b] - s * fan[1, b])
    step_y = SAMPLE * (s * fan[0, b] + c * fan[1, b])
    begin, end = _samples(x, y, x + 1.0, y + 1.0, step_x, step_y, reach)
    return begin <= end


def _kernel(sources: int) -> Any:
    """``look`` for one robot, called from Python."""

    def look_once(
        unseen: Tiles, blocks: NDArray[np.uint8], x: float, y: float, heading: float,
        fan: Array, last: int, step: float, ranges: Array, longest: Array,
    ) -> np.int64:  # fmt: skip
        """See ``look``."""
        new = look(unseen, blocks, x, y, heading, fan, last, step, ranges, longest)
        return new if sources >= 0 else np.int64(0)

    return whole(look_once)


look_once = _kernel(fingerprint(grid, kernel_parts, raycast_kernel))
