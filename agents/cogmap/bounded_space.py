"""The gaps and exits of a view, and the minimal bounded space (thesis 3.3, Algorithm 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.doorways import doorways
from agents.cogmap.params import Gaps
from agents.cogmap.view import View
from cogmap_gym.geometry import (
    NO_SEGMENTS,
    Points,
    Segments,
    cross,
    lengths,
    midpoints,
    segments_cross,
)

Flags = NDArray[np.bool_]

HERE = np.zeros(2)
HERE.setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class Openings:
    """Where a view lets the robot out, in the robot's frame.

    Each row runs from the end seen at the right to the end seen at the left, so the space
    in which the robot stands lies on its left.
    """

    gaps: Segments
    """(G, 2, 2): the gaps on the boundary of the minimal bounded space, counter-clockwise."""
    occluding: Flags
    """(G, 2): the end hides what lies behind it; a gap of two such ends can be gone through."""
    exits: Segments
    """(E, 2, 2): doorways, counter-clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class _Gaps:
    """Gaps with their ends' flags; ``between`` holds the surfaces right and left of each."""

    lines: Segments
    occluding: Flags
    between: NDArray[np.int64]


def openings(view: View, params: Gaps, origin: Points = HERE) -> Openings:
    """Algorithm 2: compute the minimal bounded space, with the exits in view.

    Args:
        view: its surfaces ordered counter-clockwise, in the robot's frame.
        params: widths and tests; ``params.literal`` gives the algorithm as written.
        origin: (2,), where the laser sits in that frame.
    """
    gaps = _adjacent_gaps(view, params, origin)
    if params.literal:
        # Input: exits are the gaps of a door's width.
        width = lengths(gaps.lines)
        small = width <= params.max_exit_width
        exits = gaps.lines[small]
        gaps, merged = _merge(_rows(gaps, ~small), view, params, origin)
        exits = np.concatenate((exits, merged))
    else:
        # Departs from step 2.1.3.1: an exit is a doorway in a wall, not any gap of its width.
        exits = doorways(view, params, origin)
        gaps, _ = _merge(_not_behind(gaps, exits, params, origin), view, params, origin)
        gaps = _not_behind(gaps, exits, params, origin)
    return Openings(gaps.lines, gaps.occluding, exits[_order(exits, view, origin)])


def _adjacent_gaps(view: View, params: Gaps, origin: Points) -> _Gaps:
    """Empty spaces wide enough to cross between neighbouring surfaces."""
    if len(view.surfaces) < 2:
        return _Gaps(NO_SEGMENTS, np.zeros((0, 2), np.bool_), np.zeros((0, 2), np.int64))
    lines = np.stack((view.surfaces[:-1, 1], view.surfaces[1:, 0]), axis=1)
    right = np.arange(len(lines))
    wide = np.flatnonzero(lengths(lines) > params.min_width)
    occluding = np.array(
        [
            (
                _hides(view, view.beams[i, 1], 1, lines[i, 0], params, origin),
                _hides(view, view.beams[i + 1, 0], -1, lines[i, 1], params, origin),
            )
            for i in wide
        ],
        dtype=np.bool_,
    ).reshape(-1, 2)
    between = np.stack((right, right + 1), axis=1)[wide]
    return _Gaps(lines[wide], occluding, between)


def _hides(view: View, beam: int, step: int, end: Points, params: Gaps, origin: Points) -> bool:
    """Whether the beam next to a surface's end goes on far beyond it, or returns nothing."""
    following = view.points[beam + step]
    if np.isnan(following).any():
        return True
    deeper = np.hypot(*(following - origin)) - np.hypot(*(end - origin))
    return bool(deeper > params.occlusion_depth)


def _merge(gaps: _Gaps, view: View, params: Gaps, origin: Points) -> tuple[_Gaps, Segments]:
    """Steps 1 to 3: join gaps that a nearer gap covers, until none is left.

    Returns:
        The gaps that remain, and those of a door's width that the joining made (literal).
    """
    exits: list[Segments] = []
    # Departs from step 2.1: all pairs of gaps are tried, not neighbours alone, or a door
    # seen from 1.2 m is missed (FINDINGS 2). The nearest pairs come first.
    span = 1
    while span < (2 if params.literal else len(gaps.lines)):
        i = 0
        joined = False
        while i + span < len(gaps.lines):
            # Step 2.1
            line = _covering(gaps, i, i + span, view, params, origin)
            if line is None:
                i += 1
                continue
            # Step 2.1.3
            joined = True
            if params.literal and params.min_width <= lengths(line)[0] <= params.max_exit_width:
                exits.append(line[0])
                gaps = _replaced(gaps, i, i + span, None)
            else:
                gaps = _replaced(gaps, i, i + span, line)
                i += 1
        # Step 3
        span = 1 if joined else span + 1
    return gaps, np.stack(exits) if exits else NO_SEGMENTS


def _covering(
    gaps: _Gaps, i: int, j: int, view: View, params: Gaps, origin: Points
) -> Segments | None:
    """The gap (1, 2, 2) that covers gaps i to j, if there is one inside the bounded space."""
    if not (gaps.occluding[i, 0] and gaps.occluding[j, 1]):
        return None
    line = np.stack((gaps.lines[i, 0], gaps.lines[j, 1]))[None]
    sight = np.stack((origin, midpoints(line)[0]))[None]
    if segments_cross(sight, view.surfaces).any():
        return None
    if params.literal:
        return line
    # Departs from step 2.1.3: the new gap as a whole is free, it is wide enough to cross,
    # and what it covers lies behind it.
    behind = view.surfaces[gaps.between[i, 1] : gaps.between[j, 0] + 1]
    side = cross(line[0, 1] - line[0, 0], behind - line[0, 0])
    free = not segments_cross(line, view.surfaces).any()
    covers = bool((side <= 0.0).all())
    return line if free and covers and lengths(line)[0] > params.min_width else None


def _replaced(gaps: _Gaps, i: int, j: int, line: Segments | None) -> _Gaps:
    """Gaps i to j taken out, and the gap that covers them put in."""
    keep = np.r_[0:i, j + 1 : len(gaps.lines)]
    rest = _rows(gaps, keep)
    if line is None:
        return rest
    return _Gaps(
        np.insert(rest.lines, i, line[0], axis=0),
        np.insert(rest.occluding, i, True, axis=0),
        np.insert(rest.between, i, (gaps.between[i, 0], gaps.between[j, 1]), axis=0),
    )


def _not_behind(gaps: _Gaps, exits: Segments, params: Gaps, origin: Points) -> _Gaps:
    """The gaps that no exit covers: those whose middle is not seen through an exit."""
    if not len(exits) or not len(gaps.lines):
        return gaps
    middle = midpoints(exits)[:, None]
    wider = middle + (exits - middle) * (1.0 + params.cover_share)
    ends = midpoints(gaps.lines)
    sights = np.stack((np.broadcast_to(origin, ends.shape), ends), axis=1)
    through = segments_cross(sights, wider).any(axis=1)
    nearness = np.hypot(*(ends[:, None] - midpoints(exits)[None]).transpose(2, 0, 1))
    same = (nearness < params.min_width / 2).any(axis=1)
    return _rows(gaps, ~(through | same))


def _rows(gaps: _Gaps, rows: Flags | NDArray[np.int64]) -> _Gaps:
    return _Gaps(gaps.lines[rows], gaps.occluding[rows], gaps.between[rows])


def _order(exits: Segments, view: View, origin: Points) -> NDArray[np.int64]:
    """Counter-clockwise, from the first beam that shows anything."""
    seen = view.points[np.isfinite(view.points).all(axis=1)] - origin
    if not len(seen):
        return np.arange(len(exits))
    to = midpoints(exits) - origin
    turn = np.arctan2(cross(seen[0], to), to @ seen[0])
    return np.argsort(turn % (2 * np.pi), kind="stable")
