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
def _cell_beams(x: float, y: float, cell: float, step: float, last: int) -> tuple[int, int, int]:
    """Beams low..high and 0..over may enter the cell about (x, y) of the fan frame."""
    low_angle, high_angle = -math.tau, math.tau  # From near by, any.
    distance = math.sqrt(x * x + y * y)
    if distance > 1.5 * cell:
        middle = _angle(x, y)
        # The circle round the cell; asin(z) < 1.05 z from 1.5 cells away.
        half = 1.05 * math.sqrt(0.5) * cell / distance + ANGLE_ERROR
        low_angle, high_angle = middle - half, middle + half
    over = -1.0
    if low_angle < -math.pi:
        low_angle, high_angle = low_angle + math.tau, high_angle + math.tau
    if high_angle > math.pi:  # Across the seam behind the fan.
        over = min((high_angle - math.tau) / step + 0.5 * last, 1.0 * last)
    low = min(max(low_angle / step + 0.5 * last, 0.0), last + 1.0)
    high = max(min(high_angle / step + 0.5 * last, 1.0 * last), -1.0)
    return math.ceil(low), math.floor(high), math.floor(max(over, -1.0))


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
def _find_open(reach: float, inverse: Array, open_at: Ints) -> None:
    """Set ``open_at[i]`` to the first beam from i on that may yet be shortened."""
    final = 1.0 / reach
    beams = len(open_at) - 1
    nearest = beams
    for k in range(np.uint64(1), np.uint64(beams + 1)):
        i = np.uint64(beams) - k
        nearest = beams - k if inverse[i] < final else nearest
        open_at[i] = nearest


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
    open_at = np.arange(last + 2)
    c, s = math.cos(heading), math.sin(heading)
    behind = -SLACK if last * step <= math.pi else -math.inf  # What is further back is not seen.
    cell, gx, gy = grid[2], x - grid[0], y - grid[1]
    column, line = math.floor(gx / cell), math.floor(gy / cell)
    ring = max(0, -column, column - columns + 1, -line, line - lines + 1)
    reach = _reach(gx, gy, ring, cell, columns, lines)
    while reach < range_max and open_at[0] <= last:
        for j in range(max(line - ring, 0), min(line + ring, lines - 1) + 1):
            # A ring's first and last lines are whole; of the others it has the two ends.
            left, right, hop = column - ring, column + ring, 2 * ring
            if abs(j - line) == ring:
                left, right, hop = max(left, 0), min(right, columns - 1), 1
            for i in range(left, right + 1, hop):
                if i < 0 or i >= columns:
                    continue
                k = j * columns + i
                if first[k] == first[k + 1]:
                    continue
                mx, my = (i + 0.5) * cell - gx, (j + 0.5) * cell - gy
                low, high, over = _cell_beams(c * mx + s * my, c * my - s * mx, cell, step, last)
                if open_at[low] > high and open_at[0] > over:
                    continue
                for n in range(first[k], first[k + 1]):
                    row = rows[n]
                    if seen[row] >= stamp:
                        continue
                    seen[row] = stamp
                    px, py = segments[row, 0] - x, segments[row, 1] - y
                    qx, qy = segments[row, 2] - x, segments[row, 3] - y
                    px, py = c * px + s * py, c * py - s * px
                    qx, qy = c * qx + s * qy, c * qy - s * qx
                    if max(px, qx) < behind:
                        continue
                    _draw(px, py, qx, qy, fan, last, step, inverse)
        ring += 1
        reach = _reach(gx, gy, ring, cell, columns, lines)
        _find_open(reach, inverse, open_at)
    return _invert(inverse, last, range_max)
