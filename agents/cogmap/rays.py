"""Which straight lines cross which: the sight lines and connections of Algorithms 7 and 8."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cogmap_gym.geometry import Points, Segments

NO_ROW = -1
"""The row of what is no blocker itself [1]."""


def shorten(rays: Segments, margin: float) -> Segments:
    """Pull the far end of each ray back by ``margin`` metres, at most by half of it."""
    along = rays[:, 1] - rays[:, 0]
    size = np.hypot(along[:, 0], along[:, 1])
    share = np.minimum(margin / np.where(size > 0.0, size, 1.0), 0.5)
    out = rays.copy()
    out[:, 1] -= share[:, None] * along
    return out


@njit(cache=True)
def blocked(rays: Segments, blockers: Segments, own: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which rays properly cross a blocker, other than the one in row ``own``."""
    out = np.zeros(len(rays), dtype=np.bool_)
    for i in range(len(rays)):
        for k in range(len(blockers)):
            if k != own[i] and crosses(
                rays[i, 0, 0], rays[i, 0, 1], rays[i, 1, 0], rays[i, 1, 1], blockers[k]
            ):
                out[i] = True
                break
    return out


@njit(cache=True)
def crosses(px: float, py: float, qx: float, qy: float, other: Points) -> bool:
    """Whether the segment p-q properly crosses ``other`` (2, 2)."""
    ax, ay, bx, by = other[0, 0], other[0, 1], other[1, 0], other[1, 1]
    rx, ry = qx - px, qy - py
    d0 = rx * (ay - py) - ry * (ax - px)
    d1 = rx * (by - py) - ry * (bx - px)
    if d0 * d1 >= 0.0:
        return False
    sx, sy = bx - ax, by - ay
    e0 = sx * (py - ay) - sy * (px - ax)
    e1 = sx * (qy - ay) - sy * (qx - ax)
    return bool(e0 * e1 < 0.0)
