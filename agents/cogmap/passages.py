"""Narrow passages that the robot has just driven through: doors that no view showed as exits.

A doorway in line with a corridor's wall, or one that is met at a slant, may never be seen
as an exit from before it. The robot looks back at its own path (FINDINGS 2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Passages
from cogmap_gym.geometry import NO_SEGMENTS, Points, Segments, point_segment_distances

Floats = NDArray[np.float64]


def passages(path: Points, obstacles: Points, params: Passages) -> Segments:
    """Doorways across the last stretch of a path.

    Args:
        path: (P, 2) in the MFIS, the present position last.
        obstacles: (Q, 2) in the MFIS.
        params: widths and distances.

    Returns:
        (K, 2, 2) lines from the jamb at the path's right to that at its left, so that the space
        the robot came from lies on their left.
    """
    spots, headings = _stations(path, params)
    if not len(spots):
        return NO_SEGMENTS
    stretch = np.stack((spots[:-1], spots[1:]), axis=1)
    near = _within(obstacles, stretch, params.far)
    width = np.array([_width(p, h, near, params) for p, h in zip(spots, headings, strict=True)])
    found: list[Segments] = []
    for k in np.flatnonzero((width >= params.min_width) & (width <= params.max_width)):
        apart = np.linalg.norm(spots - spots[k], axis=1)
        around = apart < params.wide_within
        if width[k] > width[around].min() or not _opens(width, apart, int(k), params):
            continue
        line = _across(spots[k], headings[k], near, params)
        if line is not None:
            found.append(line)
    return np.stack(found[:1]) if found else NO_SEGMENTS


def _across(spot: Points, heading: float, points: Points, params: Passages) -> Segments | None:
    """The doorway (2, 2) at a spot, in line with its wall however slanted the path is.

    On a slant a wall must go on from both jambs: with walls that end in others as well,
    ASR6 of the thesis's office was cut in two in half of the runs.
    """
    slants = np.arange(0.0, params.max_slant + 1e-9, params.slant_step)
    for slant in np.concatenate(
        (slants[:1], *zip(slants[1:], -slants[1:], strict=True)), axis=None
    ):
        line = _jambs(spot, heading + float(slant), points, params)
        if line is not None and _walled(line, points, params, ends=slant == 0.0):
            return line
    return None


def _within(points: Points, stretch: Segments, far: float) -> Points:
    """The points (Q, 2) less than ``far`` from a stretch of path."""
    if not len(stretch):
        return points[:0]
    low, high = stretch.min(axis=(0, 1)) - far, stretch.max(axis=(0, 1)) + far
    boxed = (points >= low) & (points <= high)
    points = points[boxed[:, 0] & boxed[:, 1]]
    return np.asarray(points[point_segment_distances(points, stretch).min(axis=1) < far])


def _stations(path: Points, params: Passages) -> tuple[Points, Floats]:
    """Spots along the last stretch, evenly spaced, (S, 2), and the path's heading there, (S,)."""
    steps = np.diff(path, axis=0)
    size = np.hypot(steps[:, 0], steps[:, 1])
    moved = size > params.spacing / 2.0
    start, steps, size = path[:-1][moved], steps[moved], size[moved]
    if not len(size):
        return np.zeros((0, 2)), np.zeros(0)
    ends = np.cumsum(size)
    at = np.arange(max(0.0, ends[-1] - params.stretch), ends[-1], params.spacing)
    row = np.searchsorted(ends, at, side="right").clip(max=len(size) - 1)
    t = (at - (ends[row] - size[row])) / size[row]
    spots = start[row] + t[:, None] * steps[row]
    return spots, np.arctan2(steps[row, 1], steps[row, 0])


def _sides(spot: Points, heading: float, points: Points, band: float) -> tuple[Points, Points]:
    """Points (Q, 2) beside a spot: their distances (left, right) within ``band`` along the path."""
    c, s = np.cos(heading), np.sin(heading)
    d = points - spot
    along, aside = c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]
    beside = np.abs(along) < band
    return aside[beside & (aside > 0.0)], -aside[beside & (aside < 0.0)]


def _width(spot: Points, heading: float, points: Points, params: Passages) -> float:
    """Free width across the path at a spot [m]; infinite where a side is open."""
    left, right = _sides(spot, heading, points, params.band)
    return float(left.min(initial=np.inf) + right.min(initial=np.inf))


def _opens(width: Floats, apart: Floats, k: int, params: Passages) -> bool:
    """Whether the space is wide within a wall's thickness before and behind station k."""
    near = apart < params.wide_within
    before, behind = near.copy(), near.copy()
    before[k:], behind[: k + 1] = False, False
    wide = width > min(params.wide, width[k] + params.wider)
    return bool((before & wide).any() and (behind & wide).any())


def _jambs(spot: Points, heading: float, points: Points, params: Passages) -> Segments | None:
    """The line (2, 2) across the passage at a spot."""
    left, right = _sides(spot, heading, points, params.band)
    if not len(left) or not len(right):
        return None
    across = np.array((-np.sin(heading), np.cos(heading)))
    return np.stack((spot - right.min() * across, spot + left.min() * across))


def _walled(line: Segments, points: Points, params: Passages, *, ends: bool) -> bool:
    """Whether a doorway's width lies between two jambs from which a wall goes on, in line.

    Where ``ends``, a wall across its end may stand for the rest of one: a door beside it.
    """
    width = float(np.hypot(*(line[1] - line[0])))
    if not params.min_width <= width <= params.max_width:
        return False
    u = (line[1] - line[0]) / width
    return all(
        _goes_on(jamb, outward, points, params, ends=ends)
        for jamb, outward in ((line[0], -u), (line[1], u))
    )


def _goes_on(
    jamb: Points, outward: Points, points: Points, params: Passages, *, ends: bool
) -> bool:
    """Whether a wall goes on from a jamb (2,) in this direction (2,), or ends in one across it."""
    d = points - jamb
    along, aside = d @ outward, d @ np.array((-outward[1], outward[0]))
    beyond = (along > 0.0) & (along < params.wall)
    on = beyond & (np.abs(aside) < params.wall_band + params.wall_slant * np.abs(along))
    needed = params.wall_share / params.spacing
    if _filled(along[on], params) >= needed * params.wall:
        return True
    return ends and any(
        _filled(along[on & (along < end)], params) >= needed * end - 1.0
        and _crosswise(along - end, aside, params)
        for end in np.arange(params.nib, params.wall, params.spacing)
    )


def _crosswise(off: Floats, aside: Floats, params: Passages) -> bool:
    """Whether a wall stands across a jamb's line, on one side of it at least.

    Args:
        off: (P,), how far points lie beyond the place of that wall [m].
        aside: (P,), and to the left of the jamb's line [m].
        params: widths and shares.
    """
    on = (np.abs(off) < params.band) & (np.abs(aside) > params.wall_band)
    least = params.wall_share * (params.wall - params.wall_band) / params.spacing
    return any(
        _filled(side * aside[on & (side * aside > 0.0) & (side * aside < params.wall)], params)
        >= least
        for side in (1.0, -1.0)
    )


def _filled(along: Floats, params: Passages) -> int:
    """How many steps along a line hold a point."""
    return len(np.unique((along / params.spacing).astype(np.int64)))
