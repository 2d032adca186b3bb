"""The compiled twin of ``Routes.distance``, given the lengths from the nodes of the graph."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, Points, Segments
from cogmap_gym.kernel_parts import part
from cogmap_gym.visibility import _blocker


@part
def distance_to_goal(
    x: float, y: float, mark_x: float, mark_y: float, reach: float, mark_reach: float,
    nodes: Points, lengths: Array, walls: Segments, leaves: Segments,
    solid: NDArray[np.bool_], values: Array,
) -> float:  # fmt: skip
    """Length of the shortest way from (x, y) to a mark [m]; infinite where there is none.

    Args:
        x: [m].
        y: [m].
        mark_x: [m].
        mark_y: [m].
        reach: what the way must keep clear at its start [m].
        mark_reach: the same at its end [m].
        nodes: (K, 2), where ways may bend [m].
        lengths: (K,) or longer, from each node to the mark [m].
        walls: (N, 2, 2), what stands still [m].
        leaves: (M, 2, 2), doors and barriers [m].
        solid: (M,) or longer, which of them are in the way.
        values: (K,) or longer, scratch.
    """
    if _is_free(x, y, mark_x, mark_y, walls, leaves, solid, min(reach, mark_reach)):
        return math.hypot(mark_x - x, mark_y - y)
    for k in range(len(nodes)):
        dx, dy = nodes[k, 0] - x, nodes[k, 1] - y
        values[k] = lengths[k] + math.sqrt(dx * dx + dy * dy)
    while True:
        best, least = -1, math.inf
        for k in range(len(nodes)):
            if values[k] < least:
                best, least = k, values[k]
        if best < 0 or _is_free(x, y, nodes[best, 0], nodes[best, 1], walls, leaves, solid, reach):
            return least
        values[best] = math.inf


@part
def _is_free(
    ax: float, ay: float, bx: float, by: float, walls: Segments, leaves: Segments,
    solid: NDArray[np.bool_], reach: float,
) -> bool:  # fmt: skip
    """Whether a disc can drive straight from a to b."""
    if _blocker(ax, ay, bx, by, walls, reach, 0) >= 0:
        return False
    for m in range(len(leaves)):
        if solid[m] and _blocker(ax, ay, bx, by, leaves[m : m + 1], reach, 0) >= 0:
            return False
    return True
