"""Points of a scan with the normals of the walls they lie on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from agents.frontier import params
from cogmap_gym.geometry import Array, Points, Pose


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
def spaced(points: Array, spacing: float) -> Array:
    """Whether each point (N, 2) is farther than ``spacing`` from the last one kept, (N,)."""
    kept = np.zeros(len(points), dtype=np.bool_)
    last = -1
    for k in range(len(points)):
        if last < 0 or apart(points, k, last) >= spacing:
            kept[k] = True
            last = k
    return kept


@njit(cache=True)
def wall_normals(points: Array, support: float, gap: float, flat: float) -> Array:
    """The normal of the line through each point and its neighbours, towards the origin.

    Args:
        points: (N, 2) in the order of the beams [m].
        support: the line reaches this far to both sides, or over two neighbours if that is
            farther [m].
        gap: neighbours farther apart are not on one line [m].
        flat: largest root mean square deviation from the line [m].

    Returns:
        (N, 2); NaN for a point without a line.
    """
    count = len(points)
    normals = np.full((count, 2), np.nan)
    for k in range(count):
        first, last = k, k
        for _ in range(count):
            step = first - 1
            if step < 0 or apart(points, step, first) > gap:
                break
            if k - step > 2 and apart(points, step, k) > support:
                break
            first = step
        for _ in range(count):
            step = last + 1
            if step >= count or apart(points, step, last) > gap:
                break
            if step - k > 2 and apart(points, step, k) > support:
                break
            last = step
        if last - first < 3:
            continue
        mx, my = 0.0, 0.0
        for m in range(first, last + 1):
            mx += points[m, 0]
            my += points[m, 1]
        n = last - first + 1
        mx, my = mx / n, my / n
        sxx, sxy, syy = 0.0, 0.0, 0.0
        for m in range(first, last + 1):
            dx, dy = points[m, 0] - mx, points[m, 1] - my
            sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
        least = (sxx + syy) / 2.0 - np.sqrt(((sxx - syy) / 2.0) ** 2 + sxy**2)
        if np.sqrt(max(0.0, least) / n) > flat:
            continue
        along = 0.5 * np.arctan2(2.0 * sxy, sxx - syy)
        nx, ny = -np.sin(along), np.cos(along)
        side = -1.0 if nx * points[k, 0] + ny * points[k, 1] > 0.0 else 1.0
        normals[k, 0], normals[k, 1] = side * nx, side * ny
    return normals
