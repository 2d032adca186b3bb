"""From loose lines to walls: what bounds the free space about home, joined and straightened."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from shapely.geometry import MultiLineString, box
from shapely.ops import linemerge

from cogmap_gym.free_space import THIN_WALL, free_space
from cogmap_gym.geometry import Points, Pose, Segments, point_segment_distances
from cogmap_gym.grid import CELL_M, Grid
from cogmap_gym.observation import RobotSpec
from cogmap_gym.openings import shut_cracks, shut_openings, thick
from cogmap_gym.raster import Raster, most_open_point, part_with
from cogmap_gym.room_cells import room_outlines
from cogmap_gym.segment_file import Drawing

DRAWN_M = 0.001
"""Ends of lines nearer than this are one [m]. Ours: a pen's breadth at any scale."""
TOLERANCE_M = 0.01
"""Walls keep within this distance of the lines [m]. Ours: the noise of the laser."""
OPEN_M = 0.01
"""More of the box about all lines than this, bare in the free space, is an opening [m]. Ours."""
NEAR_M = 2.0 * THIN_WALL + DRAWN_M
"""A line within this distance of the free space bounds it [m]."""
WALL_M = 0.06
"""Cells whose middle is nearer to a line are not free [m]: over half a cell, so that a line
parts the cells on its two sides."""


def segment_plan(drawing: Drawing, origin: str) -> dict[str, Any]:
    """The mapping of the plan that loose lines show.

    Openings to the outside are shut, and lines that do not bound the free space about home
    left out. Where that is open to the outside still, the box about all lines is a wall, too.

    Raises:
        ValueError: no free space, or a home that is no place for a robot; names the origin.
    """
    given = None if drawing.home is None else np.array(drawing.home[:2])
    segments = shut_openings(shut_cracks(drawing.segments), given)
    raster = _raster(segments)
    x, y, degrees = drawing.home or (*most_open_point(raster, origin).tolist(), 0.0)
    home = np.array((x, y))
    _check_home(home, segments, origin)
    walls = _walls_about(segments, home)
    part = _part_about(home, np.concatenate([np.stack((w[:-1], w[1:]), axis=1) for w in walls]))
    return {
        "name": drawing.name,
        "walls": [wall.tolist() for wall in walls],
        "furniture": [],
        "doors": {},
        "closed": [],
        "barriers": {},
        "rooms": room_outlines(part, None, origin, grown=True),
        "home": [x, y, degrees],
    }


def _raster(segments: Segments) -> Raster:
    grid = Grid.over(segments)
    return Raster(~grid.near(segments, WALL_M), CELL_M, Pose(grid.x0, grid.y0))


def _part_about(home: Points, segments: Segments) -> Raster:
    """The free cells that hang together with home."""
    raster = _raster(segments)
    cell = raster.cell_of(home)
    assert cell is not None, "home lies between the walls"
    assert raster.free[cell], "home keeps its distance from all walls"
    return part_with(raster, *cell)


def _check_home(home: Points, segments: Segments, origin: str) -> None:
    gap, radius = point_segment_distances(home[None], segments).min(), RobotSpec().radius
    low, high = segments.min(axis=(0, 1)), segments.max(axis=(0, 1))
    gap = min(gap, *(home - low), *(high - home))  # the box about all lines may become a wall
    if gap < radius:
        raise ValueError(
            f"{origin}: home: expected a place between the lines, {radius} m or more from each "
            f"and from the box about all, got {home.tolist()}, {gap:.3f} m"
        )


def _walls_about(segments: Segments, home: Points) -> list[Points]:
    """The lines that bound the free space about home, as polylines (K, 2) [m]."""
    lines = shapely.union_all(shapely.linestrings(segments), grid_size=DRAWN_M)
    free = free_space([np.array(piece.coords) for piece in shapely.get_parts(lines)], (), home)
    frame = box(*lines.bounds).exterior
    if (
        free.boundary.intersection(frame)
        .difference(thick(shapely.get_parts(lines), DRAWN_M))
        .length
        > OPEN_M
    ):
        lines = shapely.union_all([lines, frame], grid_size=DRAWN_M)
    pieces = shapely.get_parts(lines)
    middles = shapely.line_interpolate_point(pieces, 0.5, normalized=True)
    shapely.prepare(free)
    merged = linemerge(MultiLineString(list(pieces[shapely.dwithin(free, middles, NEAR_M)])))
    simple = [line.simplify(TOLERANCE_M) for line in shapely.get_parts(merged)]
    return [np.array(line.coords) for line in simple if line.length > 0.0]
