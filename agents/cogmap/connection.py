"""Compiled kernels of the boundary walk: connections between items, and the cheapest round."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from agents.cogmap.rays import crosses
from cogmap_gym.geometry import Array, Points, Segments

NO_GROUP = -1
"""The group of what is no item: path and lines of sight [1]."""
LEAST_TURN, MOST_TURN = -2, 3
"""How often a walk may have crossed the outward line on its way [1]; once round is 1."""


@njit(cache=True)
def lay(
    lines: Segments,
    is_exit: NDArray[np.bool_],
    max_trim: float,
    max_extend: float,
    overlap_offset: float,
    min_sine: float,
) -> tuple[Points, Points, Array]:
    """Where the connection from each line's end to each other's start leaves and enters.

    Lines that make a corner are lengthened or cut to it; one wall mapped twice is joined
    in the middle of the overlap; otherwise the connection is straight from end to start.

    Args:
        lines: (N, 2, 2).
        is_exit: (N,), these are never lengthened nor cut.
        max_trim: most that is cut off a line [m].
        max_extend: most that a line is lengthened [m].
        overlap_offset: lines nearer than this are one wall [m].
        min_sine: sine of the least angle that makes a corner [1].

    Returns:
        Leaving points (N, N, 2), entering points (N, N, 2) and gaps (N, N) [m].
    """
    n = len(lines)
    leave, enter, gap = np.empty((n, n, 2)), np.empty((n, n, 2)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            p, q = lines[i, 1], lines[j, 0]
            u, v, w = p - lines[i, 0], lines[j, 1] - q, q - p
            leave[i, j], enter[i, j], gap[i, j] = p, q, np.hypot(w[0], w[1])
            a, b = np.hypot(u[0], u[1]), np.hypot(v[0], v[1])
            if is_exit[i] or is_exit[j] or a == 0.0 or b == 0.0:
                continue
            u, v = u / a, v / b
            sine = u[0] * v[1] - u[1] * v[0]
            if abs(sine) >= min_sine:
                ahead = (w[0] * v[1] - w[1] * v[0]) / sine
                behind = (w[1] * u[0] - w[0] * u[1]) / sine
                near = ahead >= -min(max_trim, 0.5 * a) and behind >= -min(max_trim, 0.5 * b)
                if near and max(ahead, behind) <= max_extend:
                    leave[i, j] = enter[i, j] = p + ahead * u
                    gap[i, j] = abs(ahead) + abs(behind)
            elif u[0] * v[0] + u[1] * v[1] > 0.0:
                m = (u + v) / np.hypot(u[0] + v[0], u[1] + v[1])
                over, side = -(w[0] * m[0] + w[1] * m[1]), abs(w[0] * m[1] - w[1] * m[0])
                if 0.0 < over < min(a, b) and side < overlap_offset:
                    leave[i, j], enter[i, j] = p - 0.5 * over * u, q + 0.5 * over * v
                    gap[i, j] = side
    return leave, enter, gap


@njit(cache=True)
def weigh(
    lines: Segments,
    group: NDArray[np.int64],
    leave: Points,
    enter: Points,
    gap: Array,
    blockers: Segments,
    toll: Array,
    blocker_group: NDArray[np.int64],
) -> Array:
    """Gap plus the tolls of what each connection crosses, (N, N); its own items are free."""
    n = len(lines)
    cost = gap.copy()
    for i in range(n):
        for j in range(n):
            if cost[i, j] == np.inf:
                continue
            # Extended: end to leave, enter to start. Else leave to enter, or nothing.
            ax, ay, bx, by = lines[i, 1, 0], lines[i, 1, 1], leave[i, j, 0], leave[i, j, 1]
            cx, cy, dx, dy = enter[i, j, 0], enter[i, j, 1], lines[j, 0, 0], lines[j, 0, 1]
            ux, uy = ax - lines[i, 0, 0], ay - lines[i, 0, 1]
            vx, vy = lines[j, 1, 0] - dx, lines[j, 1, 1] - dy
            if (bx - ax) * ux + (by - ay) * uy <= 0.0:
                ax, ay = bx, by
            if (dx - cx) * vx + (dy - cy) * vy <= 0.0:
                dx, dy = cx, cy
            for k in range(len(blockers)):
                if blocker_group[k] in (group[i], group[j]):
                    continue
                other = blockers[k]
                if (
                    crosses(ax, ay, bx, by, other)
                    or crosses(bx, by, cx, cy, other)
                    or crosses(cx, cy, dx, dy, other)
                ):
                    cost[i, j] += toll[k]
    return cost


@njit(cache=True)
def turns(
    lines: Segments, leave: Points, enter: Points, origin: Points, outward: Points
) -> NDArray[np.int64]:
    """Signed crossings (N, N) of a ray by each connection and the line it leads to.

    Summed over a closed walk they are its winding number round the ray's origin.
    """
    n = len(lines)
    out = np.zeros((n, n), dtype=np.int64)
    for i in range(n):
        for j in range(n):
            points = (lines[i, 1], leave[i, j], enter[i, j], lines[j, 0], lines[j, 1])
            for k in range(4):
                p, q = points[k] - origin, points[k + 1] - origin
                above = outward[0] * p[1] - outward[1] * p[0]
                after = outward[0] * q[1] - outward[1] * q[0]
                if (above > 0.0) != (after > 0.0):
                    meet = p + above / (above - after) * (q - p)
                    if meet[0] * outward[0] + meet[1] * outward[1] > 0.0:
                        out[i, j] += 1 if after > 0.0 else -1
    return out


@njit(cache=True)
def round_trip(cost: Array, turn: NDArray[np.int64]) -> tuple[float, NDArray[np.int64]]:
    """The cheapest walk from item 0 back to it that turns once round, by Dijkstra.

    Returns:
        Its cost, and the items between in order; infinite and none if there is no walk.
    """
    n, depth = len(cost), MOST_TURN - LEAST_TURN + 1
    best, done = np.full((n, depth), np.inf), np.zeros((n, depth), dtype=np.bool_)
    before = np.full((n, depth), -1)
    at, level, least = 0, -LEAST_TURN, 0.0
    goal = 1 - LEAST_TURN
    while True:
        for k in range(n):
            to = level + turn[at, k]
            if 0 <= to < depth and least + cost[at, k] < best[k, to]:
                best[k, to] = least + cost[at, k]
                before[k, to] = at * depth + level
        least = np.inf
        for state in range(n * depth):
            k, to = state // depth, state % depth
            # Item 0 ends a walk; it does not lead on.
            if not done[k, to] and best[k, to] < least and (k > 0 or to == goal):
                least, at, level = best[k, to], k, to
        if least == np.inf or at == 0:
            break
        done[at, level] = True
    chain = np.zeros(n * depth, dtype=np.int64)
    size = 0
    if least < np.inf:
        state = before[0, goal]
        while state // depth != 0:
            chain[size] = state // depth
            state, size = before[state // depth, state % depth], size + 1
    return least, chain[:size][::-1].copy()
