"""The rooms a robot has truly been in, in order."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose, point_segment_distances

ENTERED_M = 0.3
"""A room is entered once the centre is this far from every door [m]. Ours: over a radius."""
TRAIL_STEP_M = 0.2
"""The way of a move is looked at in steps of this length at most [m]. Ours."""


class Trail:
    """The rooms visited since some moment, each new one once the robot is clearly inside."""

    def __init__(self, plan: FloorPlan, pose: Pose) -> None:
        """Begin in the room that holds ``pose``."""
        self._plan = plan
        self._doors = plan.door_segments()
        room = plan.room_at(pose.x, pose.y)
        self.rooms: tuple[str, ...] = () if room is None else (room,)

    def follow(self, path: Points) -> None:
        """Go along a path (K, 2) [m] and note the rooms it passes."""
        if sum(math.dist(p, q) for p, q in pairwise(path.tolist())) <= TRAIL_STEP_M:
            return self._enter(*path[-1].tolist())
        steps = np.hypot(*np.diff(path, axis=0).T)
        along = np.concatenate(((0.0,), np.cumsum(steps)))
        count = max(math.ceil(along[-1] / TRAIL_STEP_M), 1)
        at = along[-1] * np.arange(1, count + 1) / count
        xs, ys = np.interp(at, along, path[:, 0]), np.interp(at, along, path[:, 1])
        for x, y in zip(xs.tolist(), ys.tolist(), strict=True):
            self._enter(x, y)
        return None

    def gap(self, point: tuple[float, float]) -> float:
        """Distance from a point to the nearest door, open or shut [m]; infinite without one."""
        if len(self._doors) == 0:
            return math.inf
        return float(point_segment_distances(np.array((point,)), self._doors).min())

    def _enter(self, x: float, y: float) -> None:
        room = self._plan.room_at(x, y)
        if room is not None and self.rooms[-1:] != (room,) and self.gap((x, y)) >= ENTERED_M:
            self.rooms = (*self.rooms, room)
