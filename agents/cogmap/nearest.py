"""The boundary walk as thesis 3.5 has it: from each item to the nearest, in two directions."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.polygon import orient

from agents.cogmap.crossing import Crossing
from agents.cogmap.rays import NO_ROW, blocked
from cogmap_gym.geometry import Points, Segments

Walk = tuple[list[Points], list[int]]


def walk_nearest(
    crossing: Crossing, large: Segments, rows: NDArray[np.int64], corners: Points
) -> tuple[Points, NDArray[np.int64]]:
    """Connect one end of the exit to the nearest surface or corner, and on to the other end.

    Args:
        crossing: its exit and path.
        large: (L, 2, 2), large surfaces.
        rows: (L,), their rows among all surfaces.
        corners: (C, 2), corner points.

    Returns:
        The polygon (K, 2), counter-clockwise, (0, 2) if both directions got stuck; and the
        rows of the surfaces on it.
    """
    items = np.concatenate((large, np.stack((corners, corners), axis=1)))
    for begin, end in (crossing.exit[::-1], crossing.exit):
        found = _one_way(begin, end, items, len(large), crossing)
        if found is None:
            continue
        points, used = found
        polygon = shapely.Polygon(points)
        if polygon.is_valid and polygon.area > 0.0:
            order = np.array(orient(polygon).exterior.coords)[:-1]
            return order, rows[np.array(used, dtype=np.int64)]
    return np.zeros((0, 2)), np.zeros(0, dtype=np.int64)


def _one_way(
    begin: Points, end: Points, items: Segments, n_large: int, crossing: Crossing
) -> Walk | None:
    """Walk from one jamb to the other; None where it gets stuck."""
    walk, used, left = [begin], list[int](), list(range(len(items)))
    fixed = np.concatenate((crossing.path, items[:n_large], crossing.exit[None]))
    while True:
        # Each option: the end of an item, as (distance, item, end); the goal is item -1.
        options = [(float(np.hypot(*(items[k, e] - walk[-1]))), k, e) for k in left for e in (0, 1)]
        if len(walk) > 1:
            options.append((float(np.hypot(*(end - walk[-1]))), -1, 0))
        so_far = np.stack((walk[:-1], walk[1:]), axis=1) if len(walk) > 1 else fixed[:0]
        rules = np.concatenate((fixed, so_far))
        for _, k, e in sorted(options):
            target = end if k < 0 else items[k, e]
            if not _allowed(np.array((walk[-1], target)), rules):
                continue
            if k < 0:
                return [*walk, end], used
            left.remove(k)
            walk.append(target)
            if k < n_large:
                walk.append(items[k, 1 - e])
                used.append(k)
            break
        else:
            return None


def _allowed(connection: Points, rules: Segments) -> bool:
    """Whether a connection crosses nothing: path, large surfaces, exit, boundary so far."""
    return not blocked(connection[None], rules, np.array((NO_ROW,)))[0]
