"""Algorithm 1 as the text has it: each view anew, without memory (thesis 3.3).

Reached by ``Params.literal()`` alone, so that what our departures are worth can be measured.
"""

from __future__ import annotations

import numpy as np

from agents.cogmap.bounded_space import Openings
from agents.cogmap.driving import Action, turn
from agents.cogmap.memory import Memory
from agents.cogmap.navigator import clear_distance
from agents.cogmap.params import Params
from cogmap_gym.geometry import Points, lengths
from cogmap_gym.observation import RobotSpec


def wander(memory: Memory, seen: Openings, robot: RobotSpec, params: Params) -> Action:
    """Algorithm 1: autonomous exploration.

    Args:
        memory: for the points not to run into.
        seen: gaps and exits of the present view, in the robot's frame (steps 1 and 2).
        robot: limits of a move.
        params: distances.
    """
    # Step 3: the exit furthest away, else the gap directly in front or the largest
    target = _select(seen)
    if target is None:  # "instructed to rotate backward and re-scan the environment"
        return turn(robot.max_turn, robot)
    # Step 4
    return straight(memory, target, robot, params)


def straight(memory: Memory, target: Points, robot: RobotSpec, params: Params) -> Action:
    """Towards a point (2,) in the robot's frame in a straight line, up to the first obstacle."""
    bearing = float(np.arctan2(target[1], target[0]))
    if abs(bearing) > robot.max_turn:
        return turn(bearing, robot)
    points = memory.pose.inverse().apply(memory.obstacles)
    free = clear_distance(points, bearing, robot.radius + params.navigation.margin, np.inf)
    forward = min(float(np.hypot(*target)), free - params.navigation.stop_margin)
    if forward < params.navigation.min_drive:
        return turn(robot.max_turn, robot)
    return robot.move(bearing, min(forward, robot.max_forward))


def _select(seen: Openings) -> Points | None:
    """The middle (2,) of the exit or gap to go for, in the robot's frame."""
    if len(seen.exits):
        middles = seen.exits.mean(axis=1)
        return np.asarray(middles[int(np.hypot(middles[:, 0], middles[:, 1]).argmax())])
    if not len(seen.gaps):
        return None
    right, left = seen.gaps[:, 0], seen.gaps[:, 1]
    ahead = (np.arctan2(right[:, 1], right[:, 0]) <= 0.0) & (
        np.arctan2(left[:, 1], left[:, 0]) >= 0.0
    )
    row = int(np.flatnonzero(ahead)[0]) if ahead.any() else int(lengths(seen.gaps).argmax())
    return np.asarray(seen.gaps[row].mean(axis=0))
