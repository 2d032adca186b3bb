"""The random walk: straight on where that is free, else a turn drawn from all directions.

It keeps no map. So that it can do every task at all, it counts its motion, makes straight for a
mark that it believes near and in free sight, and declares there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Points, Pose, wrap_angle
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

MARGIN = 0.1
"""Kept between the body and what is ahead [m]."""
SHORTEST = 0.4
"""Less free way than this is not driven [m]."""
SWERVE = math.radians(15.0)
"""Standard deviation of the turn before a free drive [rad]."""
NEAR, ARRIVED = 4.0, 0.3
"""A mark believed as near as this is made for, if in free sight; and is declared [m]."""


class RandomWalkAgent:
    """A random walk behind the agent protocol.

    Args:
        seed: of the walk; each ``reset`` begins the same walk anew.
    """

    def __init__(self, seed: int = 0) -> None:
        """Take the seed."""
        self._seed = seed
        self.reset(RobotSpec(), LaserSpec())

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing."""
        self.robot, self.laser = robot, laser
        self.rng = np.random.default_rng(self._seed)
        self.pose, self.to_turn, self.status = Pose(), 0.0, "exploring"
        self.marks: dict[int, Points] = {}

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Count the motion, remember a mark, and drive or turn."""
        self.pose = self.pose @ Pose(*(float(v) for v in observation["odometry"]))
        if observation["mark"]:
            self.marks.setdefault(int(observation["mark"]), self.pose.position)
        hits = hits_in_robot(observation["scan"], self.laser)
        goal = self.marks.get(int(observation["goal"]))
        self.status = "exploring" if goal is None else "going to a mark"
        if goal is not None:
            there = self.pose.inverse().apply(goal)
            distance, turn = float(np.hypot(*there)), math.atan2(there[1], there[0])
            if distance < ARRIVED:
                return self.robot.declare()
            ahead = distance < NEAR and abs(turn) < math.pi / 2.0
            if ahead and free_way(hits, turn, self.robot.radius) > distance:
                return self._towards(turn, distance)
        return self._wander(hits, bumped=bool(observation["bump"]))

    def sketch(self) -> dict[str, Any]:
        """Where it believes to be, and the marks."""
        home = self.marks.get(1)
        return {
            "surfaces": [],
            "exits": [],
            "asrs": [],
            "links": [],
            "here": 0,
            "pose": [self.pose.x, self.pose.y, self.pose.theta],
            "home": None if home is None else home.tolist(),
            "marks": [{"id": k, "point": point.tolist()} for k, point in self.marks.items()],
            "route": None,
            "status": self.status,
        }

    def _wander(self, hits: Points, *, bumped: bool) -> NDArray[np.float32]:
        """Straight on, or one piece of a drawn turn."""
        if abs(self.to_turn) > 0.0:
            return self._towards(self.to_turn, 0.0)
        turn = float(self.rng.normal(0.0, SWERVE))
        turn = float(np.clip(turn, -self.robot.max_turn, self.robot.max_turn))
        free = free_way(hits, turn, self.robot.radius) - MARGIN
        if bumped or free < SHORTEST:
            self.to_turn = float(self.rng.uniform(-math.pi, math.pi))
            return self._towards(self.to_turn, 0.0)
        return self._towards(turn, free)

    def _towards(self, turn: float, distance: float) -> NDArray[np.float32]:
        """Turn by as much as one move can; drive once that is all of the turn."""
        part = float(np.clip(turn, -self.robot.max_turn, self.robot.max_turn))
        self.to_turn = wrap_angle(turn - part) if distance <= 0.0 else 0.0
        return self.robot.move(part, distance if part == turn else 0.0)


def hits_in_robot(scan: NDArray[np.float32], laser: LaserSpec) -> Points:
    """Where the beams that returned ended, (H, 2) in the robot's frame [m]."""
    ranges = np.asarray(scan, dtype=np.float64)
    good = np.isfinite(ranges) & (ranges > 0.0) & (ranges < laser.range_max)
    angles = laser.angles[good]
    points = ranges[good, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    return laser.robot_from_laser.apply(points)


def free_way(hits: Points, turn: float, radius: float) -> float:
    """How far a disc of ``radius`` gets in the direction ``turn`` before it touches a hit [m]."""
    ahead = Pose(0.0, 0.0, -turn).apply(hits)
    ahead = ahead[(ahead[:, 0] > 0.0) & (np.abs(ahead[:, 1]) < radius)]
    if len(ahead) == 0:
        return math.inf
    return float(np.min(ahead[:, 0] - np.sqrt(radius**2 - ahead[:, 1] ** 2)))
