"""Cheapest ways over the grid: Dijkstra's algorithm with Dial's buckets, compiled.

R. B. Dial, Algorithm 360: shortest-path forest with topological ordering, CACM 12 (1969).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cogmap_gym.geometry import Array

Prices = NDArray[np.int16]
Costs = NDArray[np.int32]
UNREACHED = np.iinfo(np.int32).max
STRAIGHT, DIAGONAL = 10, 14
"""Steps to the side and across, in tenths of a cell."""


@njit(cache=True)
def price_cells(
    votes: NDArray[np.int8],
    clearance: NDArray[np.float32],
    barred: NDArray[np.int32],
    since: int,
    gaps: Array,
    costs: Array,
) -> Prices:
    """What it costs to enter each cell, (H, W), in tenths of a free one; 0 for no way.

    Args:
        votes: (H, W): above 0 occupied, below free, 0 never seen.
        clearance: (H, W) [cells].
        barred: (H, W) steps at which cells proved to be no way.
        since: those barred before this step are free again.
        gaps: nearer to a thing than the first is no way, than the second is tight, than the
            third costs more [cells].
        costs: at the second gap, of a tight cell, and how many times more of an unknown one.
    """
    height, width = votes.shape
    price = np.zeros((height, width), dtype=np.int16)
    wall, body, comfort = gaps
    crowded, tight, unknown = costs
    for i in range(height):
        for j in range(width):
            gap = clearance[i, j]
            if votes[i, j] > 0 or gap < wall or (barred[i, j] >= 0 and barred[i, j] >= since):
                continue
            cost = float(STRAIGHT)
            if gap < body:
                cost = tight
            elif gap < comfort:
                cost += (crowded - cost) * ((comfort - gap) / (comfort - body)) ** 2
            price[i, j] = cost if votes[i, j] < 0 else cost * unknown / STRAIGHT
    return price


@njit(cache=True)
def flood(
    price: Prices, start: int, is_end: NDArray[np.bool_]
) -> tuple[Costs, NDArray[np.int32], int]:
    """Costs of the cells in growing order from ``start`` until the first end.

    Args:
        price: (H, W) of entering a cell, in tenths of that of a free one; 0 is no way.
        start: index of a cell in the flat grid; its own price does not count.
        is_end: (H, W) where to stop.

    Returns:
        costs (H * W,), ``UNREACHED`` where the flood did not come, in tenths of a cell's side;
        from which cell each was reached (H * W,), -1 for none; and the end, or -1.
    """
    height, width = price.shape
    costs = np.full(height * width, UNREACHED, dtype=np.int32)
    origin = np.full(height * width, -1, dtype=np.int32)
    after = np.full(height * width, -1, dtype=np.int32)
    ahead = np.full(height * width, -1, dtype=np.int32)
    buckets = int(price.max()) * DIAGONAL // STRAIGHT + 1
    heads = np.full(buckets, -1, dtype=np.int32)
    costs[start] = 0
    link(start, 0, heads, after, ahead)
    waiting, cost, end = 1, 0, -1
    while waiting > 0 and end < 0:
        cell = heads[cost % buckets]
        if cell < 0:
            cost += 1
            continue
        unlink(cell, cost % buckets, heads, after, ahead)
        waiting -= 1
        row, column = cell // width, cell % width
        if is_end[row, column]:
            end = cell
        for i in range(max(0, row - 1), min(height, row + 2)):
            for j in range(max(0, column - 1), min(width, column + 2)):
                length = DIAGONAL if i != row and j != column else STRAIGHT
                total, other = cost + price[i, j] * length // STRAIGHT, i * width + j
                if price[i, j] == 0 or total >= costs[other]:
                    continue
                if costs[other] != UNREACHED:
                    unlink(other, costs[other] % buckets, heads, after, ahead)
                    waiting -= 1
                costs[other], origin[other] = total, cell
                link(other, total % buckets, heads, after, ahead)
                waiting += 1
    return costs, origin, end


@njit(cache=True)
def link(cell: int, bucket: int, heads: Costs, after: Costs, ahead: Costs) -> None:
    """Put a cell at the head of a bucket: a list with ``after`` and ``ahead`` of each cell."""
    after[cell], ahead[cell] = heads[bucket], -1
    if heads[bucket] >= 0:
        ahead[heads[bucket]] = cell
    heads[bucket] = cell


@njit(cache=True)
def unlink(cell: int, bucket: int, heads: Costs, after: Costs, ahead: Costs) -> None:
    """Take a cell out of a bucket."""
    if ahead[cell] >= 0:
        after[ahead[cell]] = after[cell]
    else:
        heads[bucket] = after[cell]
    if after[cell] >= 0:
        ahead[after[cell]] = ahead[cell]


@njit(cache=True)
def frontier_cells(
    votes: NDArray[np.int8],
    clearance: NDArray[np.float32],
    ignored: NDArray[np.bool_],
    off_wall: float,
    fewest: int,
) -> NDArray[np.bool_]:
    """The free cells beside the unknown.

    Args:
        votes: (H, W): above 0 occupied, below free, 0 never seen.
        clearance: (H, W) [cells].
        ignored: (H, W) cells that are not to count.
        off_wall: an unknown cell nearer to an occupied one belongs to it [cells].
        fewest: so many unknown cells, off walls, there must be among the 25 about the cell.
    """
    height, width = votes.shape
    found = np.zeros((height, width), dtype=np.bool_)
    for i in range(2, height - 2):
        for j in range(2, width - 2):
            if votes[i, j] >= 0 or ignored[i, j]:
                continue
            if (
                votes[i - 1, j] != 0
                and votes[i + 1, j] != 0
                and votes[i, j - 1] != 0
                and votes[i, j + 1] != 0
            ):
                continue
            count = 0
            for a in range(i - 2, i + 3):
                for b in range(j - 2, j + 3):
                    count += votes[a, b] == 0 and clearance[a, b] >= off_wall
            found[i, j] = count >= fewest
    return found
