"""Wrappers that change what an action means or what a robot is told.

All rebuild from ``env.spec``. From the inside out: ``MoveControl``, ``DiscreteControl``,
``GoalVector`` and ``EgocentricGrid``, ``ScanSectors``, ``StackedScans``.
"""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from cogmap_gym.control_wrappers import DiscreteControl, MoveControl
from cogmap_gym.egocentric import EgocentricGrid
from cogmap_gym.observation import Observation
from cogmap_gym.sensor_wrappers import GoalVector, ScanSectors, StackedScans

__all__ = [
    "DiscreteControl",
    "EgocentricGrid",
    "GoalVector",
    "MoveControl",
    "ScanSectors",
    "StackedScans",
    "TruePose",
]

FARTHEST_M = 10_000.0
"""Bound of a true coordinate [m]: beyond any building."""


class TruePose(gym.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Adds the key ``pose``: the true (x, y, theta) in the plan's frame [m, rad].

    For oracles alone: no robot that is compared with others may get it.

    | key | before | after |
    |---|---|---|
    | ``pose`` | none | Box float32 (3,) |
    """

    def __init__(self, env: gym.Env[Observation, Any]) -> None:
        """Add the key to the observation space."""
        RecordConstructorArgs.__init__(self)
        gym.ObservationWrapper.__init__(self, env)
        assert isinstance(env.observation_space, spaces.Dict), "CogMap environments use a Dict"
        high = np.array((FARTHEST_M, FARTHEST_M, np.pi), dtype=np.float32)
        pose = spaces.Box(-high, high, (3,), np.float32)
        self.observation_space = spaces.Dict({**env.observation_space.spaces, "pose": pose})

    def observation(self, observation: Observation) -> Observation:
        """The observation with the true pose."""
        pose = self.get_wrapper_attr("world").pose
        box = self.observation_space["pose"]  # type: ignore[index]
        values = np.array((pose.x, pose.y, pose.theta), dtype=np.float32)
        return {**observation, "pose": np.clip(values, box.low, box.high)}
