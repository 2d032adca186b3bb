"""The robot's belief as plain numbers, for people and pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from skimage.measure import approximate_polygon, find_contours

from agents.frontier.grid import OccupancyGrid
from agents.frontier.planner import Way
from cogmap_gym.geometry import Points, Pose

COARSE = 1.0
"""Outlines are drawn to this many cells [1]."""


def draw_sketch(
    grid: OccupancyGrid, pose: Pose, marks: dict[int, Points], way: Way | None, status: str
) -> dict[str, Any]:
    """The sketch of the agent protocol, and ``way``: the points of the way being followed."""
    lines = outlines(grid)
    home = marks.get(1)
    return {
        "surfaces": [{"id": k, "p": p.tolist(), "q": q.tolist()} for k, (p, q) in enumerate(lines)],
        "exits": [],
        "asrs": [],
        "links": [],
        "here": 0,
        "pose": [pose.x, pose.y, pose.theta],
        "home": None if home is None else home.tolist(),
        "marks": [{"id": k, "point": point.tolist()} for k, point in marks.items()],
        "route": None,
        "way": [] if way is None else way.points.tolist(),
        "status": status,
    }


def outlines(grid: OccupancyGrid) -> list[Points]:
    """The outlines of what is occupied, as pieces (2, 2) [m]."""
    occupied = grid.votes > 0
    cells = np.argwhere(occupied)
    if len(cells) == 0:
        return []
    low, high = cells.min(axis=0) - 1, cells.max(axis=0) + 2
    low = np.maximum(low, 0)
    part = occupied[low[0] : high[0], low[1] : high[1]].astype(np.float32)
    pieces: list[Points] = []
    for ring in find_contours(part, 0.5):  # type: ignore[no-untyped-call]
        corners = approximate_polygon(ring, COARSE)  # type: ignore[no-untyped-call]
        points = grid.corner + (corners[:, ::-1] + low[::-1] + 0.5) * grid.cell
        pieces += list(np.stack((points[:-1], points[1:]), axis=1))
    return pieces
