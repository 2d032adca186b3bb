"""The wall follower: a wall at the right hand, and after each round one at the other hand.

It keeps no map but the hits of its last views, so that it knows what it has just passed. It
counts its motion: a round is over where it believes to be back at its beginning; it then
crosses over and follows what is there with the other hand, since what it has not seen lies on
the other side. A mark that it believes near and in free sight it makes straight for.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Points, Pose, wrap_angle
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

MARGIN = 0.07
"""Kept between the body and the wall [m]; a door of 0.8 m leaves it 0.08 m at each side."""
REMEMBERED = 12
"""How many views the robot remembers the hits of [1]."""
WITHIN = 4.0
"""Hits farther away are not remembered [m]."""
LOOK = 0.08
"""From one spot on the way to the next at which the wall is looked for [m]."""
STRIDE = 0.75
"""Longest drive without a wall at the hand [m]."""
ASTRAY = 4
"""After so many drives straight towards the hand there is no wall there [1]."""
OPEN = 0.7
"""The wall has ended where the direction of the hand is as free as this [m]."""
FREE = 0.45
"""A direction as free as this may be taken [m]."""
DIRECTIONS = np.radians(np.arange(-90.0, 181.0, 5.0))
"""Directions compared, from the wall's side on, against that of the last drive [rad]."""
SHORT = 0.02
"""A drive shorter than this has no direction [m]."""
ROUND, BACK = 7.0, 0.7
"""A round is at least so long, and ends so near to where it began [m]; a pillar's is 8 m."""
ALIKE = math.radians(45.0)
"""And with a heading so much alike [rad]."""
LONGEST_ROUND = 150.0
"""After this much wall the hands are changed in any case: counted motion drifts [m]."""
NEAR, ARRIVED = 4.0, 0.3
"""A mark believed as near as this is made for, if in free sight; and is declared [m]."""


class WallFollowerAgent:
    """A wall follower behind the agent protocol."""

    def __init__(self) -> None:
        """It has no parameters."""
        self.reset(RobotSpec(), LaserSpec())

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing."""
        self.robot, self.laser = robot, laser
        self.pose, self.status = Pose(), "exploring"
        self.marks: dict[int, Points] = {}
        self.views: list[Points] = []
        self.hand, self.following, self.to_turn = 1.0, False, 0.0
        self.trail: list[tuple[float, Pose]] = []
        self.driven, self.way, self.astray = 0.0, 0.0, 0

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Count the motion, remember hits and marks, and go along the wall."""
        moved = Pose(*(float(v) for v in observation["odometry"]))
        length = math.hypot(moved.x, moved.y)
        self.pose, self.driven = self.pose @ moved, self.driven + length
        if length > SHORT:
            self.way = self.pose.theta
            self.trail.append((self.driven, self.pose))
        view = hits_in_robot(observation["scan"], self.laser)
        near = view[np.hypot(view[:, 0], view[:, 1]) < WITHIN]
        older = [moved.inverse().apply(hits) for hits in self.views[-REMEMBERED:]]
        self.views = [*older, near]
        hits = np.concatenate(self.views)
        if observation["mark"]:
            self.marks.setdefault(int(observation["mark"]), self.pose.position)
        goal = self.marks.get(int(observation["goal"]))
        self.status = "exploring" if goal is None else "going to a mark"
        if goal is not None:
            there = self.pose.inverse().apply(goal)
            distance, turn = float(np.hypot(*there)), math.atan2(there[1], there[0])
            if distance < ARRIVED:
                return self.robot.declare()
            if self._is_in_sight(hits, turn, distance):
                return self._towards(turn, distance)
        return self._along(hits)

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

    def _is_in_sight(self, hits: Points, turn: float, distance: float) -> bool:
        """Whether a spot lies before the robot, near, with nothing on the way."""
        body = self.robot.radius + MARGIN / 2.0
        ahead = abs(turn) < math.pi / 2.0 and distance < NEAR
        return ahead and free_way(hits, turn, body) > distance

    def _along(self, hits: Points) -> NDArray[np.float32]:
        """One step along the wall, or towards one."""
        body = self.robot.radius + MARGIN
        if self.to_turn != 0.0:
            return self._towards(self.to_turn, 0.0)
        if self.following and self._is_round():
            self.following, self.hand = False, -self.hand
            return self._towards(-self.hand * math.pi / 2.0, 0.0)
        if not self.following:
            ahead = free_way(hits, 0.0, body)
            if ahead > FREE:
                return self._towards(0.0, min(ahead, self.robot.max_forward))
            self.following, self.trail, self.driven = True, [], 0.0
            self.way = self.pose.theta - self.hand * float(DIRECTIONS[0])
        for row, direction in enumerate(self.way - self.pose.theta + self.hand * DIRECTIONS):
            turn = wrap_angle(float(direction))
            free = free_way(hits, turn, body)
            if free > FREE:
                drive = abs(turn) <= self.robot.max_turn
                self.astray = (self.astray + drive) if row == 0 else 0
                self.following = self.astray < ASTRAY
                return self._towards(turn, self._until_open(hits, turn, free))
        return self._towards(self.hand * self.robot.max_turn, 0.0)

    def _until_open(self, hits: Points, turn: float, free: float) -> float:
        """How far to drive in a free direction: along the wall at the hand up to its end [m]."""
        far, beside_wall = min(free, self.robot.max_forward), False
        along = Pose(0.0, 0.0, turn).inverse().apply(hits)
        for driven in np.arange(LOOK, far, LOOK):
            beside = along - (driven, 0.0)
            side = free_way(beside, -self.hand * math.pi / 2.0, self.robot.radius + MARGIN)
            if side > OPEN and beside_wall:
                return float(driven)
            beside_wall |= side <= OPEN
        return far if beside_wall else min(far, STRIDE)

    def _is_round(self) -> bool:
        """Whether the wall has led back to where the robot followed it before."""
        older = [pose for driven, pose in self.trail if self.driven - driven > ROUND]
        return self.driven > LONGEST_ROUND or any(
            self.pose.distance(pose) < BACK
            and abs(wrap_angle(self.pose.theta - pose.theta)) < ALIKE
            for pose in older
        )

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
