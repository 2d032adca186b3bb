"""Closing a loop by association: whether an unknown place is one the robot knows (thesis 4.2.2).

The thesis names an old surface wherever a new one falls upon it. One corridor looks like another,
so here a place is recognised only on discriminating evidence held over several views (FINDINGS 5).
No old surface is moved: on acceptance the robot's own pose is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from agents.cogmap.navigator import sample_surfaces
from agents.cogmap.params import Association
from cogmap_gym.geometry import Array, Points, Pose, Segments


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """Beams of the last views in an unknown place, laid into the MFIS by the robot's own pose."""

    origins: Points
    """(B, 2)."""
    ends: Points
    """(B, 2)."""

    def moved(self, shift: Pose) -> Beams:
        """The same beams under a corrected pose."""
        return Beams(shift.apply(self.origins), shift.apply(self.ends))


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """That the robot is in a known place, and how its pose must then be shifted."""

    place: int
    shift: Pose
    """``mfis_from_provisional``."""
    coverage: float
    """Share of beams that end on a surface of the place."""
    contradiction: float
    """Share of judged beams that go through one."""
    distance: float
    """How far the pose is shifted [m]."""

    def score(self, params: Association) -> float:
        """What ranks shifts into one place, and places."""
        return self.coverage - self.contradiction - params.shift_penalty * self.distance

    def sure(self, params: Association) -> bool:
        """Whether the beams fit so well, and so near, that a rough boundary need not agree."""
        return (
            self.coverage >= params.sure_coverage
            and self.contradiction <= params.sure_contradiction
            and self.distance <= params.base_shift
        )

    def holds(self, params: Association) -> bool:
        """Whether the evidence alone is good enough."""
        return (
            self.coverage >= params.min_coverage and self.contradiction <= params.max_contradiction
        )


def best_hypothesis(
    place: int, surfaces: Segments, beams: Beams, travelled: float, params: Association
) -> Hypothesis:
    """How the robot's pose must be shifted to be in this place, and what speaks for it.

    Args:
        place: the id of a known ASR.
        surfaces: (M, 2, 2) its surfaces in the MFIS.
        beams: what was seen since the robot entered, in the MFIS by its own pose.
        travelled: metres since the robot last left the place; bounds its drift.
        params: thresholds.
    """
    reach = min(params.base_shift + params.shift_per_metre * travelled, params.max_shift)
    turn = min(params.base_turn + params.turn_per_metre * travelled, params.max_turn)
    pivot = beams.origins.mean(axis=0)
    ends = beams.ends[:: max(1, len(beams.ends) // params.search_beams)] - pivot
    field, low = _distance_field(surfaces, beams, reach, params.field_cell)
    best: Hypothesis | None = None
    for peak in _peaks(ends, pivot - low, field, reach, turn, params):
        at = _refine(ends, pivot - low, field, peak, params)
        shift = Pose(at[0] + pivot[0], at[1] + pivot[1], at[2]) @ Pose(-pivot[0], -pivot[1], 0.0)
        moved = beams.moved(shift)
        matched, through, count = evidence(moved.origins, moved.ends, surfaces, params.beam_match)
        tried = Hypothesis(
            place,
            shift,
            matched / max(count, 1),
            through / max(matched + through, 1),
            float(np.hypot(at[0], at[1])),
        )
        if best is None or tried.score(params) > best.score(params):
            best = tried
    assert best is not None, "a search has at least one peak"
    return best


def _peaks(
    ends: Points,
    pivot: Points,
    field: NDArray[np.float32],
    reach: float,
    turn: float,
    params: Association,
) -> Array:
    """The best shifts (x, y, theta) of a coarse search, apart from each other, (K, 3)."""
    offsets, turns = _offsets(reach, params.search_step), _offsets(turn, params.search_turn)
    zero = np.zeros(3)
    scores = _scores(ends, pivot, field, params.field_cell, zero, offsets, turns, params.beam_match)
    shift = np.hypot(offsets[:, None], offsets[None])
    scores = np.where(shift <= reach, scores - params.shift_penalty * shift, -np.inf)
    best_turn = scores.argmax(axis=0)
    scores = scores.max(axis=0)
    peaks = []
    for _ in range(params.peaks):
        i, j = np.unravel_index(int(scores.argmax()), scores.shape)
        if not np.isfinite(scores[i, j]):
            break
        peaks.append((offsets[i], offsets[j], turns[best_turn[i, j]]))
        near = np.hypot(offsets[:, None] - offsets[i], offsets[None] - offsets[j])
        scores[near < params.peak_distance] = -np.inf
    return np.array(peaks)


def _refine(
    ends: Points, pivot: Points, field: NDArray[np.float32], at: Array, params: Association
) -> Array:
    """A peak (x, y, theta) made sharp by ever finer searches about it."""
    reach, turn = params.search_step, params.search_turn
    for _ in range(params.refinements):
        offsets, turns = _offsets(reach, reach / 2.0), _offsets(turn, turn / 2.0)
        scores = _scores(
            ends, pivot, field, params.field_cell, at, offsets, turns, params.beam_match
        )
        t, i, j = np.unravel_index(int(scores.argmax()), scores.shape)
        at = at + np.array((offsets[i], offsets[j], turns[t]))
        reach, turn = reach / 2.0, turn / 2.0
    return at


def _offsets(reach: float, step: float) -> Array:
    count = math.ceil(reach / step)
    return np.linspace(-reach, reach, 2 * count + 1)


def _distance_field(
    surfaces: Segments, beams: Beams, reach: float, cell: float
) -> tuple[NDArray[np.float32], Points]:
    """Distance to the nearest surface [m] on a grid, and the grid's lower corner."""
    low = beams.ends.min(axis=0) - reach - 2.0 * cell
    high = beams.ends.max(axis=0) + reach + 2.0 * cell
    shape = np.ceil((high - low) / cell).astype(np.int64) + 1
    empty = np.ones(shape, dtype=np.bool_)
    at = np.floor((sample_surfaces(surfaces, cell) - low) / cell).astype(np.int64)
    at = at[((at >= 0) & (at < shape)).all(axis=1)]
    empty[at[:, 0], at[:, 1]] = False
    if empty.all():
        return np.full(shape, np.inf, dtype=np.float32), low
    return (distance_transform_edt(empty) * cell).astype(np.float32), low


@njit(cache=True)
def _scores(
    ends: Points,
    pivot: Points,
    field: NDArray[np.float32],
    cell: float,
    centre: Array,
    offsets: Array,
    turns: Array,
    reach: float,
) -> Array:
    """How well ends, turned and shifted about the pivot, lie on surfaces, (turns, x, y)."""
    out = np.zeros((len(turns), len(offsets), len(offsets)))
    nx, ny = field.shape
    for t in range(len(turns)):
        c, s = math.cos(centre[2] + turns[t]), math.sin(centre[2] + turns[t])
        rx = (c * ends[:, 0] - s * ends[:, 1] + pivot[0] + centre[0]) / cell
        ry = (s * ends[:, 0] + c * ends[:, 1] + pivot[1] + centre[1]) / cell
        for a in range(len(offsets)):
            for b in range(len(offsets)):
                score = 0.0
                for k in range(len(ends)):
                    i = math.floor(rx[k] + offsets[a] / cell)
                    j = math.floor(ry[k] + offsets[b] / cell)
                    if 0 <= i < nx and 0 <= j < ny and field[i, j] < 2.0 * reach:
                        score += 1.0 - 0.5 * field[i, j] / reach
                out[t, a, b] = score / len(ends)
    return out


@njit(cache=True)
def evidence(
    origins: Points, ends: Points, surfaces: Segments, reach: float
) -> tuple[int, int, int]:
    """Beams that end on a surface, that go through one, and all, as counts.

    A beam judges only surfaces whose free side it comes from, away from their ends.
    """
    matched, through = 0, 0
    for k in range(len(ends)):
        dx, dy = ends[k, 0] - origins[k, 0], ends[k, 1] - origins[k, 1]
        size = math.hypot(dx, dy)
        if size < 1e-6:
            continue
        nearest = math.inf
        on = False
        for m in range(len(surfaces)):
            ax, ay = surfaces[m, 0, 0], surfaces[m, 0, 1]
            ux, uy = surfaces[m, 1, 0] - ax, surfaces[m, 1, 1] - ay
            length = max(math.hypot(ux, uy), 1e-9)
            denominator = dx * uy - dy * ux
            if denominator <= 0.0:  # seen from behind, or along it
                continue
            ex, ey = ends[k, 0] - ax, ends[k, 1] - ay
            along = (ex * ux + ey * uy) / length
            across = (ux * ey - uy * ex) / length
            if abs(across) < reach and -reach < along < length + reach:
                on = True
            t = ((ax - origins[k, 0]) * uy - (ay - origins[k, 1]) * ux) / denominator
            s = ((ax - origins[k, 0]) * dy - (ay - origins[k, 1]) * dx) / denominator
            if t > 0.0 and reach < s * length < length - reach:
                nearest = min(nearest, t)
        if nearest * size < size - 2.0 * reach:
            through += 1
        elif on:
            matched += 1
    return matched, through, len(ends)
