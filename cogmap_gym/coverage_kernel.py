"""Which cells beams pass through: a compiled kernel that visits cells, not beams.

A beam is sampled twice a cell, from the laser to its end; a cell that holds a sample is seen.
Of two cells, a sample on the edge between them falls into the right or upper one.
What one robot has not seen yet is kept as tiles (``tile_kernel``), and blocks of tiles, each with
the number of its tiles that are not empty. A look gathers the tiles that are not empty, passes
over those that no beam can reach, and asks of the beams left whether a sample of theirs falls
into a cell. Loops over beams are laid out so that the compiler does several at once.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym import grid, kernel_parts, raycast_kernel, tile_kernel
from cogmap_gym.geometry import Array
from cogmap_gym.grid import CELL_M
from cogmap_gym.kernel_parts import fingerprint, part, whole
from cogmap_gym.tile_kernel import (
    BLOCK,
    HIGHEST,
    LOWEST,
    NONE,
    ONE,
    ROW_BITS,
    TILE,
    Spans,
    Tiles,
    count_bits,
    find_boxes,
    find_spans,
)

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
MOST: Final = 256
"""Tiles that are sorted out at once. Ours."""
Scratch = tuple[Array, Array, Tiles, Array, Spans]


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
                    if unseen[row, column] != NONE:
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
def _look_at(
    count: int, unseen: Tiles, blocks: NDArray[np.uint8], c: float, s: float,
    last: int, step: float, scratch: Scratch,
) -> np.int64:  # fmt: skip
    """``look`` at the tiles near by."""
    _, longest, bits, near, spans = scratch
    find_boxes(count, bits, near)
    find_spans(count, c, s, last, step, near, spans)
    new = np.int64(0)
    for n in range(_sort_out(count, longest, near, spans)):
        k = spans[5, n]
        found = _passed(k, spans[6, n], spans[7, n], scratch)
        if found != NONE:
            row, column = spans[0, k], spans[1, k]
            bits[k] ^= found
            unseen[row, column] = bits[k]
            new += count_bits(found)
            if bits[k] == NONE:
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
    stop = np.uint64(end if some else 0) // np.uint64(SPAN) + ONE
    groups = stop - begin
    level = np.uint64(HIGHEST[min(groups, np.uint64(255))])
    most = max(longest[level, begin], longest[level, stop - (ONE << level)])
    most = most if groups < np.uint64(256) else math.inf
    return most if some else -1.0


@part
def _passed(k: int, first: int, end: int, scratch: Scratch) -> np.uint64:
    """The cells of a tile near by that samples of beams first..end fall into."""
    beams, _, all_bits, near, _ = scratch
    bits, x, y = all_bits[k], near[0, k], near[1, k]
    x0, x1, y0, y1 = near[2, k], near[3, k], near[4, k], near[5, k]
    found = NONE
    for at in range(first, end + 1, CHUNK):  # The box first, then the cells of each row.
        if _crossing(x0, y0, x1, y1, at, beams) == NONE:
            continue
        for row in range(TILE):
            cells = (bits >> np.uint64(TILE * row)) & ROW_BITS
            if cells == NONE:
                continue
            left, right = x + LOWEST[cells], x + HIGHEST[cells] + 1
            crossing = _crossing(left, y + row, right, y + row + 1, at, beams)
            while crossing != NONE:
                b = at + int(count_bits((crossing - ONE) & ~crossing))
                crossing &= crossing - ONE
                found |= bits & _along(b, x, y, left, y + row, right, y + row + 1, beams)
    return found


@part
def _crossing(x0: float, y0: float, x1: float, y1: float, at: int, beams: Array) -> np.uint64:
    """Which of ``CHUNK`` beams have samples in a box, a bit a beam."""
    crossing, begin_at = NONE, np.uint64(at)
    for lane in range(np.uint64(CHUNK)):
        b = begin_at + lane
        xa, xb = x0 * beams[2, b], x1 * beams[2, b]
        ya, yb = y0 * beams[3, b], y1 * beams[3, b]
        begin = max(max(min(xa, xb), min(ya, yb)), 0.0)
        stop = min(min(max(xa, xb), max(ya, yb)), beams[4, b])
        crossing |= (ONE << lane) if np.floor(stop) >= np.ceil(begin) else NONE
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
    found = NONE
    for k in range(math.ceil(begin), math.floor(stop) + 1):
        column, row = math.floor(k * beams[0, b] - x), math.floor(k * beams[1, b] - y)
        if 0 <= column < TILE and 0 <= row < TILE:
            found |= ONE << np.uint64(TILE * row + column)
    return found


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


look_once = _kernel(fingerprint(grid, kernel_parts, raycast_kernel, tile_kernel))
