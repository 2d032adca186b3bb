"""The compiled laser kernel behind ``cogmap_gym.raycast``: plain arrays in and out.

Seen from the laser, the *inverse* range of a wall is linear in the direction of the beam:
``1 / r = a * cos(phi) + b * sin(phi)``. A scan is therefore a one-dimensional z-buffer over
inverse range: each wall costs its two end beams, one division and a running maximum.

Large worlds are cut in square cells, walked outward in square rings around the laser.
After each ring the beams that ended inside it are final; cells and walls that only final
beams could meet are passed over, and the walk stops when no beam is open.

Ends of segments are closed: a beam that passes within ``SLACK`` of an end meets it, so no
beam leaks through a corner. Walls are drawn in the *fan frame*: the laser at the origin, the
middle of the fan along +x, so that the seam at +-pi lies behind the fan. ``fan`` holds the
cosines and sines of the beams there, (2, beams) padded to a multiple of ``LANES``; ``last`` is
the last beam.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeVar

import numba
import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array

SLACK: Final = 1e-9
"""A beam this near to the end of a segment meets it [m]. Ours: far under the laser's noise."""
ANGLE_ERROR: Final = 2e-5
"""Bound on the error of ``_angle`` [rad]: twice that of Abramowitz and Stegun 4.4.49."""
LANES: Final = 8
"""Beams are drawn in blocks of so many. Ours: no ragged loop ends, a seventh of the time."""

LISTED: Final = 64
"""Walls that are drawn together at most. Ours."""
CELL_MARGIN: Final = 1e-6
"""A segment is entered in the cells within this distance [m]. Ours: beyond all rounding."""

Ints = NDArray[np.int64]
_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Compile a numeric kernel, or leave it to Python under ``NUMBA_DISABLE_JIT=1``.

    No fast-math, so that bits do not depend on the processor; in Python, integers wrap and
    floats overflow as quietly as in compiled code. Only kernels of the same file may be
    called from a kernel: the cache on disk notices no change in another file.
    """
    jit: Any = numba
    if jit.config.DISABLE_JIT:
        return np.errstate(all="ignore")(function)
    kernel: _F = jit.njit(cache=True, error_model="numpy", forceinline=True)(function)
    return kernel


@compiled
def _angle(x: float, y: float) -> float:
    """Direction of (x, y) != 0 in [-pi, pi], to ``ANGLE_ERROR``, on the exact side of y = 0."""
    ax, ay = abs(x), abs(y)
    z = min(ax, ay) / max(ax, ay)
    w = z * z
    angle = z * (0.9998660 + w * (-0.3302995 + w * (0.1801410 + w * (-0.0851330 + w * 0.0208351))))
    if ay > ax:
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return angle if y >= 0.0 else -angle


@compiled
def _first_beam(x: float, y: float, fan: Array, last: int, step: float) -> int:
    """First beam at or counter-clockwise of the point (x, y); may be one past the last."""
    per_step = 1.0 / step  # One division, outside the loop over the walls.
    f, margin = _angle(x, y) * per_step + 0.5 * last, ANGLE_ERROR * per_step
    i: int = math.ceil(min(max(f - margin, 0.0), last + 1.0))
    stop = min(f + margin, 1.0 * last)
    while i <= stop and x * fan[1, i] - y * fan[0, i] < -SLACK:
        i += 1
    return i


@compiled
def _last_beam(x: float, y: float, fan: Array, last: int, step: float) -> int:
    """Last beam at or clockwise of the point (x, y); may be one before the first, -1."""
    per_step = 1.0 / step  # One division, outside the loop over the walls.
    f, margin = _angle(x, y) * per_step + 0.5 * last, ANGLE_ERROR * per_step
    i: int = math.floor(max(min(f + margin, 1.0 * last), -1.0))
    stop = max(f - margin, 0.0)
    while i >= stop and x * fan[1, i] - y * fan[0, i] > SLACK:
        i -= 1
    return i


@compiled
def _paint(low: int, high: int, a: float, b: float, fan: Array, inverse: Array) -> None:
    """Raise the inverse ranges of beams low..high, if any, to those of the line (a, b)."""
    # Unsigned indexes: signed ones may wrap, and the loop would not be vectorised.
    begin, end = np.uint64(low), np.uint64(high + 1)
    for i in range(np.uint64(low // LANES * LANES), np.uint64((high // LANES + 1) * LANES)):
        v = a * fan[0, i] + b * fan[1, i]
        v = v if (i >= begin) & (i < end) else 0.0
        inverse[i] = max(inverse[i], v)


@compiled
def _draw(
    px: float, py: float, qx: float, qy: float, fan: Array, last: int, step: float, inverse: Array
) -> None:
    """Draw the wall from p to q, in the fan frame.

    One exit only: with a second, numba counts references on every call, at twice the time.
    """
    sx, sy = qx - px, qy - py
    c = px * sy - py * sx
    if c * c > SLACK * SLACK * (sx * sx + sy * sy):
        a, b = sy / c, -sx / c
        if c < 0.0:
            px, py, qx, qy = qx, qy, px, py
    else:  # Edge-on: only the nearer end shows.
        if px * qx + py * qy <= 0.0:  # The laser stands on it; then any end will do.
            for i in range(len(inverse)):
                inverse[i] = math.inf
            px, py = 1.0, 0.0
        elif px * px + py * py > qx * qx + qy * qy:
            px, py = qx, qy
        qx, qy = px, py
        d = px * px + py * py
        a, b = px / d, py / d
    low = _first_beam(px, py, fan, last, step)
    high = _last_beam(qx, qy, fan, last, step)
    if py >= 0.0 and qy < 0.0:  # Across the seam behind the fan.
        _paint(low, last, a, b, fan, inverse)
        low = 0
    _paint(low, high, a, b, fan, inverse)


@compiled
def _list_walls(
    begin: int, end: int, count: int, c: float, s: float, x: float, y: float, behind: float,
    segments: Array, rows: Ints, seen: Ints, stamp: int, walls: Array,
) -> int:  # fmt: skip
    """List the walls of rows[begin:end] that are new, in the fan frame; answer the list's end."""
    for n in range(begin, end):
        row = rows[n]
        px, py = segments[row, 0] - x, segments[row, 1] - y
        qx, qy = segments[row, 2] - x, segments[row, 3] - y
        walls[0, count], walls[1, count] = c * px + s * py, c * py - s * px
        walls[2, count], walls[3, count] = c * qx + s * qy, c * qy - s * qx
        new = (seen[row] < stamp) & (max(walls[0, count], walls[2, count]) >= behind)
        seen[row] = max(seen[row], stamp)
        count += 1 if new else 0
    return count


@compiled
def _aim_walls(count: int, last: int, step: float, walls: Array, ends: Ints) -> None:
    """Find line (a, b) and beams low..high of each listed wall, as ``_draw`` does.

    ``ends`` says in its third row whether the wall is clear: -1 if it needs ``_draw``, 1 if it
    lies across the seam. Without branches, so that it is vectorised.
    """
    per_step, middle = 1.0 / step, 0.5 * last
    margin = ANGLE_ERROR * per_step
    for n in range(np.uint64(count)):
        px, py, qx, qy = walls[0, n], walls[1, n], walls[2, n], walls[3, n]
        sx, sy = qx - px, qy - py
        c = px * sy - py * sx
        clear = c * c > SLACK * SLACK * (sx * sx + sy * sy)
        walls[4, n], walls[5, n] = sy / c, -sx / c
        turned = c < 0.0
        px, qx = qx if turned else px, px if turned else qx
        py, qy = qy if turned else py, py if turned else qy
        f, g = _angle(px, py) * per_step + middle, _angle(qx, qy) * per_step + middle
        low = math.ceil(min(max(0.0, f - margin), last + 1.0))
        high = math.floor(max(-1.0, min(1.0 * last, g + margin)))
        clear &= (low > min(f + margin, 1.0 * last)) & (high < max(g - margin, 0.0))
        seam = 1 if (py >= 0.0) & (qy < 0.0) else 0
        ends[0, n], ends[1, n], ends[2, n] = low, high, seam if clear else -1


@compiled
def _draw_walls(
    count: int, fan: Array, last: int, step: float, walls: Array, ends: Ints, inverse: Array
) -> None:
    """Draw the listed walls."""
    _aim_walls(count, last, step, walls, ends)
    for n in range(count):
        if ends[2, n] == 0:
            _paint(ends[0, n], ends[1, n], walls[4, n], walls[5, n], fan, inverse)
        else:  # Across the seam, edge-on, or an end within the error of a beam's angle.
            px, py, qx, qy = walls[0, n], walls[1, n], walls[2, n], walls[3, n]
            _draw(px, py, qx, qy, fan, last, step, inverse)


@compiled
def _list_ring(
    ring: int, column: int, line: int, columns: int, lines: int, first: Ints, cells: Ints
) -> int:
    """List the cells of a ring that hold walls; answer how many."""
    count = 0
    for j in range(max(line - ring, 0), min(line + ring, lines - 1) + 1):
        # A ring's first and last lines are whole; of the others it has the two ends.
        left, right, hop = column - ring, column + ring, max(2 * ring, 1)
        if abs(j - line) == ring:
            left, right, hop = max(left, 0), min(right, columns - 1), 1
        for i in range(left, right + 1, hop):
            if 0 <= i < columns:
                k = j * columns + i
                cells[0, count], cells[1, count], cells[2, count] = k, i, j
                count += 1 if first[k] < first[k + 1] else 0
    return count


@compiled
def _find_beams(
    count: int, gx: float, gy: float, cell: float, c: float, s: float, step: float, last: int,
    cells: Ints, beams: Ints, near: Array,
) -> None:  # fmt: skip
    """Which beams may enter the listed cells, and how near these are to the laser.

    Written are beams low..high and 0..over. Without branches, so that it is vectorised.
    """
    per_step, middle = 1.0 / step, 0.5 * last
    for n in range(np.uint64(count)):
        mx, my = (cells[1, n] + 0.5) * cell - gx, (cells[2, n] + 0.5) * cell - gy
        distance = math.sqrt(mx * mx + my * my)
        angle = _angle(c * mx + s * my, c * my - s * mx)
        # The circle round the cell; asin(z) < 1.05 z from 1.5 cells away.
        half = 1.05 * math.sqrt(0.5) * cell / max(distance, cell) + ANGLE_ERROR
        half = half if distance > 1.5 * cell else math.tau  # From near by, any.
        low, high = angle - half, angle + half
        across = (low < -math.pi) | (high > math.pi)  # The seam behind the fan.
        high = high + math.tau if low < -math.pi else high
        low = low + math.tau if low < -math.pi else low
        over = min((high - math.tau) * per_step + middle, 1.0 * last)
        low = min(max(low * per_step + middle, 0.0), last + 1.0)
        high = max(min(high * per_step + middle, 1.0 * last), -1.0)
        beams[0, n], beams[1, n] = math.ceil(low), math.floor(high)
        beams[2, n] = math.floor(max(over, -1.0)) if across else -1
        dx, dy = max(abs(mx) - 0.5 * cell, 0.0), max(abs(my) - 0.5 * cell, 0.0)
        near[n] = max(math.sqrt(dx * dx + dy * dy) - CELL_MARGIN, 0.0)


@compiled
def _reach(x: float, y: float, ring: int, cell: float, columns: int, lines: int) -> float:
    """How far a laser at (x, y) of the grid has seen, the rings before ``ring`` walked [m]."""
    column, line = math.floor(x / cell), math.floor(y / cell)
    reach = math.inf  # Where no grid lies beyond the walked square.
    if column - ring >= 0:
        reach = min(reach, x - (column - ring + 1) * cell)
    if column + ring < columns:
        reach = min(reach, (column + ring) * cell - x)
    if line - ring >= 0:
        reach = min(reach, y - (line - ring + 1) * cell)
    if line + ring < lines:
        reach = min(reach, (line + ring) * cell - y)
    return max(reach, 0.0)


@compiled
def _open(low: int, high: int, reach: float, inverse: Array) -> bool:
    """Whether one of the beams low..high, if any, or of their blocks reaches so far."""
    count = 0
    for i in range(np.uint64(low // LANES * LANES), np.uint64((high // LANES + 1) * LANES)):
        count += 1 if inverse[i] * reach < 1.0 else 0
    return count > 0


@compiled
def _invert(inverse: Array, last: int, range_max: float) -> Array:
    """Ranges of beams 0..last; exactly ``range_max`` where nothing nearer was drawn."""
    ranges = np.empty(last + 1)
    for i in range(np.uint64(last + 1)):
        v = inverse[i]
        ranges[i] = min(1.0 / v, range_max) if v > 1.0 / range_max else range_max
    return ranges


@compiled
def cast_rays(
    segments: Array,
    first: Ints,
    rows: Ints,
    seen: Ints,
    stamp: int,
    grid: Array,
    columns: int,
    lines: int,
    fan: Array,
    last: int,
    step: float,
    range_max: float,
    x: float,
    y: float,
    heading: float,
) -> Array:
    """Exact ranges (beams,) of a fan whose middle points along ``heading``; see RayCaster."""
    inverse = np.full(fan.shape[1], 1.0 / range_max)
    for b in range(last + 1, len(inverse)):
        inverse[b] = math.inf
    most = int(min(8.0 * (range_max / grid[2] + 2.0), 2.0 * (columns + lines))) + 1
    cells, beams = np.empty((3, most), dtype=np.int64), np.empty((3, most), dtype=np.int64)
    near = np.empty(most)
    walls, ends, listed = np.empty((6, LISTED)), np.empty((3, LISTED), dtype=np.int64), 0
    c, s = math.cos(heading), math.sin(heading)
    behind = -SLACK if last * step <= math.pi else -math.inf  # What is further back is not seen.
    cell, gx, gy = grid[2], x - grid[0], y - grid[1]
    column, line = math.floor(gx / cell), math.floor(gy / cell)
    ring = max(0, -column, column - columns + 1, -line, line - lines + 1)
    reach = _reach(gx, gy, ring, cell, columns, lines)
    while reach < range_max and _open(0, last, reach, inverse):
        count = _list_ring(ring, column, line, columns, lines, first, cells)
        _find_beams(count, gx, gy, cell, c, s, step, last, cells, beams, near)
        for m in range(count):
            if not _open(beams[0, m], beams[1, m], near[m], inverse) and (
                beams[2, m] < 0 or not _open(0, beams[2, m], near[m], inverse)
            ):
                continue
            n = first[cells[0, m]]
            while n < first[cells[0, m] + 1]:
                if listed > LISTED // 2:
                    _draw_walls(listed, fan, last, step, walls, ends, inverse)
                    listed = 0
                end = min(first[cells[0, m] + 1], n + LISTED - listed)
                listed = _list_walls(
                    n, end, listed, c, s, x, y, behind, segments, rows, seen, stamp, walls
                )
                n = end
        _draw_walls(listed, fan, last, step, walls, ends, inverse)
        listed = 0
        ring += 1
        reach = _reach(gx, gy, ring, cell, columns, lines)
    return _invert(inverse, last, range_max)
