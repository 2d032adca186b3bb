"""Wrappers that change what an action means."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from cogmap_gym.actions import DECLARED, checked, turn_and_forward
from cogmap_gym.geometry import Pose, wrap_angle
from cogmap_gym.observation import Observation, RobotSpec
from cogmap_gym.sensors import odometry_bound, odometry_reading

TURNED_RAD = math.radians(0.5)
"""A turn is done once it lacks no more than this [rad]. Ours: the noise of one step."""
DRIVEN_M = 0.01
"""A drive is done once it lacks no more than this [m]. Ours: the noise of one step."""
SPARE_STEPS = 10
"""Steps beyond twice the shortest number after which a move ends at any rate. Ours."""

Outcome = tuple[Observation, float, bool, bool, dict[str, Any]]
"""What ``step`` returns."""


class MoveControl(gym.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Lets a robot that makes moves drive an environment with ``control="velocity"``.

    A move turns and then drives by velocity steps until the *measured* odometry says that
    it is done; while it drives it holds the measured heading. It ends before that at once
    that there is something to decide: contact, a mark, another goal, the episode's end. A
    robot so learns of a mark where it stands on it. The observation is that of the last
    step, with the odometry of the whole move; rewards are summed, ``info["events"]``
    joined. What an outer wrapper or an agent gets as ``robot`` has ``control="move"``.

    | | before | after |
    |---|---|---|
    | action | (v, omega, declare) for 0.1 s | (turn, drive, declare), a move |
    | ``odometry`` | Box float32 (3,), bounds of a velocity step | the same, bounds of a move |

    A step of the environment is still 0.1 s: limits, budgets and the reward of -0.01 count
    these. Put this wrapper under all that look at odometry or stack observations.

    Args:
        env: a CogMap environment with ``control="velocity"``.

    Raises:
        ValueError: the environment has another control.
    """

    def __init__(self, env: gym.Env[Observation, Any]) -> None:
        """Widen the bounds of the odometry."""
        RecordConstructorArgs.__init__(self)
        gym.Wrapper.__init__(self, env)
        self._by_velocity: RobotSpec = env.get_wrapper_attr("robot")
        if self._by_velocity.control != "velocity":
            raise ValueError(
                f"MoveControl: expected control 'velocity', got {self._by_velocity.control!r}"
            )
        self.robot = replace(self._by_velocity, control="move")
        """The robot as one that makes moves."""
        odometry = env.get_wrapper_attr("odometry")
        bounds = (odometry_bound(robot, odometry) for robot in (self.robot, self._by_velocity))
        x, y, theta = (move + step for move, step in zip(*bounds, strict=True))
        self._bound = x, y, min(theta, math.pi)
        high = np.array(self._bound, dtype=np.float32)
        assert isinstance(env.observation_space, spaces.Dict), "CogMap environments use a Dict"
        box = spaces.Box(-high, high, (3,), np.float32)
        self.observation_space = spaces.Dict({**env.observation_space.spaces, "odometry": box})
        self.action_space = self.robot.action_space
        self._goal = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._goal = int(observation["goal"])
        return observation, info

    def step(self, action: NDArray[np.float32]) -> Outcome:
        """Make one move, or declare.

        Raises:
            ValueError: an action of another shape than (3,), or with NaN in it.
        """
        first, second, third = checked(action)
        if third > DECLARED:
            outcome = self._take(self._by_velocity.declare())
        else:
            outcome = self._move(*turn_and_forward(self.robot, first, second))
        self._goal = int(outcome[0]["goal"])
        return outcome

    def _take(self, action: NDArray[np.float32]) -> Outcome:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, float(reward), terminated, truncated, info

    def _move(self, turn: float, forward: float) -> Outcome:
        """Step until the measured motion is a turn [rad] and then a drive [m]."""
        robot = self._by_velocity
        start_from_robot, reward, events, turning = Pose(), 0.0, (), True
        for _ in range(self._most_steps(turn, forward)):
            left = wrap_angle(turn - start_from_robot.theta)
            turning = turning and abs(left) > TURNED_RAD
            along = forward - _along(start_from_robot, turn)
            v = 0.0 if turning else along / robot.velocity_step
            observation, more, *ends, info = self._take(
                robot.velocity(v, left / robot.velocity_step)
            )
            start_from_robot @= Pose(*map(float, observation["odometry"]))
            reward, events = reward + more, (*events, *info["events"])
            left = wrap_angle(turn - start_from_robot.theta)
            driven = forward - _along(start_from_robot, turn) <= DRIVEN_M
            calls = observation["bump"] or observation["mark"] or observation["goal"] != self._goal
            if any(ends) or calls or (driven and not (turning and abs(left) > TURNED_RAD)):
                break
        reading = odometry_reading(start_from_robot, self._bound)
        told = {**observation, "odometry": reading}
        return told, reward, ends[0], ends[1], {**info, "events": events}

    def _most_steps(self, turn: float, forward: float) -> int:
        robot = self._by_velocity
        seconds = abs(turn) / robot.max_turn_rate + forward / robot.max_speed
        return 2 * math.ceil(seconds / robot.velocity_step) + SPARE_STEPS


class DiscreteControl(gym.ActionWrapper[Observation, Any, Any], RecordConstructorArgs):
    """Four actions: turn left, turn right, drive forward, declare.

    | | before | after |
    |---|---|---|
    | action | Box float32 (3,) | Discrete(4): 0 left, 1 right, 2 forward, 3 "I am there" |

    It needs moves: a velocity step is 0.1 s, too short for half a metre. For
    ``control="velocity"`` put ``MoveControl`` beneath it.

    Args:
        env: a CogMap environment with ``control="move"``, or ``MoveControl``.
        turn: of actions 0 and 1 [rad].
        forward: of action 2 [m].

    Raises:
        ValueError: another control, or more than the robot can do in one move.
    """

    def __init__(
        self,
        env: gym.Env[Observation, Any],
        turn: float = math.radians(15.0),
        forward: float = 0.5,
    ) -> None:
        """Tabulate the four actions."""
        RecordConstructorArgs.__init__(self, turn=turn, forward=forward)
        gym.ActionWrapper.__init__(self, env)
        robot: RobotSpec = env.get_wrapper_attr("robot")
        if robot.control != "move":
            raise ValueError(
                f"DiscreteControl: expected control 'move', got {robot.control!r}: "
                "put MoveControl beneath it"
            )
        for name, value, most in (
            ("turn", turn, robot.max_turn),
            ("forward", forward, robot.max_forward),
        ):
            if not 0.0 < value <= most:
                raise ValueError(
                    f"DiscreteControl: {name}: expected above 0, at most {most}, got {value!r}"
                )
        self.action_space = spaces.Discrete(4)
        self._actions = (
            robot.move(turn, 0.0),
            robot.move(-turn, 0.0),
            robot.move(0.0, forward),
            robot.declare(),
        )

    def action(self, action: Any) -> NDArray[np.float32]:
        """The move that a number stands for.

        Raises:
            ValueError: not one of 0, 1, 2, 3.
        """
        if not self.action_space.contains(action):
            raise ValueError(f"action: expected 0, 1, 2 or 3, got {action!r}")
        return self._actions[int(action)].copy()


def _along(start_from_robot: Pose, heading: float) -> float:
    """How far the robot is from the start along a heading [m]."""
    return start_from_robot.x * math.cos(heading) + start_from_robot.y * math.sin(heading)
