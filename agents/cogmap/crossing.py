"""What belongs to the space just left: the crossing of an exit, and Algorithm 7."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Boundary
from agents.cogmap.rays import NO_ROW, blocked, shorten
from cogmap_gym.geometry import NO_SEGMENTS, Points, Segments, cross, lengths, midpoints

SeenFree = Callable[[Points], NDArray[np.bool_]]
"""Tells of points (P, 2) whether they were seen to be free, (P,)."""
SURFACE_SAMPLES = np.array((0.1, 0.5, 0.9))
"""Where along a surface it is looked at, as shares of its length [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """The moment a robot left a local space through an exit, in MFIS."""

    exit: Points
    """(2, 2): the exit crossed, directed so that the space just left is on its left."""
    point: Points
    """(2,): where the path meets the exit."""
    outward: Points
    """(2,): unit direction of the path there."""
    position: Points
    """(2,): where the robot is now, after the crossing."""
    path: Segments
    """(M, 2, 2): the pieces of the path inside the space just left, in order."""


def find_crossing(path: Points, exit_crossed: Points, slack: float) -> Crossing:
    """Find where a path last left through an exit (Algorithm 7, steps 1 and 2).

    Args:
        path: (P, 2), P >= 2, in MFIS, ending beyond the exit.
        exit_crossed: (2, 2), the two jambs in any order.
        slack: how far beyond a jamb still counts as crossing [m].

    Returns:
        The crossing. A path that misses the exit counts as leaving at its end.
    """
    steps = np.stack((path[:-1], path[1:]), axis=1)
    steps = steps[np.hypot(*(steps[:, 1] - steps[:, 0]).T) > 0.0]
    if len(steps) == 0:
        steps = np.stack((path[:1], exit_crossed.mean(axis=0)[None]), axis=1)
    where, share, side = _meetings(steps, exit_crossed, slack)
    if len(where) == 0:
        outward = steps[-1, 1] - steps[-1, 0]
        point, inside = exit_crossed.mean(axis=0), steps
        turn = float(cross(exit_crossed[1] - exit_crossed[0], steps[:, 0].mean(axis=0) - point))
    else:
        k = where[-1]
        outward = steps[k, 1] - steps[k, 0]
        point = steps[k, 0] + share[-1] * outward
        turn = -float(side[-1])
        inside = _inside(steps, where, share, side)
    directed = exit_crossed if turn > 0.0 else exit_crossed[::-1]
    return Crossing(directed.copy(), point, outward / np.hypot(*outward), path[-1], inside)


def _meetings(
    steps: Segments, line: Points, slack: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Steps that cross a line: their rows, the share before it, and the sense of crossing."""
    along = line[1] - line[0]
    width = float(np.hypot(*along))
    before, after = cross(along, steps[:, 0] - line[0]), cross(along, steps[:, 1] - line[0])
    crossing = (before > 0.0) != (after > 0.0)
    share = before / np.where(crossing, before - after, 1.0)
    meet = steps[:, 0] + share[:, None] * (steps[:, 1] - steps[:, 0])
    at = (meet - line[0]) @ along / width
    rows = np.flatnonzero(crossing & (at > -slack) & (at < width + slack))
    return rows, share[rows], np.where(after > before, 1.0, -1.0)[rows]


def _inside(
    steps: Segments,
    where: NDArray[np.int64],
    share: NDArray[np.float64],
    side: NDArray[np.float64],
) -> Segments:
    """The pieces of the path on the inner side; excursions through the exit are left out."""
    kept: list[Points] = []
    is_in = bool(side[0] == side[-1])
    at = 0
    for row, step in enumerate(steps):
        start = step[0]
        while at < len(where) and where[at] == row:
            meet = step[0] + share[at] * (step[1] - step[0])
            if is_in:
                kept.append(np.array((start, meet)))
            start, is_in = meet, bool(side[at] != side[-1])
            at += 1
        if is_in and at < len(where):
            kept.append(np.array((start, step[1])))
    return np.array(kept) if kept else NO_SEGMENTS


def seen_after_crossing(
    surfaces: Segments, crossing: Crossing, params: Boundary
) -> NDArray[np.bool_]:
    """Algorithm 7: find new surfaces that came into view after crossing an exit.

    Args:
        surfaces: (N, 2, 2), in MFIS, untagged.
        crossing: where the path left (steps 1 and 2).
        params: the Boundary group.

    Returns:
        (N,): which surfaces are to be eliminated.
    """
    # Step 3: a line from the robot to the mid-point of every surface
    middles = midpoints(surfaces)
    rays = np.stack((np.broadcast_to(crossing.position, middles.shape), middles), axis=1)
    rays = shorten(rays, params.margin)
    rows = np.arange(len(surfaces))
    # Step 3a: it meets another surface
    hidden = blocked(rays, surfaces, rows)
    # Step 3b: it meets the virtual exit line, or the path
    behind = (middles - crossing.point) @ crossing.outward < 0.0
    nothing = np.full(len(surfaces), NO_ROW)
    on_path = blocked(rays, crossing.path, nothing)
    if params.confirm_before:
        # Departs from step 3b: spared is also what lies before the exit's own line or in
        # line with it, since a slanted path puts part of the room beyond the virtual line;
        # and what shows its back to the robot.
        along = crossing.exit[1] - crossing.exit[0]
        behind |= cross(along, middles - crossing.exit[0]) > -params.overlap_offset * np.hypot(
            *along
        )
        facing = cross(surfaces[:, 1] - surfaces[:, 0], crossing.position - surfaces[:, 0])
        behind |= facing < 0.0
    return np.asarray(~(hidden | behind | on_path))


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """Free lines of sight from the path to surfaces and exits, in MFIS."""

    rays: Segments
    """(R, 2, 2): from a path point to just short of what is seen."""
    rows: NDArray[np.int64]
    """(R,): the row of the surface seen; the rows of exits follow those of surfaces."""
    weights: NDArray[np.float64]
    """(R,): metres of surface or exit that hang on this line alone."""


def look_from(
    eyes: Points,
    surfaces: Segments,
    exit_crossed: Points,
    other_exits: Segments,
    params: Boundary,
    seen: SeenFree | None = None,
) -> Sight:
    """Find what could be seen of a space from within it, through no exit.

    Args:
        eyes: (E, 2), where it was looked from.
        surfaces: (N, 2, 2); only their left sides can be seen.
        exit_crossed: (2, 2), the exit by which the robot left.
        other_exits: (K, 2, 2), without the one crossed.
        params: the Boundary group.
        seen: tells of points (P, 2) whether they were seen to be free, (P,); None to trust the
            surfaces alone, where a wall that something hides is none.

    Returns:
        The free lines of sight; three samples a surface or exit.
    """
    n, k = len(surfaces), len(SURFACE_SAMPLES)
    lines = np.concatenate((surfaces, other_exits))
    along = lines[:, 1] - lines[:, 0]
    targets = (lines[:, :1] + SURFACE_SAMPLES[:, None] * along[:, None]).reshape(-1, 2)
    sample = np.tile(np.arange(len(targets)), len(eyes))
    rows = sample // k
    ends = (np.repeat(eyes, len(targets), axis=0), targets[sample])
    rays = shorten(np.stack(ends, axis=1).reshape(-1, 2, 2), params.margin)
    facing = (cross(along[rows], rays[:, 0] - lines[rows, 0]) > 0.0) | (rows >= n)
    shut = _shut_gaps(surfaces, params)
    walls = np.concatenate((lines, exit_crossed[None], shut, _flanks(other_exits, params)))
    free = facing & ~blocked(rays, walls, rows)
    if seen is not None and params.min_seen > 0.0:
        free[free] = _truly_seen(rays[free], seen, params)
    count = np.bincount(sample[free], minlength=len(targets))
    worth = lengths(lines) / k
    worth[n:] = params.exit_worth / k
    return Sight(rays[free], rows[free], worth[rows[free]] / count[sample[free]])


def _truly_seen(rays: Segments, seen: SeenFree, params: Boundary) -> NDArray[np.bool_]:
    """Which rays (R, 2, 2) lead over what was seen to be free, as far as that is kept, (R,)."""
    d = rays[:, 1] - rays[:, 0]
    size = np.hypot(d[:, 0], d[:, 1])
    steps = np.arange(params.seen_spacing, params.seen_reach, params.seen_spacing)
    rows, columns = np.nonzero(steps < (size - params.seen_spacing)[:, None])
    points = rays[rows, 0] + d[rows] * (steps[columns] / size[rows])[:, None]
    known = np.bincount(rows, weights=seen(points), minlength=len(rays))
    return known >= params.min_seen * np.bincount(rows, minlength=len(rays))


def _shut_gaps(surfaces: Segments, params: Boundary) -> Segments:
    """Gaps in line with two surfaces and no wider than an exit: an exit or an unseen wall."""
    gaps = surfaces[None, :, 0] - surfaces[:, None, 1]
    width = np.hypot(gaps[..., 0], gaps[..., 1])
    along = (surfaces[:, 1] - surfaces[:, 0]) / np.maximum(lengths(surfaces), params.min_side)[
        :, None
    ]
    sines = np.abs(cross(along[:, None], along))
    offset = np.maximum(np.abs(cross(along[:, None], gaps)), np.abs(cross(along, gaps)))
    onward = ((along[:, None] * gaps).sum(-1) > 0.0) & ((along[:, None] * along).sum(-1) > 0.0)
    in_line = (sines < params.min_corner_sine) & (offset < params.overlap_offset) & onward
    i, j = np.nonzero(in_line & (width < params.shut_gap))
    return np.stack((surfaces[i, 1], surfaces[j, 0]), axis=1)


def _flanks(exits: Segments, params: Boundary) -> Segments:
    """The wall that an exit must stand in, seen or not, at both of its sides."""
    along = exits[:, 1] - exits[:, 0]
    flank = params.exit_flank / np.maximum(lengths(exits), params.min_side)[:, None] * along
    before = np.stack((exits[:, 0] - flank, exits[:, 0]), axis=1)
    return np.concatenate((before, np.stack((exits[:, 1], exits[:, 1] + flank), axis=1)))


def looks(path: Segments, earlier: Points | None, params: Boundary) -> Points:
    """Spots at least ``look_spacing`` apart to look at a space from, (E, 2).

    Args:
        path: (M, 2, 2), pieces of the path inside the space; at most ``max_looks`` of its spots.
        earlier: (L, 2), spots of earlier stays, or None; as many of those not near the path.
        params: the Boundary group.
    """
    points = np.concatenate((path[:1, 0], path[:, 1]))
    spots = _thinned(points, np.zeros((0, 2)), params)
    if earlier is None or not params.look_earlier:
        return spots
    return np.concatenate((spots, _thinned(earlier, spots, params)))


def _thinned(points: Points, others: Points, params: Boundary) -> Points:
    """Points ``look_spacing`` apart from each other and from some others, (E, 2)."""
    kept: list[Points] = []
    for point in points:
        last = kept[-1:] if not len(others) else [*kept, *others]
        if all(np.hypot(*(point - q)) >= params.look_spacing for q in last):
            kept.append(point)
    pick = np.linspace(0, len(kept) - 1, min(len(kept), params.max_looks)).round()
    return np.array(kept).reshape(-1, 2)[pick.astype(np.int64)]
