"""The compiled twin of ``cogmap_gym.body``: how a disc moves among segments.

It leaps and takes physics sub-steps by the rules of ``body``, and in a sub-step it does what
pymunk's solver does with a disc that cannot turn and segments that stand still: Gauss-Seidel
over the contacts, warm-started with the impulses of the last sub-step, overlap pushed apart
by a velocity of its own. tests/test_disc_kernel.py holds it against the pymunk world.
"""

from __future__ import annotations

import math
from typing import Final

from cogmap_gym.body import (
    LEAP_MARGIN_M,
    MIN_LEAP_M,
    MIN_SPEED_SHARE,
    SLOP_M,
    SUBSTEP_S,
    TINY_M,
    VELOCITY_SUBSTEPS,
)
from cogmap_gym.geometry import Array
from cogmap_gym.kernel_parts import part
from cogmap_gym.raycast_kernel import Ints

ITERATIONS: Final = 10
"""Of the solver in a sub-step. pymunk's default."""
OVERLAP_LEFT: Final = 0.9**60
"""Share of an overlap that is left after a second. pymunk's default."""
PERSISTENCE: Final = 3
"""A contact that is back after so many sub-steps remembers its impulse. pymunk's default."""
DRIFT_M: Final = 0.05
"""The solver never pushes a disc this much farther than it was to drive [m]. Ours."""
MOST_POINTS: Final = 4096
"""Points of a way that are kept, the last one always [-]. Ours: seven times what 3 m take."""
X, Y, HEADING, TURNED, DRIVEN, BUMP, POINTS = range(7)
"""What ``move_disc`` and ``drive_disc`` write into ``out``."""
NEAR: Final = 11
"""Columns of ``near``: the segment (4), impulse, sub-step of the last contact, normal (2), bias,
the row of the contact of this place in the list, impulse of the bias."""


@part
def gather(
    x: float, y: float, reach: float,
    segments: Array, first: Ints, rows: Ints, seen: Ints, stamp: int,
    grid: Array, columns: int, lines: int, near: Array,
) -> int:  # fmt: skip
    """Copy the solid segments within ``reach`` [m] of (x, y) to ``near``; answer how many.

    Rows whose ``seen`` is not below ``stamp`` are passed over, as in ``cast_rays``.
    """
    cell, gx, gy = grid[2], x - grid[0], y - grid[1]
    count = 0
    low, high = math.floor((gy - reach) / cell), math.floor((gy + reach) / cell)
    left, right = math.floor((gx - reach) / cell), math.floor((gx + reach) / cell)
    for line in range(max(low, 0), min(high, lines - 1) + 1):
        for column in range(max(left, 0), min(right, columns - 1) + 1):
            k = line * columns + column
            for n in range(first[k], first[k + 1]):
                row = rows[n]
                if seen[row] >= stamp:
                    continue
                seen[row] = stamp
                px, py, qx, qy = segments[row]
                if _squared_gap(x, y, px, py, qx, qy) <= reach * reach:
                    near[count, 0], near[count, 1], near[count, 2], near[count, 3] = px, py, qx, qy
                    near[count, 4] = 0.0
                    near[count, 5] = -PERSISTENCE - 1.0
                    count += 1
    return count


@part
def _squared_gap(x: float, y: float, px: float, py: float, qx: float, qy: float) -> float:
    """Squared distance from (x, y) to the segment from p to q [m^2]."""
    dx, dy = qx - px, qy - py
    t = min(max(((x - px) * dx + (y - py) * dy) / (dx * dx + dy * dy), 0.0), 1.0)
    ex, ey = px + t * dx - x, py + t * dy - y
    return ex * ex + ey * ey


@part
def gap_to(x: float, y: float, near: Array, count: int) -> float:
    """Distance from (x, y) to the nearest of the first ``count`` of ``near`` [m]."""
    squared = math.inf
    for k in range(count):
        squared = min(squared, _squared_gap(x, y, near[k, 0], near[k, 1], near[k, 2], near[k, 3]))
    return math.sqrt(squared)


@part
def _touch(x: float, y: float, radius: float, dt: float, near: Array, count: int, now: int) -> int:
    """Find the contacts of a disc at (x, y); answer how many, listed first in column 9."""
    touching = 0
    for k in range(count):
        px, py, qx, qy = near[k, 0], near[k, 1], near[k, 2], near[k, 3]
        if _squared_gap(x, y, px, py, qx, qy) >= radius * radius:
            continue
        dx, dy = qx - px, qy - py
        t = min(max(((x - px) * dx + (y - py) * dy) / (dx * dx + dy * dy), 0.0), 1.0)
        nx, ny = px + t * dx - x, py + t * dy - y
        gap = math.sqrt(nx * nx + ny * ny)
        near[k, 6], near[k, 7] = (nx / gap, ny / gap) if gap > 0.0 else (0.0, 0.0)
        share = 1.0 - OVERLAP_LEFT**dt
        near[k, 8] = -share * min(0.0, gap - radius + SLOP_M) / dt
        if now - near[k, 5] > PERSISTENCE:
            near[k, 4] = 0.0
        near[touching, 9] = k
        touching += 1
    return touching


@part
def _solve(
    ux: float, uy: float, warm: float, near: Array, touching: int, now: int, out: Array
) -> None:
    """Velocities of a disc commanded (ux, uy) [m/s] against its contacts, into ``out``.

    ``out``: the velocity, then the velocity that parts what overlaps.
    """
    vx, vy, bx, by = ux, uy, 0.0, 0.0
    for c in range(touching):
        k = int(near[c, 9])
        if now - near[k, 5] == 1.0:
            vx -= near[k, 6] * near[k, 4] * warm
            vy -= near[k, 7] * near[k, 4] * warm
        near[k, 5] = now
        near[k, 10] = 0.0
    for _ in range(ITERATIONS):
        for c in range(touching):
            k = int(near[c, 9])
            nx, ny = near[k, 6], near[k, 7]
            old = near[k, 10]
            near[k, 10] = max(old + near[k, 8] + bx * nx + by * ny, 0.0)
            bx -= (near[k, 10] - old) * nx
            by -= (near[k, 10] - old) * ny
            old = near[k, 4]
            near[k, 4] = max(old + vx * nx + vy * ny, 0.0)
            vx -= (near[k, 4] - old) * nx
            vy -= (near[k, 4] - old) * ny
    out[0], out[1], out[2], out[3] = vx, vy, bx, by


@part
def _advance(
    heading: float, distance: float, speed: float, radius: float,
    near: Array, count: int, velocity: Array, path: Array, out: Array,
) -> None:  # fmt: skip
    """Drive along ``heading`` from where ``out`` says; see ``Body._advance``."""
    sign = math.copysign(1.0, distance)
    ux, uy = sign * math.cos(heading), sign * math.sin(heading)
    left, touching, opposed = abs(distance), False, False
    x, y, now, last_dt = out[X], out[Y], 0, 0.0
    while left > TINY_M and not opposed:
        leap = min(left, gap_to(x, y, near, count) - radius - LEAP_MARGIN_M)
        if leap >= min(left, MIN_LEAP_M):
            x, y = x + leap * ux, y + leap * uy
            left, touching = left - leap, False
        else:
            dt = min(SUBSTEP_S, left / speed)
            now += 1
            if touching:
                x, y = x + (velocity[0] + velocity[2]) * dt, y + (velocity[1] + velocity[3]) * dt
                left -= speed * dt
            else:
                now += PERSISTENCE + 1
            contacts = _touch(x, y, radius, dt, near, count, now)
            warm = dt / last_dt if last_dt > 0.0 else 0.0
            _solve(speed * ux, speed * uy, warm, near, contacts, now, velocity)
            opposed = velocity[0] * ux + velocity[1] * uy < MIN_SPEED_SHARE * speed
            touching, last_dt = True, dt
        points = int(min(out[POINTS], MOST_POINTS - 1.0))
        path[points, 0], path[points, 1] = x, y
        out[POINTS] = points + 1.0
    out[DRIVEN] += sign * ((x - out[X]) * ux + (y - out[Y]) * uy)
    out[X], out[Y], out[BUMP] = x, y, 1.0 if opposed else 0.0
    for k in range(count):
        near[k, 5] = -PERSISTENCE - 1.0


@part
def wrapped(angle: float) -> float:
    """An angle brought into (-pi, pi] as ``geometry.wrap_angle`` does."""
    return math.pi - (math.pi - angle) % math.tau


@part
def move_disc(
    turn: float, forward: float, speed: float, radius: float,
    near: Array, count: int, velocity: Array, path: Array, out: Array,
) -> None:  # fmt: skip
    """Turn in place by ``turn`` [rad], then drive ``forward`` [m] or up to contact.

    Args:
        turn: [rad].
        forward: [m].
        speed: of the drive, which matters in contact alone [m/s].
        radius: of the disc [m].
        near: (K, 11), what ``gather`` found.
        count: how many of its rows.
        velocity: (4,), scratch.
        path: (MOST_POINTS, 2), where the centre went.
        out: (7,), the pose before, then after; the rest is written.
    """
    out[HEADING] = wrapped(out[HEADING] + turn)
    path[0, 0], path[0, 1] = out[X], out[Y]
    out[TURNED], out[DRIVEN], out[BUMP], out[POINTS] = turn, 0.0, 0.0, 1.0
    _advance(out[HEADING], forward, speed, radius, near, count, velocity, path, out)


@part
def drive_disc(
    v: float, omega: float, seconds: float, speed: float, radius: float,
    near: Array, count: int, velocity: Array, path: Array, out: Array,
) -> None:  # fmt: skip
    """Drive at ``v`` [m/s] turning at ``omega`` [rad/s] for ``seconds``; see ``move_disc``."""
    dt = seconds / VELOCITY_SUBSTEPS
    path[0, 0], path[0, 1] = out[X], out[Y]
    out[TURNED], out[DRIVEN], out[BUMP], out[POINTS] = 0.0, 0.0, 0.0, 1.0
    turned = 0.0
    while turned < VELOCITY_SUBSTEPS and out[BUMP] == 0.0:
        middle = out[HEADING] + 0.5 * omega * dt
        _advance(middle, v * dt, speed, radius, near, count, velocity, path, out)
        out[HEADING] = wrapped(out[HEADING] + omega * dt)
        turned += 1.0
    out[TURNED] = turned * omega * dt
