"""From what the network chose to an action of the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from agents.ppo.params import Moves
from cogmap_gym.observation import RobotSpec


def action_of(
    choice: Sequence[int], to_goal: tuple[float, float] | None, moves: Moves, robot: RobotSpec
) -> NDArray[np.float32]:
    """The chosen move, or the declaration where the goal is believed to be here.

    Args:
        choice: which turn and which drive.
        to_goal: distance [m] and direction [rad] of the goal as believed; None without one.
        moves: what there is to choose.
        robot: whose action it is.
    """
    if to_goal is not None and to_goal[0] < moves.arrived:
        return robot.declare()
    return robot.move(math.radians(moves.turns[choice[0]]), moves.drives[choice[1]])
