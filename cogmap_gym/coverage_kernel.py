"""Which cells beams pass through: a compiled kernel that visits cells, not beams.

A beam is sampled twice a cell, from the laser to its end; a cell that holds a sample is seen.
What one robot has not seen yet is kept as tiles of 8 by 8 cells, a bit a cell, and blocks of
4 by 4 tiles, each with the number of its tiles that are not empty. A look gathers the tiles
that are not empty, passes over those that no beam can reach, and asks of the beams left
whether a sample of theirs falls into a cell. Loops over beams and over tiles are laid out so
that the compiler does several at once.
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
from cogmap_gym.raycast_kernel import ANGLE_ERROR, LANES

TILE: Final = 8
"""Cells along a side of a tile: 64 bits."""
BLOCK: Final = 4
"""Tiles along a side of a block. Ours."""
SPAN: Final = 4
"""Beams whose longest range is kept together. Ours."""
CHUNK: Final = 16
"""Beams that are asked at once. Ours: with 8 the compiler would ask one by one."""
SAMPLE: Final = 0.5
"""From one sample of a beam to the next, in cells."""
NARROWEST: Final = 1e-12
"""A beam's direction cosines are at least this, so that none divides by nothing."""
ROUND: Final = math.sqrt(0.5) * TILE
"""Radius of the circle about a tile, in cells."""
HALF_TURN: Final = math.pi + 1e-9
"""A fan no wider than this sees nothing behind the laser [rad]."""
MOST: Final = 256
"""Tiles that are sorted out at once. Ours."""
_ONE, _NONE, _ROW_BITS = np.uint64(1), np.uint64(0), np.uint64(255)
_FIRST_COLUMN, _GATHER = np.uint64(0x0101010101010101), np.uint64(0x0102040810204080)
_LOWEST = np.array([0, *((k & -k).bit_length() - 1 for k in range(1, 256))])
_HIGHEST = np.array([0, *(k.bit_length() - 1 for k in range(1, 256))])
Tiles = NDArray[np.uint64]
Spans = NDArray[np.int32]
Scratch = tuple[Array, Array, Spans]


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
    fan: Array, last: int, step: float, ranges: Array, scratch: Scratch,
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
        scratch: see ``scratch_of``.
    """
    beams, near, spans = scratch
    c, s = math.cos(heading), math.sin(heading)
    side = float(TILE * BLOCK)
    _lay_out(c, s, fan, last, ranges, beams)
    low_x, high_x, low_y, high_y = _find_longest(last, step, beams)
    low = max(math.floor((y + low_y) / side), 0)
    high = min(math.floor((y + high_y) / side) + 1, blocks.shape[0])
    left = max(math.floor((x + low_x) / side), 0)
    right = min(math.floor((x + high_x) / side) + 1, blocks.shape[1])
    new, count = np.int64(0), 0
    for j in range(low, high):
        for i in range(left, right):
            if blocks[j, i] == 0:
                continue
            if count > MOST - BLOCK * BLOCK:
                new += _look_at(count, unseen, blocks, c, s, last, step, beams, near, spans)
                count = 0
            for row in range(BLOCK * j, BLOCK * (j + 1)):
                for column in range(BLOCK * i, BLOCK * (i + 1)):
                    if unseen[row, column] != _NONE:
                        near[0, count], near[1, count] = column * TILE - x, row * TILE - y
                        spans[0, count], spans[1, count] = row, column
                        count += 1
    return new + _look_at(count, unseen, blocks, c, s, last, step, beams, near, spans)


@part
def _lay_out(c: float, s: float, fan: Array, last: int, ranges: Array, beams: Array) -> None:
    """Write of each beam its step from sample to sample, one over that, and its samples."""
    for b in range(np.uint64(last + 1)):
        step_x = SAMPLE * (c * fan[0, b] - s * fan[1, b])
        step_y = SAMPLE * (s * fan[0, b] + c * fan[1, b])
        beams[0, b], beams[1, b] = step_x, step_y
        beams[2, b] = 1.0 / step_x if abs(step_x) > NARROWEST else 1.0 / NARROWEST
        beams[3, b] = 1.0 / step_y if abs(step_y) > NARROWEST else 1.0 / NARROWEST
        beams[4, b] = ranges[b] / (SAMPLE * CELL_M)


@part
def _find_longest(last: int, step: float, beams: Array) -> tuple[float, float, float, float]:
    """The longest reach of each ``SPAN`` beams, and a box about all beams, in cells."""
    low_x = high_x = low_y = high_y = 0.0
    for k in range(last // SPAN + 1):
        most, begin = 0.0, k * SPAN
        for b in range(begin, min(begin + SPAN, last + 1)):
            most = max(most, beams[4, b])
        beams[5, k] = SAMPLE * most
        end_x, end_y = most * beams[0, begin], most * beams[1, begin]
        spread = SAMPLE * most * SPAN * step + 1.0
        low_x, high_x = min(low_x, end_x - spread), max(high_x, end_x + spread)
        low_y, high_y = min(low_y, end_y - spread), max(high_y, end_y + spread)
    return low_x, high_x, low_y, high_y


@part
def _find_spans(
    count: int, c: float, s: float, last: int, step: float, near: Array, spans: Spans
) -> None:
    """Write which beams may enter each tile near by: first..end and 0..over; how near it is."""
    per_step, middle = 1.0 / step, 0.5 * last
    beam_last = 1.0 * last
    behind = -ROUND if last * step < HALF_TURN else -math.inf
    for k in range(np.uint64((count + LANES - 1) // LANES * LANES)):
        x, y = near[0, k], near[1, k]
        mx, my = x + 0.5 * TILE, y + 0.5 * TILE
        fx, fy = c * mx + s * my, c * my - s * mx
        distance = math.sqrt(fx * fx + fy * fy)
        ax, ay = abs(fx), abs(fy)
        z = min(ax, ay) / max(ax, ay)
        w = z * z
        angle = z * (
            0.9998660 + w * (-0.3302995 + w * (0.1801410 + w * (-0.0851330 + w * 0.0208351)))
        )
        angle = 0.5 * math.pi - angle if ay > ax else angle
        angle = math.pi - angle if fx < 0.0 else angle
        angle = angle if fy >= 0.0 else -angle
        half = 1.05 * ROUND / distance + ANGLE_ERROR
        low, high = angle - half, angle + half
        shift = math.tau if low < -math.pi else 0.0
        low, high = low + shift, high + shift
        over = (high - math.tau) * per_step + middle if high > math.pi else -1.0
        first = min(max(low * per_step + middle, 0.0), beam_last + 1.0)
        end = max(min(high * per_step + middle, beam_last), -1.0)
        over = max(min(over, beam_last), -1.0)
        end = end if fx >= behind else -1.0
        over = over if fx >= behind else -1.0
        by = distance <= 1.5 * TILE  # From near by, any.
        first, end, over = 0.0 if by else first, beam_last if by else end, -1.0 if by else over
        dx, dy = max(x, -TILE - x, 0.0), max(y, -TILE - y, 0.0)
        near[2, k] = dx * dx + dy * dy
        spans[2, k] = np.int32(np.ceil(first))
        spans[3, k] = np.int32(np.floor(end))
        spans[4, k] = np.int32(np.floor(over))


@part
def _look_at(
    count: int, unseen: Tiles, blocks: NDArray[np.uint8], c: float, s: float,
    last: int, step: float, beams: Array, near: Array, spans: Spans,
) -> np.int64:  # fmt: skip
    """``look`` at the tiles near by."""
    _find_spans(count, c, s, last, step, near, spans)
    new = np.int64(0)
    for k in range(count):
        first, end, over, nearest = spans[2, k], spans[3, k], spans[4, k], near[2, k]
        most = 0.0
        for g in range(np.uint64(first // SPAN), np.uint64(end // SPAN + 1)):
            most = max(most, beams[5, g])
        for g in range(np.uint64(over // SPAN + 1)):
            most = max(most, beams[5, g])
        if most * most < nearest:
            continue
        row, column = spans[0, k], spans[1, k]
        bits = unseen[row, column]
        found = _passed(bits, near[0, k], near[1, k], first, end, beams)
        if over >= 0:
            found |= _passed(bits, near[0, k], near[1, k], 0, over, beams)
        found &= bits
        if found != _NONE:
            unseen[row, column] = bits ^ found
            new += _count(found)
            if bits == found:
                blocks[row // BLOCK, column // BLOCK] -= 1
    return new


@part
def _passed(bits: np.uint64, x: float, y: float, first: int, end: int, beams: Array) -> np.uint64:
    """The cells of a tile at (x, y), among those in ``bits``, that samples of beams fall into."""
    columns = bits | (bits >> np.uint64(32))
    columns |= columns >> np.uint64(16)
    columns = (columns | (columns >> np.uint64(8))) & _ROW_BITS
    rows = bits | (bits >> np.uint64(4))
    rows |= rows >> np.uint64(2)
    rows = ((rows | (rows >> _ONE)) & _FIRST_COLUMN) * _GATHER >> np.uint64(56)
    x0, x1 = x + _LOWEST[columns], x + _HIGHEST[columns] + 1
    low, high = _LOWEST[rows], _HIGHEST[rows]
    found = _NONE
    for g in range(first // CHUNK, end // CHUNK + 1):
        if _crossing(x0, y + low, x1, y + high + 1, g, beams) == _NONE:
            continue
        for row in range(low, high + 1):
            cells = (bits >> np.uint64(TILE * row)) & _ROW_BITS
            if cells == _NONE:
                continue
            left, right = x + _LOWEST[cells], x + _HIGHEST[cells] + 1
            crossing = _crossing(left, y + row, right, y + row + 1, g, beams)
            while crossing != _NONE:
                b = g * CHUNK + _count((crossing - _ONE) & ~crossing)
                crossing &= crossing - _ONE
                found |= _along(b, x, y, left, y + row, right, y + row + 1, beams)
    return found & bits


@part
def _crossing(x0: float, y0: float, x1: float, y1: float, g: int, beams: Array) -> np.uint64:
    """Which of ``CHUNK`` beams have samples in a box, a bit a beam."""
    crossing, begin_at = _NONE, np.uint64(g * CHUNK)
    for lane in range(np.uint64(CHUNK)):
        b = begin_at + lane
        xa, xb = x0 * beams[2, b], x1 * beams[2, b]
        ya, yb = y0 * beams[3, b], y1 * beams[3, b]
        begin = max(max(min(xa, xb), min(ya, yb)), 0.0)
        stop = min(min(max(xa, xb), max(ya, yb)), beams[4, b])
        crossing |= (_ONE << lane) if np.floor(stop) >= np.ceil(begin) else _NONE
    return crossing


@part
def _along(
    b: int, x: float, y: float, x0: float, y0: float, x1: float, y1: float, beams: Array
) -> np.uint64:
    """The cells of a tile at (x, y), within a box, into which samples of beam b fall."""
    xa, xb = x0 * beams[2, b], x1 * beams[2, b]
    ya, yb = y0 * beams[3, b], y1 * beams[3, b]
    begin = max(max(min(xa, xb), min(ya, yb)), 0.0)
    stop = min(min(max(xa, xb), max(ya, yb)), beams[4, b])
    found = _NONE
    for k in range(math.ceil(begin), math.floor(stop) + 1):
        column, row = math.floor(k * beams[0, b] - x), math.floor(k * beams[1, b] - y)
        if 0 <= column < TILE and 0 <= row < TILE:
            found |= _ONE << np.uint64(TILE * row + column)
    return found


@part
def _count(bits: np.uint64) -> np.int64:
    """How many bits are set."""
    pairs = bits - ((bits >> _ONE) & np.uint64(0x5555555555555555))
    fours = np.uint64(0x3333333333333333)
    pairs = (pairs & fours) + ((pairs >> np.uint64(2)) & fours)
    bytes_ = (pairs + (pairs >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((bytes_ * _FIRST_COLUMN) >> np.uint64(56))


def scratch_of(beams: int) -> Scratch:
    """What a look writes and forgets.

    Of the beams their steps, one over these, their samples and the longest of each ``SPAN``
    of them (6, beams); of the tiles near by their places and how near they are
    (3, ``MOST``); their rows, columns and beams (5, ``MOST``).
    """
    rows = np.zeros((6, -(-beams // CHUNK) * CHUNK))
    rows[4, beams:] = -1.0
    return rows, np.zeros((3, MOST)), np.zeros((5, MOST), dtype=np.int32)


def _kernel(sources: int) -> Any:
    """``look`` for one robot, called from Python."""

    def look_once(
        unseen: Tiles, blocks: NDArray[np.uint8], x: float, y: float, heading: float,
        fan: Array, last: int, step: float, ranges: Array, scratch: Scratch,
    ) -> np.int64:  # fmt: skip
        """See ``look``."""
        new = look(unseen, blocks, x, y, heading, fan, last, step, ranges, scratch)
        return new if sources >= 0 else np.int64(0)

    return whole(look_once)


look_once = _kernel(fingerprint(grid, kernel_parts, raycast_kernel))
