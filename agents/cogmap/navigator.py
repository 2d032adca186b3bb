"""Reaching a point without touching anything: a local grid, a path, and the next move.

The thesis leaves this to the robot's base ("take a small step at a time", 3.3); there is
no algorithm of its number here. All points of one call lie in one frame.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from agents.cogmap.local_grid import cheapest, clearance_grid, free_cells, nearest_free
from agents.cogmap.params import Navigation
from cogmap_gym.geometry import Array, Points, Segments, lengths, point_segment_distances
from cogmap_gym.observation import RobotSpec

PIONEER = RobotSpec()
"""The robot of the thesis."""


def sample_surfaces(segments: Segments, spacing: float) -> Points:
    """Points along segments, ends included, for use as obstacles.

    Args:
        segments: (N, 2, 2).
        spacing: largest distance between neighbouring points of a segment [m].

    Returns:
        (P, 2), in the frame of the segments.
    """
    counts = np.maximum(np.ceil(lengths(segments) / spacing).astype(np.int64), 1) + 1
    rows = np.repeat(np.arange(len(segments)), counts)
    first = np.cumsum(counts) - counts
    t = ((np.arange(counts.sum()) - first[rows]) / (counts[rows] - 1))[:, None]
    return np.asarray(segments[rows, 0] + t * (segments[rows, 1] - segments[rows, 0]))


def clear_distance(points: Points, heading: float, radius: float, limit: float) -> float:
    """How far a disc at the origin can drive straight before it touches a point.

    Args:
        points: (P, 2) obstacles in the robot's frame; NaN rows are no obstacles.
        heading: direction of the drive in that frame [rad].
        radius: of the disc [m].
        limit: largest answer [m].

    Returns:
        Metres, 0 to ``limit``. A point inside the disc stops only a drive towards it.
    """
    return growing_clear_distance(points, heading, radius, 0.0, limit)


def growing_clear_distance(
    points: Points, heading: float, radius: float, drift: float, limit: float
) -> float:
    """``clear_distance`` of a disc whose radius grows by ``drift`` a metre driven.

    The growth stands for not knowing how straight the drive will be.
    """
    ahead, aside = _along(points, heading)
    # Contact when (ahead - d)^2 + aside^2 = (radius + drift d)^2.
    a = 1.0 - drift**2
    b = ahead + drift * radius
    c = ahead**2 + aside**2 - radius**2
    with np.errstate(invalid="ignore"):
        discriminant = b**2 - a * c
        touch = (b - np.sqrt(discriminant)) / a
        blocks = (ahead > 0.0) & (discriminant >= 0.0)
        touch = np.where(blocks, np.maximum(np.where(c < 0.0, 0.0, touch), 0.0), limit)
    return float(touch.min(initial=limit))


def plan_path(
    obstacles: Points,
    start: Points,
    goal: Points,
    params: Navigation,
    robot: RobotSpec = PIONEER,
) -> Points | None:
    """The cheapest safe path of the disc, on a local grid round start and goal.

    Cost rises near obstacles, so the path keeps clear of them where it can. A start
    nearer to an obstacle than is safe may be left; a goal in such a place is moved to
    the nearest safe point within ``params.goal_reach``.

    Args:
        obstacles: (P, 2); NaN rows are no obstacles.
        start: (2,).
        goal: (2,).
        params: distances and weights.
        robot: its radius is used.

    Returns:
        Waypoints (K, 2), K >= 2, start first, goal (or its substitute) last; None when
        there is no route within the grid.
    """
    obstacles = obstacles[np.isfinite(obstacles).all(axis=1)]
    if _clearance_of_line(obstacles, start, goal) >= params.soft_clearance:
        return np.stack((start, goal))
    grid = clearance_grid(obstacles, start, goal, params)
    safe = robot.radius + params.margin
    free = free_cells(grid, start, safe, params)
    target = nearest_free(grid, free, goal, params)
    if target is None:
        return None
    cells = cheapest(grid, free, start, target, safe, params)
    if cells is None:
        return None
    path = grid.centres(cells)
    path[0] = start
    if np.array_equal(target, grid.cells(goal)):
        path[-1] = goal
    if len(path) < 2:
        return np.stack((start, path[-1]))
    return _pull(path, obstacles, params)


def steer(
    path: Points, points: Points, params: Navigation, robot: RobotSpec
) -> tuple[float, float]:
    """The next move along a path: towards its farthest waypoint in clear sight.

    The drive ends before anything the disc could touch if it drifted by
    ``params.drift`` sideways a metre; in the open it is as long as the robot allows.

    Args:
        path: (K, 2) in the robot's frame, in order; the robot may be past its first rows.
        points: (P, 2) obstacles in the robot's frame; NaN rows are no obstacles.
        params: margins.
        robot: limits of a move, radius.

    Returns:
        turn [rad] in [-max_turn, max_turn] and forward [m] in [0, max_forward]; when the
        waypoint needs more than ``max_turn``, a turn only.
    """
    points = points[np.isfinite(points).all(axis=1)]
    body = _body_radius(points, params, robot)
    target = _farthest_in_sight(path, points, body)
    distance = math.hypot(target[0], target[1])
    if distance == 0.0:
        return 0.0, 0.0
    heading = math.atan2(target[1], target[0])
    if abs(heading) > robot.max_turn:
        return math.copysign(robot.max_turn, heading), 0.0
    limit = min(distance, robot.max_forward)
    free = clear_distance(points, heading, body, distance + params.stop_margin)
    wary = growing_clear_distance(points, heading, body, params.drift, limit)
    forward = min(limit, free - params.stop_margin, max(wary, params.min_drive))
    return heading, max(forward, 0.0)


def _along(points: Points, heading: float) -> tuple[Array, Array]:
    c, s = math.cos(heading), math.sin(heading)
    return c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]


def _body_radius(points: Points, params: Navigation, robot: RobotSpec) -> float:
    """The radius to keep free: with its margin, or less where something is nearer already."""
    nearest = float(np.hypot(points[:, 0], points[:, 1]).min(initial=math.inf))
    wanted = robot.radius + params.margin
    return max(min(wanted, nearest - params.margin), robot.radius - params.margin)


def _farthest_in_sight(path: Points, points: Points, body: float) -> Points:
    """The last waypoint that the disc reaches by one straight drive, else the first one."""
    for target in path[:0:-1]:
        distance = math.hypot(target[0], target[1])
        heading = math.atan2(target[1], target[0])
        if clear_distance(points, heading, body, distance) >= distance:
            return np.asarray(target)
    away = path[np.hypot(path[:, 0], path[:, 1]) > body]
    return np.asarray(away[0] if len(away) else path[-1])


def _clearance_of_line(obstacles: Points, a: Points, b: Points) -> float:
    line = np.stack((a, b))[None]
    return float(point_segment_distances(obstacles, line).min(initial=math.inf))


def _pull(path: Points, obstacles: Points, params: Navigation) -> Points:
    """Keep only the waypoints that are needed: pull the path like a string.

    A stretch is replaced by a straight line that keeps as clear as the stretch did, or
    as clear as anyone could wish.
    """
    clear = np.full(len(path), math.inf)
    if len(obstacles):
        clear = np.asarray(cKDTree(obstacles).query(path)[0])
    kept, i = [0], 0
    while i < len(path) - 1:
        low, high = i + 1, len(path) - 1
        while low < high:
            middle = (low + high + 1) // 2
            wanted = min(float(clear[i : middle + 1].min()), params.soft_clearance)
            if _clearance_of_line(obstacles, path[i], path[middle]) >= wanted - params.slack:
                low = middle
            else:
                high = middle - 1
        kept.append(low)
        i = low
    return np.asarray(path[kept])
