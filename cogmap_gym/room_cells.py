"""Rooms for scoring: from the colours of an image, else by watershed on the clearance.

A room is where the clearance has a summit; two summits make one room where the pass between them
is nearly as wide as the lesser of the two.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely.geometry import LineString, Polygon
from skimage.feature import peak_local_max
from skimage.segmentation import expand_labels, watershed

from cogmap_gym.geometry import Array
from cogmap_gym.raster import FITS_M, Labels, Mask, Raster, clearance

SAME_ROOM = 0.7
"""A pass of this share of the lesser summit's clearance, or more, parts no rooms [-]. Ours: a
doorway of 1 m in a corridor of 2 m has 0.5."""
SUMMITS_APART_M = 0.5
"""Summits nearer to each other than this are one [m]. Ours."""
LEAST_ROOM_M2 = 2.0
"""Smaller rooms join their widest neighbour [m^2]. Ours: a cupboard."""
ISLAND_M = 2.5
"""Islands in the free space no longer than this to any side, furniture, part no rooms [m]. Ours."""
SLIT_M = 0.02
"""Width of the slit by which a room that runs round others is cut open [m]. Ours: the format
knows no polygon with holes."""
DIAGONAL = 1.5
"""Nearer than this are the neighbours of a cell, those at its corners too [cells]."""
TOLERANCE_CELLS = 1.0
"""How far the outline of a room may lie from its cells' edges [cells]. Ours."""


def room_outlines(
    part: Raster, colours: NDArray[np.int64] | None, origin: str, *, grown: bool = False
) -> dict[str, list[list[float]]]:
    """The polygons of all rooms, by name, the largest first.

    Args:
        part: the free space, one part.
        colours: (rows, columns), a number a cell; where they are alike and the cells hang
            together is a room. None: by watershed.
        origin: what messages call the image of the rooms.
        grown: rooms reach a cell beyond the free cells, up to the middle between two.

    Raises:
        ValueError: the image shows no room.
    """
    gaps = clearance(part)
    if colours is None:
        rooms = _watershed(part)
    else:
        seeds = _coloured(part, colours)
        if not seeds.any():
            raise ValueError(f"{origin}: expected areas of one colour in the free space, got none")
        rooms = watershed(-gaps, seeds, mask=part.free)  # type: ignore[no-untyped-call]
    if grown:
        rooms = expand_labels(rooms, DIAGONAL)  # type: ignore[no-untyped-call]
    areas = np.bincount(rooms.ravel())
    areas[0] = 0
    order = np.argsort(-areas, kind="stable")[: np.count_nonzero(areas)]
    outlines = (_outline(part, rooms, int(label)) for label in order)
    return {f"R{n}": outline for n, outline in enumerate(outlines, 1)}


def _coloured(part: Raster, colours: NDArray[np.int64]) -> Labels:
    """The parts of one colour in which a robot finds room, numbered from 1."""
    inner = part.free.copy()
    inner[1:] &= colours[1:] == colours[:-1]
    inner[:, 1:] &= colours[:, 1:] == colours[:, :-1]
    parts, count = ndimage.label(inner)
    deepest = ndimage.maximum(clearance(part.within(inner)), parts, np.arange(count + 1))
    wide = np.asarray(deepest) >= FITS_M
    wide[0] = False
    return np.asarray(np.where(wide, np.cumsum(wide), 0)[parts], dtype=np.int32)


def _watershed(part: Raster) -> Labels:
    filled = part.within(_without_islands(part.free, ISLAND_M / part.cell))
    gaps = clearance(filled)
    apart = max(round(SUMMITS_APART_M / part.cell), 1)
    summits = peak_local_max(  # type: ignore[no-untyped-call]
        gaps, min_distance=apart, threshold_abs=FITS_M
    )
    seeds = np.zeros(gaps.shape, dtype=np.int32)
    seeds[tuple(summits.T)] = np.arange(1, len(summits) + 1)
    basins = watershed(-gaps, seeds, mask=filled.free)  # type: ignore[no-untyped-call]
    return _joined_if_small(_joined(basins, gaps), LEAST_ROOM_M2 / part.cell**2)


def _without_islands(free: Mask, cells: float) -> Mask:
    """Fill in the islands that span no more cells than given, in rows and in columns."""
    parts, _ = ndimage.label(~free, np.ones((3, 3)))
    spans = [
        max(rows.stop - rows.start, columns.stop - columns.start)
        for rows, columns in ndimage.find_objects(parts)
    ]
    small = np.concatenate(([False], np.array(spans) <= cells))
    border = np.concatenate((parts[[0, -1]].ravel(), parts[:, [0, -1]].ravel()))
    small[border] = False
    return np.asarray(free | small[parts])


def _borders(labels: Labels, gaps: Array) -> tuple[NDArray[np.int64], Array, NDArray[np.int64]]:
    """Each pair of neighbouring labels (K, 2), its widest pass [m], its length [cells]."""
    pairs, widths = [], []
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        a, b = labels[one], labels[other]
        at = (a != b) & (a > 0) & (b > 0)
        pairs.append(np.sort(np.column_stack((a[at], b[at])), axis=1).astype(np.int64))
        widths.append(np.minimum(gaps[one][at], gaps[other][at]))
    unique, row = np.unique(np.concatenate(pairs), axis=0, return_inverse=True)
    passes = np.zeros(len(unique))
    np.maximum.at(passes, row.ravel(), np.concatenate(widths))
    return unique, passes, np.bincount(row.ravel(), minlength=len(unique))


def _joined(basins: Labels, gaps: Array) -> Labels:
    """One label for basins between which the pass is nearly as wide as the lesser summit."""
    pairs, passes, _ = _borders(basins, gaps)
    count = int(basins.max()) + 1
    summit = np.asarray(ndimage.maximum(gaps, basins, np.arange(count)), dtype=np.float64)
    parent = np.arange(count)
    for row in np.argsort(-passes, kind="stable"):
        a, b = (_root(parent, label) for label in pairs[row])
        if a != b and passes[row] >= SAME_ROOM * min(summit[a], summit[b]):
            low, high = (a, b) if summit[a] < summit[b] else (b, a)
            parent[low] = high
    return _relabelled(basins, parent)


def _joined_if_small(rooms: Labels, cells: float) -> Labels:
    """Each room of fewer cells than given joins the neighbour with the longest border."""
    while True:
        pairs, _, borders = _borders(rooms, np.zeros(rooms.shape))
        areas = np.bincount(rooms.ravel())
        small = (areas[pairs] < cells).any(axis=1) if len(pairs) else np.zeros(0, dtype=bool)
        if not small.any():
            return rooms
        least = areas[pairs].min(axis=1)
        row = np.lexsort((-borders, least))[0]
        a, b = pairs[row]
        lesser, greater = (a, b) if areas[a] < areas[b] else (b, a)
        rooms = np.where(rooms == lesser, greater, rooms)


def _root(parent: NDArray[np.int64], label: int) -> int:
    while parent[label] != label:
        label = parent[label]
    return int(label)


def _relabelled(labels: Labels, parent: NDArray[np.int64]) -> Labels:
    roots = np.array([_root(parent, label) for label in range(len(parent))])
    return np.asarray(roots[labels], dtype=np.int32)


def _outline(part: Raster, rooms: Labels, label: int) -> list[list[float]]:
    """The polygon of a room: islands filled in, cut open where it runs round other rooms."""
    cells, count = ndimage.label(rooms == label)
    own = cells == np.argmax(np.bincount(cells.ravel())[1:]) + 1 if count > 1 else cells > 0
    islands, _ = ndimage.label(~own, np.ones((3, 3)))
    others = np.bincount(islands.ravel(), weights=(rooms.ravel() > 0) & ~own.ravel()) > 0
    border = np.concatenate((islands[[0, -1]].ravel(), islands[:, [0, -1]].ravel()))
    others[border] = True
    polygon = part.outline(own | ~others[islands], TOLERANCE_CELLS * part.cell)
    return [[float(x), float(y)] for x, y in _cut_open(polygon).exterior.coords[:-1]]


def _cut_open(polygon: Polygon) -> Polygon:
    """The polygon without holes: slits lead from each to the outside."""
    while polygon.interiors:
        way = min(
            (shapely.shortest_line(polygon.exterior, hole) for hole in polygon.interiors),
            key=lambda line: float(line.length),
        )
        (ax, ay), (bx, by) = way.coords
        longer = SLIT_M / max(float(way.length), SLIT_M)
        dx, dy = longer * (bx - ax), longer * (by - ay)
        slit = LineString([(ax - dx, ay - dy), (bx + dx, by + dy)])
        rest = polygon.difference(slit.buffer(SLIT_M / 2.0, cap_style="flat"))
        polygon = max(shapely.get_parts(rest), key=lambda piece: float(piece.area))
    return polygon
