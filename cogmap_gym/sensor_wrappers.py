"""Wrappers that change what a robot is told, from scans, odometry and marks alone."""

from __future__ import annotations

from collections import deque
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import Observation

FARTHEST_GOAL_M = 1000.0
"""Bound of a coordinate of the goal vector [m]; farther goals are clipped to it."""

Env = gym.Env[Observation, Any]


class ScanSectors(gym.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Reduces the scan to sectors: the nearest return of each.

    | key | before | after |
    |---|---|---|
    | ``scan`` | Box float32 (beams,) | Box float32 (sectors,), from the right counter-clockwise |

    Args:
        env: a CogMap environment.
        sectors: how many; beams that do not share out evenly go to the later ones.

    Raises:
        ValueError: fewer than one sector, or more than beams.
    """

    def __init__(self, env: Env, sectors: int = 24) -> None:
        """Share out the beams."""
        RecordConstructorArgs.__init__(self, sectors=sectors)
        gym.ObservationWrapper.__init__(self, env)
        box = box_of(env, "scan")
        beams = box.shape[0]
        _check_count("ScanSectors: sectors", sectors, beams)
        self._first = np.arange(sectors) * beams // sectors
        self.observation_space = with_key(
            env, "scan", spaces.Box(0.0, float(box.high.max()), (sectors,), np.float32)
        )

    def observation(self, observation: Observation) -> Observation:
        """The observation with the nearest return a sector."""
        return {**observation, "scan": np.minimum.reduceat(observation["scan"], self._first)}


class StackedScans(gym.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Joins the last scans into one vector, the newest at the end.

    At the beginning of an episode the first scan stands for those before it. Gymnasium's
    ``FrameStackObservation`` stacks every key, goal and mark too, along a new axis, of
    which Stable-Baselines3's checker warns; this one keeps the scan a plain vector.

    | key | before | after |
    |---|---|---|
    | ``scan`` | Box float32 (n,) | Box float32 (count n,) |

    Args:
        env: a CogMap environment, or ``ScanSectors`` over one.
        count: how many scans.

    Raises:
        ValueError: fewer than one.
    """

    def __init__(self, env: Env, count: int = 4) -> None:
        """Widen the space."""
        RecordConstructorArgs.__init__(self, count=count)
        gym.ObservationWrapper.__init__(self, env)
        _check_count("StackedScans: count", count, None)
        box = box_of(env, "scan")
        self._scans: deque[NDArray[np.float32]] = deque(maxlen=count)
        self.observation_space = with_key(
            env, "scan", spaces.Box(np.tile(box.low, count), np.tile(box.high, count))
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, with no scan before its first."""
        self._scans.clear()
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Observation) -> Observation:
        """The observation with the last scans in one vector."""
        count = self._scans.maxlen or 1
        new = 1 if self._scans else count
        self._scans.extend([observation["scan"].copy() for _ in range(new)])
        return {**observation, "scan": np.concatenate(self._scans)}


class GoalVector(gym.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Adds where the goal lies by dead reckoning: it drifts, as honest odometry does.

    The robot adds up the measured motion since each mark was given. Under goal 0, and for a
    mark that was never given, the vector is (0, 0).

    | key | before | after |
    |---|---|---|
    | ``goal_vector`` | none | Box float32 (2,): the goal in the robot's frame (x, y) [m] |

    Args:
        env: a CogMap environment.
    """

    def __init__(self, env: Env) -> None:
        """Add the key to the space."""
        RecordConstructorArgs.__init__(self)
        gym.ObservationWrapper.__init__(self, env)
        limit = np.float32(FARTHEST_GOAL_M)
        self.observation_space = with_key(
            env, "goal_vector", spaces.Box(-limit, limit, (2,), np.float32)
        )
        self._start_from_robot = Pose()
        self._marks: dict[int, Points] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, with no marks."""
        self._start_from_robot, self._marks = Pose(), {}
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Observation) -> Observation:
        """The observation with the believed way to the goal."""
        self._start_from_robot @= reckoned(observation)
        if observation["mark"]:
            self._marks[int(observation["mark"])] = self._start_from_robot.position
        mark = self._marks.get(int(observation["goal"]))
        vector = np.zeros(2) if mark is None else self._start_from_robot.inverse().apply(mark)
        limited = np.clip(vector, -FARTHEST_GOAL_M, FARTHEST_GOAL_M).astype(np.float32)
        return {**observation, "goal_vector": limited}


def reckoned(observation: Observation) -> Pose:
    """The motion since the last observation as measured, ``before_from_now``."""
    return Pose(*(float(value) for value in observation["odometry"]))


def box_of(env: Env, key: str) -> spaces.Box:
    """The space of one key of an environment's observations."""
    assert isinstance(env.observation_space, spaces.Dict), "CogMap environments use a Dict"
    box = env.observation_space[key]
    assert isinstance(box, spaces.Box), f"the {key} of CogMap environments is a Box"
    return box


def with_key(env: Env, key: str, space: spaces.Space[Any]) -> spaces.Dict:
    """An environment's observation space with one key added or changed."""
    assert isinstance(env.observation_space, spaces.Dict), "CogMap environments use a Dict"
    return spaces.Dict({**env.observation_space.spaces, key: space})


def _check_count(name: str, count: Any, most: int | None) -> None:
    whole = isinstance(count, int) and not isinstance(count, bool)
    if not whole or count < 1 or (most is not None and count > most):
        bound = "" if most is None else f" and at most {most}"
        raise ValueError(f"{name}: expected an int of at least 1{bound}, got {count!r}")
