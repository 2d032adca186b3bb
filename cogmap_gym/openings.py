"""Openings of a drawing to the outside, and the lines that shut them."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from shapely.geometry import Point, Polygon, box

from cogmap_gym.geometry import Points, Segments

WIDEST_M = 3.0
"""Openings to the outside narrower than this are shut [m]. Ours: a double door."""
CRACK_M = 0.12
"""An end of a line within this distance of another line is led on to it [m]. Ours: no body and
hardly a beam gets through."""
JOINED_M = 1e-6
"""Within this distance it touches the other line already [m]. Ours: rounding."""
TOUCHING_M = 0.005
"""The outside touches what is within this distance [m]. Ours: over the error of its arcs."""
ARC_SIDES = 16
"""Sides of the polygon about a quarter of a circle [-]. Ours: within 4 mm of the circle."""


def shut_openings(segments: Segments, home: Points | None) -> Segments:
    """The lines of a drawing, and more across its openings to the outside.

    The outside is where a large disc gets to from beyond the drawing; where it stops short in a
    gap, a line between the two ends of the gap shuts it.

    Args:
        segments: (N, 2, 2) [m].
        home: (2,) [m]; one that lies outside leaves all openings as they are. None: not known.

    Returns:
        (M, 2, 2), the lines themselves first.
    """
    lines = shapely.linestrings(segments)
    beyond = box(*shapely.total_bounds(lines)).buffer(2.0 * WIDEST_M).exterior
    space = shapely.difference(Polygon(beyond), thick(lines, WIDEST_M / 2.0))
    around = next(part for part in shapely.get_parts(space) if part.intersects(beyond))
    outside = around.buffer(WIDEST_M / 2.0, quad_segs=ARC_SIDES)
    if home is not None and outside.covers(Point(home)):
        return segments
    inner = outside.boundary.difference(beyond.buffer(WIDEST_M))
    seams = inner.difference(thick(lines, TOUCHING_M))
    parts = [seam for seam in shapely.get_parts(seams) if not seam.is_empty]
    ends = [np.array(seam.coords)[[0, -1]] for seam in parts]
    met = _nearest(np.reshape(ends, (-1, 2)), lines).reshape(-1, 2, 2)
    return np.concatenate((segments, met[(met[:, 0] != met[:, 1]).any(axis=1)]))


def _nearest(points: Points, lines: Any) -> Points:
    """Where each of some points (K, 2) meets the nearest line."""
    places = shapely.points(points)
    ways = shapely.shortest_line(lines[shapely.STRtree(lines).nearest(places)], places)
    return np.asarray(shapely.get_coordinates(ways)[::2])


def shut_cracks(segments: Segments) -> Segments:
    """The lines (N, 2, 2) [m] and more that lead ends on to lines near by, (M, 2, 2)."""
    lines = shapely.linestrings(segments)
    ends = shapely.points(segments.reshape(-1, 2))
    near, other = shapely.STRtree(lines).query(ends, "dwithin", CRACK_M)
    gaps = shapely.distance(ends[near], lines[other])
    near, other, gaps = (column[gaps > JOINED_M] for column in (near, other, gaps))
    order = np.lexsort((gaps, near))
    _, first = np.unique(near[order], return_index=True)
    nearest = order[first]
    ways = shapely.shortest_line(ends[near[nearest]], lines[other[nearest]])
    return np.concatenate((segments, shapely.get_coordinates(ways).reshape(-1, 2, 2)))


def thick(lines: Any, radius: float) -> shapely.Geometry:
    """All that is within a distance [m] of any of an array of lines.

    One by one and then united: a hundred times faster than the buffer of all lines as one.
    """
    return shapely.union_all(shapely.buffer(lines, radius, quad_segs=ARC_SIDES))
