"""Step 3 of Algorithm 3: where a view lies in the MFIS, and by which landmarks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from agents.cogmap.frame import consensus, landmark_frame
from agents.cogmap.landmarks import compare, find_landmarks
from agents.cogmap.mfis import MFIS
from agents.cogmap.params import Frame, Landmarks, Params
from agents.cogmap.view import View
from cogmap_gym.geometry import Points, Pose, Segments, cross, midpoints

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

NO_PAIRS: Ints = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """Where a view lies in the MFIS, and by which landmarks."""

    mfis_from_robot: Pose
    pairs: Ints
    """(K, 2): rows of view and MFIS that are one surface, the best of each view row first."""
    matched: float
    """Share of the beams that end on a known surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """What one step looks for its landmarks with."""

    view: View
    mfis: MFIS
    recent: Bools
    """(M,): surfaces seen in the last views, and allowed."""
    allowed: Bools
    """(M,): surfaces that may be recognised."""
    predicted: Pose
    """``mfis_from_robot`` by the odometry."""
    prior_sd: tuple[float, float]
    """Standard deviations of ``predicted`` [m, rad]."""


def by_consensus(search: Search, params: Params) -> Located:
    """Find the landmarks and the one frame that fits them all, in tightening rounds.

    Departs from Algorithm 3, which looks for landmarks in V_{n-1} alone: a surface hidden for
    one view would be lost, and real recordings become a tangle (FINDINGS 8 a). Landmarks are
    looked for among surfaces seen in the last views, where the MFIS keeps them, then among all
    near ones.
    """
    p = params.frame
    pose, matched = _settle(search, search.predicted, params)
    if matched < p.search_below and search.recent.any():
        turned = _search_heading(search, p)
        other, share = _settle(search, turned, params)
        swing = abs(math.remainder(turned.theta - search.predicted.theta, math.tau))
        if share > matched + p.search_gain + p.search_caution * swing:
            pose, matched = other, share
    jump = pose.distance(search.predicted)
    turn = abs(math.remainder(pose.theta - search.predicted.theta, math.tau))
    doubtful = matched < p.keep_odometry_below and (
        jump > p.odometry_jump[0] or turn > p.odometry_jump[1]
    )
    if jump > p.max_jump or doubtful:
        pose = search.predicted
        matched = _share(search, search.allowed, pose, p)
    pairs = _pairs(search, search.allowed, pose, p.offset_gates[-1], p.turn_gates[-1], params)
    return Located(pose, pairs, matched)


def _settle(search: Search, start: Pose, params: Params) -> tuple[Pose, float]:
    """Match and fit in tightening rounds from ``start``; the pose and its share of beams."""
    p, pose = params.frame, start
    prior = Pose(search.predicted.x, search.predicted.y, start.theta)
    for k, (offset, turn) in enumerate(zip(p.offset_gates, p.turn_gates, strict=True)):
        pool = search.recent if k == 0 else search.allowed
        pairs = _pairs(search, pool, pose, offset, turn, params)
        if len(pairs):
            soft = p.softness * offset if k + 1 < len(p.offset_gates) else 0.0
            args = (search.view, search.mfis, pairs, prior, search.prior_sd)
            pose = consensus(*args, pose, p, soft)
    return pose, _share(search, search.allowed, pose, p)


def _pairs(
    search: Search, pool: Bools, pose: Pose, offset: float, turn: float, params: Params
) -> Ints:
    """View and MFIS rows that may be one surface under ``pose``, (K, 2), best of each row first.

    Departs from Algorithm 4: a view surface may continue several collinear MFIS surfaces, and all
    of them hold it.
    """
    p: Landmarks = params.landmarks
    view, mfis = search.view, search.mfis
    rows = np.flatnonzero(pool & near(mfis, view, pose, params.frame.near))
    if len(rows) == 0 or len(view.surfaces) == 0:
        return NO_PAIRS
    laid, known = pose.apply(view.surfaces), mfis.surfaces[rows]
    compared = compare(laid, known, p)
    # A wrong heading swings a far wall far off; its distance from the robot stays.
    swing = _from_robot(laid, pose)[:, None] - _from_robot(known, pose)[None]
    off = np.minimum(np.abs(compared.offset), np.abs(swing))
    angle = np.abs(compared.turn)
    good = (compared.hits > 0) & (compared.overlap > 0.0) & (off < offset) & (angle < turn)
    i, j = np.nonzero(good)
    order = np.lexsort(((off / offset + angle / turn)[i, j], i))
    return np.stack((i[order], rows[j[order]]), axis=-1)


def _from_robot(segments: Segments, pose: Pose) -> Floats:
    """How far the robot stands to the left of each segment's line [m], (N,)."""
    d = segments[:, 1] - segments[:, 0]
    size = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)
    return np.asarray(cross(d, pose.position - segments[:, 0]) / size)


def near(mfis: MFIS, view: View, pose: Pose, margin: float) -> Bools:
    """Which MFIS surfaces touch the bounds of the view laid at ``pose``, (M,)."""
    if len(mfis) == 0 or len(view.surfaces) == 0:
        return np.zeros(len(mfis), dtype=np.bool_)
    laid = pose.apply(view.surfaces).reshape(-1, 2)
    low, high = laid.min(axis=0) - margin, laid.max(axis=0) + margin
    p, q = mfis.surfaces[:, 0], mfis.surfaces[:, 1]
    # The greater end and the lesser, coordinate by coordinate: reductions over two rows are slow.
    reaches = (np.maximum(p, q) >= low) & (np.minimum(p, q) <= high)
    return np.asarray(reaches[:, 0] & reaches[:, 1])


def _share(search: Search, pool: Bools, pose: Pose, p: Frame) -> float:
    rows = pool & near(search.mfis, search.view, pose, p.near)
    return matched_share(pose.apply(search.view.points), search.mfis.surfaces[rows], p.beam_match)


def _search_heading(search: Search, p: Frame) -> Pose:
    """The heading, turned where the odometry says the robot is, that matches most beams."""
    count = math.ceil(p.search_range / p.search_step)
    at = search.predicted
    best, most = at, -1.0
    for k in range(-count, count + 1):
        pose = Pose(at.x, at.y, at.theta + k * p.search_step)
        share = _share(search, search.recent, pose, p)
        if share > most:
            best, most = pose, share
    return best


@njit(cache=True)
def matched_share(points: Points, surfaces: Segments, reach: float) -> float:
    """Share of points (P, 2), NaN rows apart, within ``reach`` of a surface (N, 2, 2)."""
    count, matched = 0, 0
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        if not (math.isfinite(px) and math.isfinite(py)):
            continue
        count += 1
        for j in range(len(surfaces)):
            ax, ay = surfaces[j, 0, 0], surfaces[j, 0, 1]
            ux, uy = surfaces[j, 1, 0] - ax, surfaces[j, 1, 1] - ay
            s = (px - ax) * ux + (py - ay) * uy
            s = min(max(s / max(ux * ux + uy * uy, 1e-12), 0.0), 1.0)
            dx, dy = px - ax - s * ux, py - ay - s * uy
            if dx * dx + dy * dy <= reach * reach:
                matched += 1
                break
    return matched / count if count else 0.0


def by_nearest(
    previous: Segments, ids: Ints, search: Search, odometry: Pose, params: Params
) -> tuple[Located, list[Pose]]:
    """Find the landmarks in V_{n-1}, and the frame of each, as thesis 3.4 is written.

    Args:
        previous: surfaces of V_{n-1} that have an id, in the robot's previous frame, (K, 2, 2).
        ids: their ids, (K,).
        search: the present view and the map.
        odometry: motion since V_{n-1}.
        params: thresholds.

    Returns:
        The landmarks, with the robot's pose by the landmark nearest to it, and for each surface of
        the view the frame of its nearest landmark (Algorithm 5, step 1).
    """
    view, mfis = search.view, search.mfis
    in_view = odometry.inverse().apply(previous)
    match = find_landmarks(view.surfaces, in_view, params.landmarks)
    rows = np.flatnonzero(match >= 0)
    pairs = np.stack((rows, mfis.rows_of(ids[match[rows]])), axis=-1)
    if len(rows) == 0:
        return Located(search.predicted, NO_PAIRS, 0.0), [search.predicted] * len(view.surfaces)
    frames = [_frame_of(view.surfaces[i], in_view[match[i]], mfis.surfaces[j]) for i, j in pairs]
    middles = midpoints(view.surfaces)
    gaps = np.linalg.norm(middles[:, None] - middles[rows][None], axis=-1)
    own = [frames[k] for k in gaps.argmin(axis=1)]
    centre = frames[int(np.linalg.norm(middles[rows], axis=1).argmin())]
    return Located(centre, pairs, _share(search, search.allowed, centre, params.frame)), own


def _frame_of(seen: Segments, expected: Segments, known: Segments) -> Pose:
    """The frame of one landmark, normalised, centred on the ends that lie closest together.

    Feet of the ends of both copies make them of equal length (thesis 3.4, Fig. 3.16); what
    lengthens L of V_{n-1} lengthens its MFIS surface as much.

    Args:
        seen: L in V_n, (2, 2).
        expected: L of V_{n-1} transformed into V_n, as long as ``known``, (2, 2).
        known: the same surface in the MFIS, (2, 2).
    """
    if np.dot(seen[1] - seen[0], expected[1] - expected[0]) < 0.0:
        seen = seen[::-1]
    u, e, k = (_unit(line) for line in (seen, expected, known))
    feet = (expected - seen[0]) @ u
    ends = np.array((min(0.0, feet[0]), max(float((seen[1] - seen[0]) @ u), feet[1])))
    grown = (ends - feet)[:, None]
    seen, expected, known = seen[0] + ends[:, None] * u, expected + grown * e, known + grown * k
    gaps = np.linalg.norm(seen - expected, axis=1)
    if gaps[1] < gaps[0]:
        seen, known = seen[::-1], known[::-1]
    return landmark_frame(seen, known)


def _unit(line: Segments) -> Points:
    d = line[1] - line[0]
    return np.asarray(d / max(float(np.hypot(d[0], d[1])), 1e-9))
