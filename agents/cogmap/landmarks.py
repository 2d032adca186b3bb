"""Algorithm 4: which surfaces of a view are surfaces already known (thesis 3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from agents.cogmap.params import Landmarks
from cogmap_gym.geometry import Segments

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """Each view surface x (row) against each known surface y (column), in one frame."""

    hits: Ints
    """Imaginary lines across x that meet y (Fig. 3.10), (N, M)."""
    turn: Floats
    """Heading of x less heading of y [rad], (N, M)."""
    offset: Floats
    """Distance of x to the left of y's line, at the middle of what they share [m], (N, M)."""
    overlap: Floats
    """Length they share along y; negative where they are apart [m], (N, M)."""


def find_landmarks(x: Segments, y: Segments, params: Landmarks) -> Ints:
    """Algorithm 4: find landmarks in view.

    Args:
        x: surfaces of the view V_n, (N, 2, 2).
        y: known surfaces laid into the same frame, (M, 2, 2).
        params: thresholds.

    Returns:
        (N,): for each x the row of the matching y, or -1.
    """
    if len(x) == 0 or len(y) == 0:
        return np.full(len(x), -1, dtype=np.int64)
    compared = compare(x, y, params)
    candidate = candidates(compared, params)
    turn = np.abs(compared.turn)
    # Select the best candidate: the most similar orientation.
    cost = turn
    if not params.literal:
        # Departs from the selection: parallel edges of furniture tie on orientation alone.
        cost = turn / params.max_turn + np.abs(compared.offset) / params.reach
    cost = np.where(candidate, cost, np.inf)
    best = cost.argmin(axis=1)
    found = np.isfinite(cost[np.arange(len(x)), best])
    return np.where(found, best, -1).astype(np.int64)


def candidates(compared: Comparison, params: Landmarks) -> NDArray[np.bool_]:
    """Algorithm 4, steps 1 to 3: which y are candidates for which x, (N, M)."""
    turn = np.abs(compared.turn)
    if params.literal:
        turn = np.minimum(turn, math.pi - turn)
    # Step 1: strong evidence is enough
    strong = compared.hits > params.strong_hits
    # Step 2: weak evidence asks for a similar orientation
    weak = (compared.hits > 0) & (turn <= params.similar_turn)
    # Step 3: neither, no candidate
    found = strong | weak
    if not params.literal:
        # Departs from step 1: directed surfaces, and a limit of turn for strong evidence too;
        # wrong associations fall from 17 % to none (FINDINGS 3).
        found &= (turn <= params.max_turn) & (compared.overlap > 0.0)
    return np.asarray(found)


def compare(x: Segments, y: Segments, params: Landmarks) -> Comparison:
    """Compare each x (N, 2, 2) with each y (M, 2, 2)."""
    reach = params.literal_reach if params.literal else params.reach
    return Comparison(*_compare(x, y, reach, params.interval))


@njit(cache=True)
def _compare(
    x: Segments, y: Segments, reach: float, interval: float
) -> tuple[Ints, Floats, Floats, Floats]:
    n, m = len(x), len(y)
    hits = np.zeros((n, m), np.int64)
    turn, offset, overlap = np.zeros((n, m)), np.zeros((n, m)), np.full((n, m), -np.inf)
    for i in range(n):
        dx, dy = x[i, 1, 0] - x[i, 0, 0], x[i, 1, 1] - x[i, 0, 1]
        length = max(math.hypot(dx, dy), 1e-9)
        dx, dy = dx / length, dy / length
        for j in range(m):
            ux, uy = y[j, 1, 0] - y[j, 0, 0], y[j, 1, 1] - y[j, 0, 1]
            span = max(math.hypot(ux, uy), 1e-9)
            ux, uy = ux / span, uy / span
            turn[i, j] = math.atan2(ux * dy - uy * dx, ux * dx + uy * dy)
            ax, ay = x[i, 0, 0] - y[j, 0, 0], x[i, 0, 1] - y[j, 0, 1]
            bx, by = x[i, 1, 0] - y[j, 0, 0], x[i, 1, 1] - y[j, 0, 1]
            s0, s1 = ux * ax + uy * ay, ux * bx + uy * by
            t0, t1 = ux * ay - uy * ax, ux * by - uy * bx
            lo, hi = max(min(s0, s1), 0.0), min(max(s0, s1), span)
            overlap[i, j] = hi - lo
            middle = 0.5 * (lo + hi)
            across = s1 - s0 if abs(s1 - s0) > 1e-9 else 1e-9
            offset[i, j] = t0 + (t1 - t0) * min(max((middle - s0) / across, 0.0), 1.0)
            if min(abs(t0), abs(t1)) > reach + span and overlap[i, j] < -reach:
                continue
            probe = 0.0
            while probe <= length + 1e-9:
                px, py = x[i, 0, 0] + probe * dx, x[i, 0, 1] + probe * dy
                if _meets(px, py, -dy, dx, reach, y[j]):
                    hits[i, j] += 1
                probe += interval
    return hits, turn, offset, overlap


@njit(cache=True)
def _meets(px: float, py: float, nx: float, ny: float, reach: float, y: Floats) -> bool:
    """Whether the line from p, ``reach`` to both sides along n, meets segment y (2, 2)."""
    ux, uy = y[1, 0] - y[0, 0], y[1, 1] - y[0, 1]
    denominator = nx * uy - ny * ux
    if abs(denominator) < 1e-12:
        return False
    qx, qy = y[0, 0] - px, y[0, 1] - py
    t = (qx * uy - qy * ux) / denominator
    s = (qx * ny - qy * nx) / denominator
    return bool(abs(t) <= reach and 0.0 <= s <= 1.0)
