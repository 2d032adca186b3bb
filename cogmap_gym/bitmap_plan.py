"""From a bitmap to line walls: cleaned, the part that holds home, outlined and simplified."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from cogmap_gym.bitmap_file import Bitmap
from cogmap_gym.raster import Mask, Raster, bounding_box, most_open_point, part_with
from cogmap_gym.room_cells import room_outlines

SPECK_M2 = 0.01
"""What is not free and smaller than this, within free space, is noise [m^2]. Ours: four pixels of
5 cm, the leg of a table, stay."""
RAY_M = 0.15
"""Free space narrower than about this is a ray of the laser that made the bitmap [m]. Ours."""
RAY_CELLS = 12
"""Such free space is taken away if it has more cells than this [-]. Ours: the tip of a corner
of 10 degrees stays."""
TOLERANCE_CELLS, TOLERANCE_M = 1.0, 0.1
"""Walls keep within the lesser of these distances of the edges of free pixels [cells, m]. Ours:
with the rays that are shut off, 1.5 cells at most; coarse bitmaps have narrow corridors."""
NEIGHBOURS = np.ones((3, 3), dtype=np.bool_)
"""Walls hang together by the corners of pixels; free space by their sides alone."""


def bitmap_plan(bitmap: Bitmap, origin: str) -> dict[str, Any]:
    """The mapping of the plan that a bitmap shows.

    Raises:
        ValueError: no free space, or a home that is not in it; names the origin.
    """
    raster, colours = _cleaned(bitmap, origin)
    x, y, degrees = bitmap.home or (*most_open_point(raster, origin).tolist(), 0.0)
    cell = raster.cell_of(np.array((x, y)))
    if cell is None or not raster.free[cell]:
        raise ValueError(f"{origin}: home: expected a place in free space, got {[x, y]}")
    part = part_with(raster, *cell)
    outline = part.outline(part.free, min(TOLERANCE_CELLS * part.cell, TOLERANCE_M))
    if colours is not None:
        colours = _colours_within(colours, raster, part)
    return {
        "name": bitmap.name,
        "walls": [_ring(ring) for ring in (outline.exterior, *outline.interiors)],
        "furniture": [],
        "doors": {},
        "closed": [],
        "barriers": {},
        "rooms": room_outlines(part, colours, f"{origin}: rooms"),
        "home": [x, y, degrees],
    }


def _cleaned(bitmap: Bitmap, origin: str) -> tuple[Raster, Any]:
    """The free space without specks and rays, cropped, and the colours of rooms there."""
    raster = bitmap.raster
    box = bounding_box(raster.free, 1)
    if box is None:
        raise ValueError(f"{origin}: image: expected free space, got none")
    colours = None if bitmap.rooms is None else bitmap.rooms[box]
    raster = raster.cropped(box)
    free = _without_specks(raster.free, SPECK_M2 / raster.cell**2)
    if 2.0 * raster.cell <= RAY_M:
        free = _without_rays(free)
    return raster.within(free), colours


def _without_specks(free: Mask, cells: float) -> Mask:
    """Fill in what is not free and has fewer cells than given."""
    parts, _ = ndimage.label(~free, NEIGHBOURS)
    small = np.bincount(parts.ravel()) < cells
    small[0] = False
    return np.asarray(free | small[parts])


def _without_rays(free: Mask) -> Mask:
    """Take away long parts of the free space that are one or two cells wide."""
    thin = free & ~ndimage.binary_opening(free, NEIGHBOURS)
    parts, _ = ndimage.label(thin, NEIGHBOURS)
    long = np.bincount(parts.ravel()) > RAY_CELLS
    long[0] = False
    return np.asarray(free & ~long[parts])


def _colours_within(colours: Any, raster: Raster, part: Raster) -> Any:
    """The colours at the cells of a part of a raster, which may reach beyond it by a cell."""
    corner = raster.plan_from_raster.inverse() @ part.plan_from_raster
    row, column = (round(value / raster.cell) + 1 for value in (corner.y, corner.x))
    rows, columns = part.free.shape
    return np.pad(colours, 1)[row : row + rows, column : column + columns]


def _ring(ring: Polygon) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in ring.coords]
