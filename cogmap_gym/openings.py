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
NOOK_M2 = 3.0
"""What lies behind an opening must be larger [m^2]. Ours: the disc does not get into corners."""
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
    space = Polygon(beyond).difference(thick(lines, WIDEST_M / 2.0, ARC_SIDES))
    around = next(part for part in shapely.get_parts(space) if part.intersects(beyond))
    outside = around.buffer(WIDEST_M / 2.0, quad_segs=ARC_SIDES)
    if home is not None and outside.covers(Point(home)):
        return segments
    inner = outside.boundary.difference(beyond.buffer(WIDEST_M))
    seams = shapely.get_parts(inner.difference(thick(lines, TOUCHING_M)))
    seams = _with_rooms_behind(seams[shapely.length(seams) > 0.0], lines, outside)
    ends = [np.array(seam.coords)[[0, -1]] for seam in seams]
    met = _nearest(np.reshape(ends, (-1, 2)), lines).reshape(-1, 2, 2)
    return np.concatenate((segments, met[(met[:, 0] != met[:, 1]).any(axis=1)]))


def _with_rooms_behind(seams: Any, lines: Any, outside: shapely.Geometry) -> Any:
    """Those borders of the outside that have more than a nook on their other side."""
    noded = shapely.union_all([*lines, outside.boundary])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    rooms = faces[shapely.area(faces) > NOOK_M2]
    rooms = rooms[~shapely.covers(outside, shapely.point_on_surface(rooms))]
    middles = shapely.line_interpolate_point(seams, 0.5, normalized=True)
    return seams[np.unique(shapely.STRtree(rooms).query(middles, "dwithin", JOINED_M)[0])]


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


def thick(lines: Any, radius: float, arc_sides: int = 2) -> shapely.Geometry:
    """All that is within a distance [m] of any of an array of lines.

    One by one and then united: a hundred times faster than the buffer of all lines as one.
    """
    return shapely.union_all(shapely.buffer(lines, radius, quad_segs=arc_sides))
