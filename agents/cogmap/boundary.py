"""Which surfaces and points may bound an ASR (Algorithm 8), and the boundary itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.crossing import Crossing, Sight
from agents.cogmap.nearest import walk_nearest
from agents.cogmap.params import Boundary
from agents.cogmap.walk import connect, gather, walk_round
from cogmap_gym.geometry import (
    Points,
    Segments,
    intersection_points,
    lengths,
    midpoints,
    point_segment_distances,
    segments_cross,
)


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """What a boundary may be formed of, in MFIS."""

    corners: Points
    """(C, 2): corner points."""
    large: Segments
    """(L, 2, 2): large surfaces, shortened."""
    rows: NDArray[np.int64]
    """(L,): their rows among the surfaces given."""


def candidates(surfaces: Segments, params: Boundary) -> Candidates:
    """Algorithm 8: identify surfaces and corner points for boundary computation.

    Args:
        surfaces: (N, 2, 2), the ASR's own.
        params: the Boundary group.

    Returns:
        Corner points of small surfaces, and large surfaces shortened where they meet.
    """
    large = lengths(surfaces) >= params.large
    # Step 1
    corners = _corner_points(surfaces[~large], params.corner_distance)
    # Step 2 and 3
    return Candidates(corners, _shortened(surfaces[large]), np.flatnonzero(large))


def _corner_points(small: Segments, near: float) -> Points:
    """Where small surfaces meet, or would have met (steps 1a and 1b)."""
    first, second = np.triu_indices(len(small), 1)
    a, b = small[first], small[second]
    crossing = segments_cross(small, small)[first, second]
    ends = point_segment_distances(small.reshape(-1, 2), small).reshape(len(small), 2, len(small))
    gap = ends.min(axis=1)
    close = crossing | (np.minimum(gap, gap.T)[first, second] < near)
    a, b = a[close], b[close]
    meet = intersection_points(a, b)
    # Parallel surfaces, and lines that meet far away, have their corner between the ends.
    pairs = np.hypot(*np.moveaxis(a[:, :, None] - b[:, None, :], -1, 0)).reshape(-1, 4)
    pick = pairs.argmin(axis=1) if len(pairs) else np.zeros(0, dtype=np.int64)
    rows = np.arange(len(a))
    between = 0.5 * (a[rows, pick // 2] + b[rows, pick % 2])
    far = ~(np.hypot(*(meet - between).T) <= 2.0 * near)
    return np.where(far[:, None], between, meet)


def _shortened(large: Segments) -> Segments:
    """Cut large surfaces that cross at their crossing, the shorter part off (step 3)."""
    out = large.copy()
    for i, j in np.argwhere(np.triu(segments_cross(large, large), 1)):
        meet = intersection_points(large[i : i + 1], large[j : j + 1])[0]
        for k in (i, j):
            # Step 3a, 3b and 3c
            to_start, to_end = np.hypot(*(large[k] - meet).T)
            out[k, 0 if to_start < to_end else 1] = meet
    return out


def bound(
    surfaces: Segments,
    options: Candidates,
    crossing: Crossing,
    exits: Segments,
    sight: Sight,
    params: Boundary,
) -> tuple[Points, NDArray[np.int64]]:
    """Form the boundary, from one end of the exit crossed to the other.

    Returns:
        The polygon (K, 2), counter-clockwise, (0, 2) if it did not close; and the rows of
        the surfaces on it.
    """
    nothing = np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
    if len(crossing.path) == 0 or len(surfaces) == 0:
        return nothing
    if params.walk == "nearest":
        return walk_nearest(crossing, options.large, options.rows, options.corners)
    # Departs from step 2 of Algorithm 8: small surfaces stay, beside their corner points.
    rows = np.arange(len(surfaces)) if params.keep_small else options.rows
    items = gather(crossing.exit, exits, surfaces[rows])
    links = connect(items, crossing, sight, params)
    polygon, chain = walk_round(items, links, crossing.path, params)
    used = items.surface[np.array(chain, dtype=np.int64)]
    return polygon, rows[used[used >= 0]]


def touches(surfaces: Segments, polygon: Points, near: float) -> NDArray[np.bool_]:
    """Which surfaces have their middle in a polygon or within ``near`` metres of it, (N,)."""
    area = shapely.Polygon(polygon)
    distance = shapely.distance(area, shapely.points(midpoints(surfaces)))
    return np.asarray(distance <= near)
