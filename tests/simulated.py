"""Scans of hand-built rooms and walls, and robots that map them: no pymunk, no environment."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np

from agents.cogmap.lines import extract_view
from agents.cogmap.mapper import Mapper
from agents.cogmap.params import Lines, Params
from agents.cogmap.view import View
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Pose, Segments
from cogmap_gym.observation import LaserSpec
from cogmap_gym.raycast import RayCaster

SYMMETRIC = LaserSpec(first_angle=-np.pi / 2, step=np.pi / 360, beams=361)
"""A fan that its mirror image maps onto itself: beam i and beam 360 - i."""


def solid(plan: FloorPlan) -> Segments:
    """All that a laser meets in a plan, doors open, (N, 2, 2)."""
    return plan.walls_and_furniture()


def scan(
    walls: Segments,
    pose: Pose,
    laser: LaserSpec = SYMMETRIC,
    rng: np.random.Generator | None = None,
) -> Array:
    """The ranges (beams,) [m] of a robot at ``pose``; exact without ``rng``."""
    ranges = RayCaster(walls).ranges(pose @ laser.robot_from_laser, laser)
    if rng is None:
        return ranges
    noisy = ranges + rng.normal(0.0, laser.sd, len(ranges))
    return np.where(ranges < laser.range_max, np.clip(noisy, 0.0, laser.range_max), ranges)


def view_of(
    walls: Segments,
    pose: Pose,
    laser: LaserSpec = SYMMETRIC,
    params: Lines | None = None,
    rng: np.random.Generator | None = None,
) -> View:
    """The view of a robot at ``pose``."""
    return extract_view(scan(walls, pose, laser, rng), laser, params or Lines())


def drive(
    walls: Segments,
    poses: Iterable[Pose],
    params: Params | None = None,
    laser: LaserSpec = SYMMETRIC,
    rng: np.random.Generator | None = None,
    turn_error: float = 0.0,
    scale_error: float = 0.0,
) -> tuple[Mapper, list[Any]]:
    """A mapper that went through ``poses`` with odometry wrong by a turn [rad] a move and a scale.

    Returns:
        The mapper, and all edits of its map in order.
    """
    mapper, edits, last = Mapper(params or Params(), laser), [], None
    for pose in poses:
        moved = Pose() if last is None else last.inverse() @ pose
        if last is not None:
            k = 1.0 + scale_error
            moved = Pose(k * moved.x, k * moved.y, moved.theta + turn_error)
        edits += mapper.observe(scan(walls, pose, laser, rng), moved)
        last = pose
    return mapper, edits


def along(points: Points, spacing: float = 0.5) -> list[Pose]:
    """Poses along a polyline (K, 2), every ``spacing`` metres; turns of 30 degrees at most."""
    poses: list[Pose] = []
    for a, b in itertools.pairwise(points):
        heading = float(np.arctan2(b[1] - a[1], b[0] - a[0]))
        if poses:
            turn = float(np.remainder(heading - poses[-1].theta + np.pi, 2 * np.pi) - np.pi)
            count = int(np.ceil(abs(turn) / np.deg2rad(30.0) - 1e-9))
            start = poses[-1].theta
            poses += [Pose(a[0], a[1], start + turn * (k + 1) / count) for k in range(count)]
        else:
            poses.append(Pose(a[0], a[1], heading))
        count = int(np.ceil(np.hypot(*(b - a)) / spacing))
        poses += [Pose(*(a + (b - a) * (k + 1) / count), heading) for k in range(count)]
    return poses


def same_rows(a: Array, b: Array, tolerance: float = 1e-6) -> bool:
    """Whether two stacks hold the same rows in any order."""
    if a.shape != b.shape:
        return False
    if len(a) == 0:
        return True
    x, y = a.reshape(len(a), -1), b.reshape(len(b), -1)
    gaps = np.abs(x[:, None] - y[None]).max(axis=-1)
    return bool((gaps.min(axis=1) < tolerance).all() and (gaps.min(axis=0) < tolerance).all())


def mirrored(segments: Segments) -> Segments:
    """Segments (N, 2, 2) mirrored left for right, free space still on the left."""
    return np.asarray(segments[:, ::-1] * np.array((1.0, -1.0)))


def segments(*ends: tuple[float, float, float, float]) -> Segments:
    """Segments (N, 2, 2) from x0, y0, x1, y1."""
    return np.array(ends, dtype=np.float64).reshape(-1, 2, 2)
