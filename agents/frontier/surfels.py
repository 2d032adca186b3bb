"""Points of a scan with the normals of the walls they lie on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from agents.frontier import params
from cogmap_gym.geometry import Array, Points, Pose

NEIGHBOURS = 2
"""So many points to a side, if there are any, belong to the wall about a point [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Surfels:
    """Points on walls, each with the wall's unit normal, which looks at the robot."""

    points: Points
    """(N, 2) [m]."""
    normals: Points
    """(N, 2) [1]."""

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, a_from_b: Pose) -> Surfels:
        """The same in another frame."""
        turn = Pose(0.0, 0.0, a_from_b.theta)
        return Surfels(a_from_b.apply(self.points), turn.apply(self.normals))


def surfels_of(hits: Points, numbers: params.Matching) -> Surfels:
    """The hits of a scan that lie on walls, thinned out.

    Args:
        hits: (H, 2) in the robot's frame and in the order of the beams [m].
        numbers: how a wall is recognised.
    """
    normals = wall_normals(hits, numbers.support, numbers.gap, numbers.flat)
    kept = spaced(hits, numbers.spacing) & np.isfinite(normals[:, 0])
    return Surfels(hits[kept], normals[kept])


def joined(parts: list[Surfels]) -> Surfels:
    """All of them as one."""
    return Surfels(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
    )


@njit(cache=True)
def apart(points: Array, a: int, b: int) -> float:
    """How far two rows of (N, 2) are from one another [m]."""
    return math.hypot(points[a, 0] - points[b, 0], points[a, 1] - points[b, 1])


@njit(cache=True)
def spaced(points: Array, spacing: float) -> NDArray[np.bool_]:
    """Whether each point (N, 2) is farther than ``spacing`` from the last one kept, (N,)."""
    kept = np.zeros(len(points), dtype=np.bool_)
    last = -1
    for k in range(len(points)):
        if last < 0 or apart(points, k, last) >= spacing:
            kept[k] = True
            last = k
    return kept


@njit(cache=True)
def wall_end(points: Array, row: int, way: int, support: float, gap: float) -> int:
    """The last row of (N, 2), going up (``way`` 1) or down (-1), on the wall about ``row``."""
    end = row
    while 0 <= end + way < len(points) and apart(points, end + way, end) <= gap:
        beyond = apart(points, end + way, row) > support
        if beyond and abs(end + way - row) > NEIGHBOURS:
            break
        end += way
    return end


@njit(cache=True)
def wall_normals(points: Array, support: float, gap: float, flat: float) -> Array:
    """The normal of the line through each point and its neighbours, towards the origin.

    Args:
        points: (N, 2) in the order of the beams [m].
        support: the line reaches this far to both sides, or over ``NEIGHBOURS`` if they are
            farther [m].
        gap: neighbours farther apart are not on one line [m].
        flat: largest root mean square deviation from the line [m].

    Returns:
        (N, 2); NaN for a point without a line.
    """
    normals = np.full((len(points), 2), np.nan)
    for row in range(len(points)):
        first = wall_end(points, row, -1, support, gap)
        last = wall_end(points, row, 1, support, gap)
        count = last - first + 1
        if count <= NEIGHBOURS + 1:
            continue
        mx, my = 0.0, 0.0
        for k in range(first, last + 1):
            mx, my = mx + points[k, 0] / count, my + points[k, 1] / count
        sxx, sxy, syy = 0.0, 0.0, 0.0
        for k in range(first, last + 1):
            dx, dy = points[k, 0] - mx, points[k, 1] - my
            sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
        least = (sxx + syy) / 2.0 - math.hypot((sxx - syy) / 2.0, sxy)
        if least > count * flat**2:
            continue
        along = 0.5 * math.atan2(2.0 * sxy, sxx - syy)
        nx, ny = -math.sin(along), math.cos(along)
        side = -1.0 if nx * points[row, 0] + ny * points[row, 1] > 0.0 else 1.0
        normals[row, 0], normals[row, 1] = side * nx, side * ny
    return normals
