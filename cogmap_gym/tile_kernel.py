"""Tiles of cells, a bit a cell: how they are packed, where their cells lie, which beams may enter.

A tile is 8 by 8 cells, a block 4 by 4 tiles. Loops over tiles are laid out so that the compiler
does several at once.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array
from cogmap_gym.grid import Mask
from cogmap_gym.kernel_parts import part
from cogmap_gym.raycast_kernel import ANGLE_ERROR, LANES, _angle

TILE: Final = 8
"""Cells along a side of a tile: 64 bits."""
BLOCK: Final = 4
"""Tiles along a side of a block. Ours."""
NEARBY: Final = 0.25
"""Of a box as near as this any beam may enter it: its front over its middle. Ours."""
HALF_TURN: Final = math.pi + 1e-9
"""A fan no wider than this sees nothing behind the laser [rad]."""
ONE, NONE, ROW_BITS = np.uint64(1), np.uint64(0), np.uint64(255)
_FIRST_COLUMN, _GATHER = np.uint64(0x0101010101010101), np.uint64(0x0102040810204080)
LOWEST = np.array([0, *((k & -k).bit_length() - 1 for k in range(1, 256))])
HIGHEST = np.array([0, *(k.bit_length() - 1 for k in range(1, 256))])
"""The lowest and the highest bit of a byte; 0 of none."""
Tiles = NDArray[np.uint64]
Spans = NDArray[np.int32]


def tiles_of(cells: Mask) -> Tiles:
    """Cells (rows, columns) as tiles (R, C), R and C multiples of ``BLOCK``; bit 8 r + c."""
    side = TILE * BLOCK
    rows, columns = (-(-n // side) * side for n in cells.shape)
    padded = np.zeros((rows, columns), dtype=np.uint64)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    parts = padded.reshape(rows // TILE, TILE, columns // TILE, TILE)
    bits = ONE << np.arange(TILE * TILE, dtype=np.uint64).reshape(TILE, TILE)
    return np.asarray((parts * bits[None, :, None, :]).sum(axis=(1, 3), dtype=np.uint64))


def blocks_of(tiles: Tiles) -> NDArray[np.uint8]:
    """How many tiles of each block are not empty, (R / 4, C / 4)."""
    parts = (tiles != 0).reshape(tiles.shape[0] // BLOCK, BLOCK, -1, BLOCK)
    return np.asarray(parts.sum(axis=(1, 3), dtype=np.uint8))


@part
def find_boxes(count: int, bits: Tiles, near: Array) -> None:
    """Write the box about the cells of each tile near by, from the laser."""
    for k in range(np.uint64((count + LANES - 1) // LANES * LANES)):
        columns = bits[k] | (bits[k] >> np.uint64(32))
        columns |= columns >> np.uint64(16)
        columns = (columns | (columns >> np.uint64(8))) & ROW_BITS
        rows = bits[k] | (bits[k] >> np.uint64(4))
        rows |= rows >> np.uint64(2)
        rows = ((rows | (rows >> ONE)) & _FIRST_COLUMN) * _GATHER >> np.uint64(56)
        x, y = near[0, k], near[1, k]
        near[2, k], near[3, k] = x + LOWEST[columns], x + HIGHEST[columns] + 1.0
        near[4, k], near[5, k] = y + LOWEST[rows], y + HIGHEST[rows] + 1.0


@part
def find_spans(
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
def count_bits(bits: np.uint64) -> np.int64:
    """How many bits are set."""
    pairs = bits - ((bits >> ONE) & np.uint64(0x5555555555555555))
    fours = np.uint64(0x3333333333333333)
    pairs = (pairs & fours) + ((pairs >> np.uint64(2)) & fours)
    bytes_ = (pairs + (pairs >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((bytes_ * _FIRST_COLUMN) >> np.uint64(56))
