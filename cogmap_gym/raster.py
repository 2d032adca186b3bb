"""Free space as square cells, and what can be read off them: parts, the most open point, outlines.

A raster has its lowest row first; its own frame has its origin at the lower left corner of cell
(0, 0), x along the columns and y along the rows, in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely.geometry import MultiLineString, Polygon
from skimage.measure import find_contours

from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import RobotSpec

Mask = NDArray[np.bool_]
Labels = NDArray[np.int32]

FITS_M = RobotSpec().radius + 0.05
"""Clearance that a home needs [m]. Ours: the robot's radius and a cell of 5 cm."""
OUTSIDE_SHARE = 0.05
"""Free space that touches the border of a drawing is taken for the outside, if enclosed space of
this share of it, or more, is there as well [-]. Ours."""
CORNER = 0.98
"""How far into the corner between two cells an outline goes [-]: not quite, so that cells that
touch by a corner alone keep apart. Ours."""


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Which cells are free."""

    free: Mask
    """(rows, columns), the lowest row first."""
    cell: float
    """Side of a cell [m]."""
    plan_from_raster: Pose
    """Where the raster lies in the plan."""

    def cropped(self, box: tuple[slice, slice]) -> Raster:
        """The part in a box of rows and columns."""
        corner = Pose(self.cell * box[1].start, self.cell * box[0].start)
        return Raster(self.free[box], self.cell, self.plan_from_raster @ corner)

    def within(self, free: Mask) -> Raster:
        """Other free cells at the same place."""
        return Raster(free, self.cell, self.plan_from_raster)

    def cell_of(self, point: Points) -> tuple[int, int] | None:
        """The row and column of a point (2,) of the plan [m]; None outside the raster."""
        x, y = self.plan_from_raster.inverse().apply(point) // self.cell
        rows, columns = self.free.shape
        inside = 0 <= y < rows and 0 <= x < columns
        return (int(y), int(x)) if inside else None

    def middle_of(self, row: int, column: int) -> Points:
        """The middle (2,) of a cell in the plan [m]."""
        corner = np.array((column + 0.5, row + 0.5))
        return self.plan_from_raster.apply(self.cell * corner)

    def outline(self, cells: Mask, tolerance: float) -> Polygon:
        """The outline of cells that hang together, in the plan's frame, simplified.

        Args:
            cells: (rows, columns), one part by the sides of its cells; it may have holes.
            tolerance: the outline keeps within this distance of the cells' edges [m].
        """
        place, outlines = (
            self.plan_from_raster.apply,
            _simplified(_rings(cells), tolerance / self.cell),
        )
        moved = [place(self.cell * ring) for ring in outlines]
        moved.sort(key=lambda ring: -float(Polygon(ring).area))
        return Polygon(moved[0], moved[1:])


def bounding_box(cells: Mask, margin: int) -> tuple[slice, slice] | None:
    """The rows and columns that hold all marked cells and a margin; None if there are none."""
    rows, columns = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    spans = zip((rows, columns), cells.shape, strict=True)
    low, high = zip(
        *((max(int(at[0]) - margin, 0), min(int(at[-1]) + 1 + margin, end)) for at, end in spans),
        strict=True,
    )
    return slice(low[0], high[0]), slice(low[1], high[1])


def clearance(raster: Raster) -> Array:
    """How far the middle of each free cell is from the nearest that is not free [m].

    Beyond the border of the raster nothing is free. The distance is to the near edge of the
    other cell, or less.
    """
    distance = ndimage.distance_transform_edt(np.pad(raster.free, 1))[1:-1, 1:-1]
    return np.asarray(raster.cell * np.maximum(distance - 0.5, 0.0))


def part_with(raster: Raster, row: int, column: int) -> Raster:
    """The free cells that hang together with one of them, cropped, with a border of one cell."""
    parts, _ = ndimage.label(raster.free)
    cells = np.pad(parts == parts[row, column], 1)
    corner = Pose(-raster.cell, -raster.cell)
    padded = Raster(cells, raster.cell, raster.plan_from_raster @ corner)
    box = bounding_box(cells, 1)
    assert box is not None, "the cell itself is marked"
    return padded.cropped(box)


def most_open_point(raster: Raster, origin: str) -> Points:
    """The middle (2,) of the cell farthest from all that is not free, in the largest free part.

    What hangs together with the border of the raster is the outside, unless nearly all is.

    Raises:
        ValueError: the robot fits nowhere.
    """
    parts, count = ndimage.label(raster.free)
    gaps = clearance(raster)
    deepest = ndimage.maximum(gaps, parts, np.arange(count + 1))
    areas = np.bincount(parts.ravel(), minlength=count + 1) * (np.asarray(deepest) >= FITS_M)
    areas[0] = 0
    if not areas.any():
        raise ValueError(
            f"{origin}: free space: expected room for a robot, {FITS_M:.2f} m to all sides, "
            f"got {gaps.max(initial=0.0):.2f} m at most"
        )
    border = np.concatenate((parts[[0, -1]].ravel(), parts[:, [0, -1]].ravel()))
    enclosed = areas.copy()
    enclosed[border] = 0
    if enclosed.max() >= OUTSIDE_SHARE * areas.max():
        areas = enclosed
    row, column = np.unravel_index(
        np.argmax(np.where(parts == np.argmax(areas), gaps, -1.0)), parts.shape
    )
    return raster.middle_of(int(row), int(column))


def _simplified(rings: list[Points], tolerance: float) -> list[Points]:
    """Open rings (K, 2) with fewer points; they cross neither themselves nor one another.

    Each is cut in two, at its first corner and the one farthest from that, for the library may
    take the ends of a ring away beyond the tolerance. Rings too small for it stay as they are.
    """
    halves: list[Points] = []
    for ring in rings:
        begun = np.roll(ring, -int(np.lexsort(ring.T[::-1])[0]), axis=0)
        far = int(np.argmax(np.hypot(*(begun - begun[0]).T)))
        halves += [begun[: far + 1], np.concatenate((begun[far:], begun[:1]))]
    lines = shapely.get_parts(MultiLineString(halves).simplify(tolerance))
    kept = [shapely.get_coordinates(line)[:-1] for line in lines]
    joined = [np.concatenate(pair) for pair in zip(kept[::2], kept[1::2], strict=True)]
    return [new if len(new) > 2 else ring for new, ring in zip(joined, rings, strict=True)]


def _rings(cells: Mask) -> list[Points]:
    """The closed outlines of cells, along their edges, as (x, y) in cells."""
    padded = np.pad(cells, 1).astype(np.float64)
    contours = find_contours(padded, 0.5, fully_connected="low")  # type: ignore[no-untyped-call]
    return [_corners(contour)[:, ::-1] - 0.5 for contour in contours]


def _corners(contour: Points) -> Points:
    """The corners (K, 2) of the cells' edges whose middles a closed contour goes through."""
    here, after = contour[:-1], contour[1:]
    turns = (here != after).all(axis=1)
    here, after = here[turns], after[turns]
    corner = np.where(here % 1.0 == 0.5, here, after)
    middle = (here + after) / 2.0
    return np.asarray(middle + CORNER * (corner - middle))
