"""cogmap_gym: a robot with a laser and drifting odometry in an office, for Gymnasium.

Importing this package registers the environments ``CogMap/Explore-v0``,
``CogMap/GoHome-v0``, ``CogMap/GoTo-v0``, ``CogMap/Shortcut-v0`` and ``CogMap/Thesis-v0``.
"""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.sensors import OdometrySpec

__all__ = ["ENV_IDS", "FloorPlan", "LaserSpec", "OdometrySpec", "RobotSpec"]

_TASKS = {
    "Explore": "explore",
    "GoHome": "home",
    "GoTo": "goto",
    "Shortcut": "shortcut",
    "Thesis": "thesis",
}
ENV_IDS = tuple(f"CogMap/{name}-v0" for name in _TASKS)
"""All ids that importing this package registers."""

for _id, _task in zip(ENV_IDS, _TASKS.values(), strict=True):
    if _id not in registry:
        register(
            _id,
            entry_point="cogmap_gym.env:CogMapEnv",
            vector_entry_point="cogmap_gym.vector:CogMapVectorEnv",
            kwargs={"task": _task},
        )
