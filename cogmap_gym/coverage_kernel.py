"""Which cells beams pass through: a compiled kernel that visits cells, not beams.

A beam is sampled twice a cell, from the laser to its end; a cell that holds a sample is seen.
Of two cells, a sample on the edge between them falls into the right or upper one.
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
from cogmap_gym.raycast_kernel import ANGLE_ERROR, LANES, _angle

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
SAMPLE_M: Final = SAMPLE * CELL_M
"""The same [m]."""
MOST_SAMPLES: Final = 1e9
"""Of a beam, so that cells can be counted in 32 bits."""
NARROWEST: Final = 1e-12
"""A beam's direction cosines are at least this, so that none divides by nothing."""
NEARBY: Final = 0.25
"""Of a box as near as this any beam may enter it: its front over its middle. Ours."""
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
Scratch = tuple[Array, Array, Tiles, Array, Spans]


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
    beams, longest, bits, near, spans = scratch
    c, s = math.cos(heading), math.sin(heading)
    side = float(TILE * BLOCK)
    low_x, high_x, low_y, high_y = _lay_out(c, s, fan, last, ranges, beams)
    _find_longest(last, beams, longest)
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
                new += _look_at(count, unseen, blocks, c, s, last, step, scratch)
                count = 0
            for row in range(BLOCK * j, BLOCK * (j + 1)):
                for column in range(BLOCK * i, BLOCK * (i + 1)):
                    if unseen[row, column] != _NONE:
                        near[0, count], near[1, count] = column * TILE - x, row * TILE - y
                        spans[0, count], spans[1, count] = row, column
                        bits[count] = unseen[row, column]
                        count += 1
    return new + _look_at(count, unseen, blocks, c, s, last, step, scratch)


@part
def _lay_out(
    c: float, s: float, fan: Array, last: int, ranges: Array, beams: Array
) -> tuple[int, int, int, int]:
    """Write of each beam its step from sample to sample, one over that, and its samples.

    Answers a box about all beams from the laser: left, right, low and high, in cells.
    """
    left = right = low = high = np.int32(0)
    for b in range(np.uint64(last + 1)):
        step_x = SAMPLE * (c * fan[0, b] - s * fan[1, b])
        step_y = SAMPLE * (s * fan[0, b] + c * fan[1, b])
        samples = min(ranges[b] / SAMPLE_M, MOST_SAMPLES)
        beams[0, b], beams[1, b] = step_x, step_y
        beams[2, b] = 1.0 / step_x if abs(step_x) > NARROWEST else 1.0 / NARROWEST
        beams[3, b] = 1.0 / step_y if abs(step_y) > NARROWEST else 1.0 / NARROWEST
        beams[4, b] = samples
        end_x, end_y = np.int32(samples * step_x), np.int32(samples * step_y)
        left, right = min(left, end_x), max(right, end_x)
        low, high = min(low, end_y), max(high, end_y)
    return int(left) - 1, int(right) + 1, int(low) - 1, int(high) + 1


@part
def _find_longest(last: int, beams: Array, longest: Array) -> None:
    """Write the longest reach of each ``SPAN`` beams, squared, in cells.

    And of 2, 4, 8.. such spans from each one on, as far as there are so many.
    """
    groups = last // SPAN + 1
    for k in range(np.uint64(groups)):
        b = np.uint64(SPAN) * k
        one = max(beams[4, b], beams[4, b + np.uint64(1)])
        other = max(beams[4, b + np.uint64(2)], beams[4, b + np.uint64(3)])
        most = SAMPLE * max(one, other)
        longest[0, k] = most * most
    for level in range(1, len(longest)):
        half = np.uint64(1 << (level - 1))
        for k in range(np.uint64(max(groups + 1 - (1 << level), 0))):
            longest[level, k] = max(longest[level - 1, k], longest[level - 1, k + half])


@part
def _find_boxes(count: int, bits: Tiles, near: Array) -> None:
    """Write the box about the cells of each tile near by, from the laser."""
    for k in range(np.uint64((count + LANES - 1) // LANES * LANES)):
        columns = bits[k] | (bits[k] >> np.uint64(32))
        columns |= columns >> np.uint64(16)
        columns = (columns | (columns >> np.uint64(8))) & _ROW_BITS
        rows = bits[k] | (bits[k] >> np.uint64(4))
        rows |= rows >> np.uint64(2)
        rows = ((rows | (rows >> _ONE)) & _FIRST_COLUMN) * _GATHER >> np.uint64(56)
        x, y = near[0, k], near[1, k]
        near[2, k], near[3, k] = x + _LOWEST[columns], x + _HIGHEST[columns] + 1.0
        near[4, k], near[5, k] = y + _LOWEST[rows], y + _HIGHEST[rows] + 1.0


@part
def _find_spans(
    count: int, c: float, s: float, last: int, step: float, near: Array, spans: Spans
) -> None:
    """Write which beams may enter each box: first..end and 0..over; how near it is, squared."""
    per_step, middle, all_beams = 1.0 / step, 0.5 * last, 1.0 * last
    half_turn = last * step < HALF_TURN
    for k in range(np.uint64((count + LANES - 1) // LANES * LANES)):
        left, right, low, high = near[2, k], near[3, k], near[4, k], near[5, k]
        mx, my = 0.5 * (left + right), 0.5 * (low + high)
        wide, tall = 0.5 * (right - left), 0.5 * (high - low)
        squared, ax, ay = mx * mx + my * my, abs(mx), abs(my)
        # Tangents of the angles from the middle to the corners, and an angle is no larger.
        flank = (ax * tall + ay * wide) / (squared - abs(ax * wide - ay * tall))
        front = squared - ax * wide - ay * tall
        half = max(flank, abs(ax * tall - ay * wide) / front) + ANGLE_ERROR
        by = front <= NEARBY * squared
        fx, fy = c * mx + s * my, c * my - s * mx
        behind = half_turn and fx < 0.0 and fx * fx > wide * wide + tall * tall
        angle = _angle(fx, fy)
        begin, stop = angle - half, angle + half
        shift = math.tau if begin < -math.pi else 0.0
        begin, stop = begin + shift, stop + shift
        over = (stop - math.tau) * per_step + middle if stop > math.pi else -1.0
        first = min(max(begin * per_step + middle, 0.0), all_beams + 1.0)
        end = max(min(stop * per_step + middle, all_beams), -1.0)
        over = max(min(over, all_beams), -1.0)
        first, end, over = 0.0 if by else first, all_beams if by else end, -1.0 if by else over
        dx, dy = max(left, -right, 0.0), max(low, -high, 0.0)
        near[6, k] = dx * dx + dy * dy
        spans[2, k] = np.int32(np.ceil(first))
        spans[3, k] = np.int32(np.floor(-1.0 if behind else end))
        spans[4, k] = np.int32(np.floor(-1.0 if behind else over))


@part
def _look_at(
    count: int, unseen: Tiles, blocks: NDArray[np.uint8], c: float, s: float,
    last: int, step: float, scratch: Scratch,
) -> np.int64:  # fmt: skip
    """``look`` at the tiles near by."""
    _, longest, bits, near, spans = scratch
    _find_boxes(count, bits, near)
    _find_spans(count, c, s, last, step, near, spans)
    new = np.int64(0)
    for n in range(_sort_out(count, longest, near, spans)):
        k = spans[5, n]
        found = _passed(k, spans[6, n], spans[7, n], scratch)
        if found != _NONE:
            row, column = spans[0, k], spans[1, k]
            bits[k] ^= found
            unseen[row, column] = bits[k]
            new += _count(found)
            if bits[k] == _NONE:
                blocks[row // BLOCK, column // BLOCK] -= 1
    return new


@part
def _sort_out(count: int, longest: Array, near: Array, spans: Spans) -> int:
    """List the tiles near by that a beam is long enough for, and their beams; answer how many.

    A tile across the seam behind the fan stands there twice.
    """
    listed = 0
    for k in range(count):
        spans[5, listed], spans[6, listed], spans[7, listed] = k, spans[2, k], spans[3, k]
        listed += 1 if _longest(spans[2, k], spans[3, k], longest) >= near[6, k] else 0
        if spans[4, k] >= 0:
            spans[5, listed], spans[6, listed], spans[7, listed] = k, 0, spans[4, k]
            listed += 1 if _longest(0, spans[4, k], longest) >= near[6, k] else 0
    return listed


@part
def _longest(first: int, end: int, longest: Array) -> float:
    """The longest reach of some beams and a few beside them, squared, in cells; -1 of none."""
    some = end >= first
    begin = np.uint64(first if some else 0) // np.uint64(SPAN)
    stop = np.uint64(end if some else 0) // np.uint64(SPAN) + _ONE
    groups = stop - begin
    level = np.uint64(_HIGHEST[min(groups, np.uint64(255))])
    most = max(longest[level, begin], longest[level, stop - (_ONE << level)])
    most = most if groups < np.uint64(256) else math.inf
    return most if some else -1.0


@part
def _passed(k: int, first: int, end: int, scratch: Scratch) -> np.uint64:
    """The cells of a tile near by that samples of beams first..end fall into."""
    beams, _, all_bits, near, _ = scratch
    bits, x, y = all_bits[k], near[0, k], near[1, k]
    x0, x1, y0, y1 = near[2, k], near[3, k], near[4, k], near[5, k]
    found = _NONE
    for at in range(first, end + 1, CHUNK):  # The box first, then the cells of each row.
        if _crossing(x0, y0, x1, y1, at, beams) == _NONE:
            continue
        for row in range(TILE):
            cells = (bits >> np.uint64(TILE * row)) & _ROW_BITS
            if cells == _NONE:
                continue
            left, right = x + _LOWEST[cells], x + _HIGHEST[cells] + 1
            crossing = _crossing(left, y + row, right, y + row + 1, at, beams)
            while crossing != _NONE:
                b = at + int(_count((crossing - _ONE) & ~crossing))
                crossing &= crossing - _ONE
                found |= bits & _along(b, x, y, left, y + row, right, y + row + 1, beams)
    return found


@part
def _crossing(x0: float, y0: float, x1: float, y1: float, at: int, beams: Array) -> np.uint64:
    """Which of ``CHUNK`` beams have samples in a box, a bit a beam."""
    crossing, begin_at = _NONE, np.uint64(at)
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
    """What a look writes and forgets, for a laser of so many beams.

    - (5, beams + ``CHUNK``): steps along x and y from sample to sample, one over these, and the
      last sample of each beam, -1 past the last beam.
    - (levels, spans): the longest reach of 1, 2, 4.. spans of beams, squared.
    - (``MOST``,): unseen cells of each tile near by.
    - (7, ``MOST``): its corner's x and y, left, right, low and high of the box about its unseen
      cells, from the laser, and the box's distance, squared.
    - (8, 2 ``MOST``): its row and column; the first and the last beam that may enter the box,
      and the last beyond the seam behind the fan; then, as listed by ``_sort_out``, a tile's
      number here and the first and the last beam.
    """
    reaches = np.zeros((5, beams + CHUNK))
    reaches[4, beams:] = -1.0
    groups = (beams - 1) // SPAN + 1
    longest = np.zeros((min(groups.bit_length(), 8), groups))
    bits, spans = np.zeros(MOST, dtype=np.uint64), np.zeros((8, 2 * MOST), dtype=np.int32)
    return reaches, longest, bits, np.zeros((7, MOST)), spans


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
