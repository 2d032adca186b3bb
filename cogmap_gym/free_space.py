"""The part of the plane that walls enclose about a point."""

from __future__ import annotations

from collections.abc import Sequence

import shapely
from shapely.geometry import MultiLineString, Point, Polygon, box
from shapely.ops import polygonize, unary_union

from cogmap_gym.geometry import Points

THIN_WALL = 0.001
"""Half thickness that a wall drawn as one line takes out of the free space [m]. Ours."""


def free_space(walls: Sequence[Points], furniture: Sequence[Points], home: Points) -> Polygon:
    """Where a point can get to from home.

    What the walls enclose about home, less furniture; a wall drawn as one line takes
    ``THIN_WALL`` on either side. Where the outer walls have a gap, the box about all walls
    ends the space.

    Args:
        walls: polylines (K, 2) [m].
        furniture: polygons (K, 2) [m].
        home: shape (2,) [m]; in the box about the walls, on no wall and in no furniture.
    """
    lines = MultiLineString(list(walls))
    noded = unary_union([lines, box(*lines.bounds).exterior])
    point = Point(home)
    face = next(part for part in polygonize(noded) if part.covers(point))
    thin = noded.intersection(face).difference(face.boundary).buffer(THIN_WALL)
    solids = unary_union([thin, *map(Polygon, furniture)])
    parts = shapely.get_parts(face.difference(solids))
    return next(part for part in parts if part.covers(point))
