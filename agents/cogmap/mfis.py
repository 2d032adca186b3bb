"""The MFIS: one inexact map of surfaces, and Algorithm 5, which enters new ones (thesis 3.4).

An old surface is never moved and never turned: after insertion it only lengthens along its
own line. ``Edit`` records keep the proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.landmarks import find_landmarks
from agents.cogmap.params import Landmarks, Transfer
from agents.cogmap.view import View
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments, lengths, segments_cross

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

UNTAGGED = 0
"""The tag of a surface of no ASR yet."""
FORGOTTEN = -1
"""The tag of a surface that is no longer part of the map."""


@dataclass(frozen=True, slots=True, eq=False)
class MFIS:
    """Surfaces in one coordinate system, that of the first view."""

    surfaces: Segments
    """(N, 2, 2), free space on the left."""
    physical: Bools
    """(N, 2): the end is an end of the wall itself."""
    anchor: Points
    """(N, 2): middle of the surface when it was entered."""
    anchor_sd: Floats
    """(N,): how well its line was known there across [m]."""
    heading_sd: Floats
    """(N,): how well its heading was known [rad]."""
    born: Ints
    """(N,): step of entry."""
    seen: Ints
    """(N,): step at which it was last recognised."""
    asr: Ints
    """(N,): the ASR it belongs to, 0 before any, -1 once forgotten."""
    entered: Bools
    """(N,): entered for good; the others wait in the buffer for a better sighting."""
    sighting: Segments
    """(N, 2, 2): the surface in the robot's frame where it was seen best before it was entered."""
    sighted: Ints
    """(N,): step of that sighting."""
    ids: Ints
    """(N,): names of the surfaces, from 1, ascending; none is given twice."""

    def __len__(self) -> int:
        """Number of surfaces."""
        return len(self.surfaces)

    @property
    def last_id(self) -> int:
        """The last name given; 0 before the first."""
        return int(self.ids[-1]) if len(self.ids) else 0

    def rows_of(self, ids: Ints) -> Ints:
        """The rows (K,) of surfaces with these names (K,), which are part of the table."""
        return np.searchsorted(self.ids, ids)


EMPTY_MFIS = MFIS(
    NO_SEGMENTS,
    np.zeros((0, 2), dtype=np.bool_),
    np.zeros((0, 2)),
    np.zeros(0),
    np.zeros(0),
    np.zeros(0, dtype=np.int64),
    np.zeros(0, dtype=np.int64),
    np.zeros(0, dtype=np.int64),
    np.zeros(0, dtype=np.bool_),
    NO_SEGMENTS,
    np.zeros(0, dtype=np.int64),
    np.zeros(0, dtype=np.int64),
)


@dataclass(frozen=True, slots=True, eq=False)
class Edit:
    """One change of the MFIS."""

    step: int
    id: int
    before: Segments | None
    """(2, 2) in the MFIS, None when the surface was entered."""
    after: Segments
    """(2, 2) in the MFIS."""
    in_view: Segments
    """(2, 2) in the robot's frame: the sighting that made it."""
    sighted: int
    """Step of that sighting."""


def recognise(mfis: MFIS, rows: Ints, step: int) -> MFIS:
    """Note that these rows were seen at this step."""
    seen = mfis.seen.copy()
    seen[rows] = step
    return replace(mfis, seen=seen)


def tag(mfis: MFIS, rows: Ints, asr: int) -> MFIS:
    """Note that these rows belong to an ASR, or are forgotten."""
    tags = mfis.asr.copy()
    tags[rows] = asr
    return replace(mfis, asr=tags)


def without_dead(mfis: MFIS, named: Ints, most: int) -> MFIS:
    """The table without the forgotten surfaces, once they are many.

    Args:
        mfis: the map.
        named: names that are still in use.
        most: so many forgotten surfaces may stay.
    """
    dead = (mfis.asr == FORGOTTEN) & ~np.isin(mfis.ids, named)
    if np.count_nonzero(dead) <= most:
        return mfis
    keep = ~dead
    keep[-1] = True  # so that no name is given twice
    return MFIS(*(getattr(mfis, f.name)[keep] for f in fields(MFIS)))


def normalise(
    view: View, mfis: MFIS, pairs: Ints, mfis_from_robot: Pose, step: int, params: Transfer
) -> tuple[MFIS, list[Edit]]:
    """Lengthen MFIS surfaces to what the view shows of them, along their own lines.

    Departs from the normalisation of thesis 3.4 (Fig. 3.16), which lengthens whenever a
    perpendicular meets: walls then grow at each view by the noise of their ends (FINDINGS 3). An
    end of the wall itself is kept unless the view goes well beyond it, and a surface stops where
    the next one on its line begins.

    Args:
        view: surfaces in the robot's frame.
        mfis: the map.
        pairs: (K, 2) rows of view and MFIS that are one surface.
        mfis_from_robot: where the view lies.
        step: for the record.
        params: thresholds.
    """
    surfaces, physical = mfis.surfaces.copy(), mfis.physical.copy()
    edits: list[Edit] = []
    laid = mfis_from_robot.apply(view.surfaces)
    for i in np.unique(pairs[:, 0]):
        rows = pairs[pairs[:, 0] == i, 1]
        for j in rows:
            known = surfaces[j]
            span = float(np.hypot(*(known[1] - known[0])))
            u = (known[1] - known[0]) / span
            ends = (laid[i] - known[0]) @ u
            others = ((surfaces[rows[rows != j]] - known[0]) @ u).reshape(-1, 2)
            low, high = (-np.inf, np.inf) if params.literal else _room_to_grow(others, span)
            new = [max(min(ends[0], 0.0), low), min(max(ends[1], span), high)]
            for end, grown in ((0, -new[0]), (1, new[1] - span)):
                least = params.end_growth if physical[j, end] else params.min_growth
                if grown <= params.rounding or (grown < least and not params.literal):
                    new[end] = 0.0 if end == 0 else span
                else:
                    reached = bool(new[end] == ends[end])
                    physical[j, end] = bool(view.physical[i, end]) and reached
                if abs(ends[end] - new[end]) < params.end_growth and view.physical[i, end]:
                    physical[j, end] = True
            if new != [0.0, span]:
                after = known[0] + np.outer(new, u)
                if mfis.entered[j]:
                    seen = view.surfaces[i]
                    edits.append(Edit(step, int(mfis.ids[j]), known.copy(), after, seen, step))
                surfaces[j] = after
    return replace(mfis, surfaces=surfaces, physical=physical), edits


def enter(
    view: View, mfis: MFIS, pairs: Ints, mfis_from_robot: Pose, step: int, params: Transfer
) -> tuple[MFIS, list[Edit]]:
    """Better the sightings of surfaces that wait in the buffer, and enter those that are ready.

    Departs from Algorithm 5, which enters a surface at first sight: a wall glimpsed through a door
    has a heading no better than half a degree, and an entered surface never turns; over 90 m the
    pose error on re-entry was 0.5 m. A surface waits, recognised as any other, until its heading is
    known well or it goes out of sight, and is entered as it was seen best.

    Args:
        view: surfaces in the robot's frame.
        mfis: the map, surfaces of this step recognised.
        pairs: (K, 2) rows of view and MFIS that are one surface.
        mfis_from_robot: where the view lies.
        step: for the record.
        params: thresholds.
    """
    surfaces, physical = mfis.surfaces.copy(), mfis.physical.copy()
    anchor, anchor_sd = mfis.anchor.copy(), mfis.anchor_sd.copy()
    sighting, sighted = mfis.sighting.copy(), mfis.sighted.copy()
    known_sd, sd = mfis.heading_sd.copy(), _heading_sd(view, params)
    for i, j in pairs:
        if mfis.entered[j] or sd[i] >= known_sd[j]:
            continue
        laid = mfis_from_robot.apply(view.surfaces[i])
        u = (laid[1] - laid[0]) / np.hypot(*(laid[1] - laid[0]))
        rows = pairs[pairs[:, 0] == i, 1]
        seen, own = (laid - laid[0]) @ u, np.sort((surfaces[j] - laid[0]) @ u)
        others = ((surfaces[rows[rows != j]] - laid[0]) @ u).reshape(-1, 2) - own[0]
        room = own[0] + np.array(_room_to_grow(others, float(own[1] - own[0])))
        low, high = max(min(seen[0], own[0]), room[0]), min(max(seen[1], own[1]), room[1])
        surfaces[j] = laid[0] + np.outer((low, high), u)
        anchor[j], known_sd[j] = laid.mean(axis=0), sd[i]
        anchor_sd[j] = params.range_sd / np.sqrt(view.hits[i])
        physical[j] |= view.physical[i]
        sighting[j], sighted[j] = view.surfaces[i], step
    known = (known_sd <= params.known_heading_sd) | (mfis.seen < step)
    ready = ~mfis.entered & (known | params.literal)
    edits = [
        Edit(
            step,
            int(mfis.ids[j]),
            None,
            surfaces[j].copy(),
            sighting[j].copy(),
            int(sighted[j]),
        )
        for j in np.flatnonzero(ready)
    ]
    bettered = replace(
        mfis,
        surfaces=surfaces,
        physical=physical,
        anchor=anchor,
        anchor_sd=anchor_sd,
        heading_sd=known_sd,
        entered=mfis.entered | ready,
        sighting=sighting,
        sighted=sighted,
    )
    return bettered, edits


def _room_to_grow(others: Floats, span: float) -> tuple[float, float]:
    """How far a surface of length ``span`` may reach before others (K, 2) on its line begin."""
    low, high = -np.inf, np.inf
    for a, b in others:
        if b <= 0.5 * span and a < 0.0:
            low = max(low, min(b, 0.0))
        elif a >= 0.5 * span and b > span:
            high = min(high, max(a, span))
        elif a < 0.0 or b > span:
            low, high = max(low, 0.0), min(high, span)
    return low, high


def transfer(
    view: View,
    mfis: MFIS,
    ids: Ints,
    frames: Sequence[Pose],
    rows: Ints,
    step: int,
    params: Transfer,
    landmarks: Landmarks,
) -> tuple[MFIS, Ints]:
    """Algorithm 5: transfer the surfaces of a view to the MFIS.

    Args:
        view: surfaces in the robot's frame.
        mfis: the map, landmarks normalised.
        ids: (N,) id of each surface of the view recognised as a landmark, or 0.
        frames: for each surface of the view, the frame that enters it (steps 1 to 3: its nearest
            landmark's, or the consensus of all).
        rows: rows of the MFIS that may be recognised in step 5.
        step: for the record.
        params: thresholds.
        landmarks: thresholds of Algorithm 4.

    Returns:
        The map with the new surfaces, and the id of each surface of the view, (N,), or 0.
    """
    ids = ids.copy()
    new_rows: list[int] = []
    laid = np.array([f.apply(s) for f, s in zip(frames, view.surfaces, strict=True)])
    size, heading_sd = lengths(view.surfaces), _heading_sd(view, params)
    for i in np.flatnonzero(ids == 0):
        known = mfis.surfaces[rows]
        if size[i] < params.min_length or view.hits[i] < params.min_hits:
            continue
        if not params.literal and heading_sd[i] > params.max_heading_sd:
            continue
        # Departs from the order of steps 4 and 5: the match comes first, since what has been
        # seen before lies across what has been seen before (FINDINGS 3).
        match = find_landmarks(laid[i : i + 1], known, landmarks)[0]
        if params.literal and _intersects(laid[i], mfis.surfaces, 0.0):
            continue  # Step 4, as written
        if match >= 0:
            ids[i] = mfis.ids[rows[match]]  # Step 5: the surface is not new
            continue
        if not params.literal and _intersects(laid[i], mfis.surfaces, params.corner_slack):
            continue  # Step 4
        new_rows.append(int(i))
        ids[i] = mfis.last_id + len(new_rows)
    return _append(mfis, view, laid, new_rows, heading_sd, step, params), ids


def _heading_sd(view: View, params: Transfer) -> Floats:
    """How well the heading of each surface of the view is known [rad], (N,)."""
    size = np.maximum(lengths(view.surfaces), 1e-6)
    return np.asarray(params.range_sd * np.sqrt(12.0 / np.maximum(view.hits, 1)) / size)


def _intersects(surface: Segments, known: Segments, slack: float) -> bool:
    """Whether a surface (2, 2), shortened by ``slack`` at both ends, crosses a known one."""
    d = surface[1] - surface[0]
    size = float(np.hypot(d[0], d[1]))
    cut = d / max(size, 1e-9) * min(slack, 0.45 * size)
    return bool(segments_cross(np.array([[surface[0] + cut, surface[1] - cut]]), known).any())


def _append(
    mfis: MFIS,
    view: View,
    laid: Segments,
    rows: list[int],
    heading_sd: Floats,
    step: int,
    params: Transfer,
) -> MFIS:
    """The MFIS with these rows of the view entered."""
    if not rows:
        return mfis
    added = laid[rows]
    now = np.full(len(rows), step, dtype=np.int64)
    return MFIS(
        np.concatenate((mfis.surfaces, added)),
        np.concatenate((mfis.physical, view.physical[rows])),
        np.concatenate((mfis.anchor, added.mean(axis=1))),
        np.concatenate((mfis.anchor_sd, params.range_sd / np.sqrt(view.hits[rows]))),
        np.concatenate((mfis.heading_sd, heading_sd[rows])),
        np.concatenate((mfis.born, now)),
        np.concatenate((mfis.seen, now)),
        np.concatenate((mfis.asr, np.full(len(rows), UNTAGGED, dtype=np.int64))),
        np.concatenate((mfis.entered, np.zeros(len(rows), dtype=np.bool_))),
        np.concatenate((mfis.sighting, view.surfaces[rows])),
        np.concatenate((mfis.sighted, now)),
        np.concatenate((mfis.ids, mfis.last_id + np.arange(1, len(rows) + 1))),
    )
