"""Moves along a way: the grid proposes, the laser disposes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.frontier import params
from agents.frontier.scans import free_way
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import RobotSpec


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """What to do next."""

    action: NDArray[np.float32]
    """For the environment."""
    blocked: bool = False
    """Whether the laser sees something where the way leads."""


def move_towards(
    point: Points,
    robot_pose: Pose,
    hits: Points,
    robot: RobotSpec,
    numbers: params.Driver,
    longest: float,
) -> Move:
    """Turn towards a point, and drive to it once it lies ahead.

    Args:
        point: (2,) in the frame of the pose [m].
        robot_pose: where the robot is.
        hits: (H, 2) what the laser sees, in the robot's frame [m].
        robot: its size, and how far one move takes it.
        numbers: of the driver.
        longest: drive that is wanted [m].
    """
    there = robot_pose.inverse().apply(point)
    turn, distance = math.atan2(there[1], there[0]), float(np.hypot(*there))
    if abs(turn) > robot.max_turn:
        return Move(robot.move(math.copysign(robot.max_turn, turn), 0.0))
    body = robot.radius + numbers.clearance
    free = free_way(hits, turn, body)
    drive = min(distance, free, longest, robot.max_forward)
    if drive < min(numbers.stop, distance):
        return Move(robot.move(turn, 0.0), blocked=True)
    return Move(robot.move(turn, drive))
