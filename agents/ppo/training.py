"""What training is made of: the offices, the learner, and the watch over both."""

from __future__ import annotations

import time
from collections import defaultdict, deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

import cogmap_gym  # noqa: F401 - registers the environments
from agents.ppo import checkpoint
from agents.ppo.network import policy_kwargs
from agents.ppo.params import Config
from agents.ppo.vec_env import Joined, LearningEnv
from cogmap_gym.vector import CogMapVectorEnv

TASKS = {"explore": "CogMap/Explore-v0", "home": "CogMap/GoHome-v0"}
"""What can be trained in."""
LATELY = 100
"""Episodes of each task that a point of the curve tells of [-]."""


def make_env(
    robots: dict[str, int],
    first_office: int,
    config: Config,
    most_moves: int,
    explore_weight: float,
    **keywords: Any,
) -> Joined:
    """The robots that learn, each in an office of its own.

    Args:
        robots: how many, by task.
        first_office: of the first robot; the others follow.
        config: what they perceive and how they move.
        most_moves: of an episode.
        explore_weight: of what is newly seen.
        keywords: of the vector environment.
    """
    parts = {}
    for task, count in robots.items():
        if count:
            offices = [f"office:{first_office + row}" for row in range(count)]
            first_office += count
            env = gym.make_vec(
                TASKS[task], num_envs=count, map=offices, autoreset_mode="SameStep",
                max_moves=most_moves, **keywords,
            )  # fmt: skip
            world = env.unwrapped
            assert isinstance(world, CogMapVectorEnv), "the offices' entry point"
            parts[task] = LearningEnv(world, config, most_moves, explore_weight)
    return Joined(parts)


def make_model(env: Joined, config: Config, **keywords: Any) -> OnPolicyAlgorithm:
    """A learner that has not learnt yet: recurrent if its network has a memory.

    Args:
        env: where it learns; its rewards are scaled by how much their discounted sums vary.
        config: of the network.
        keywords: of ``PPO``, ``gamma`` among them.
    """
    scaled = VecNormalize(env, norm_obs=False, norm_reward=True, gamma=keywords["gamma"])
    made, policy = (RecurrentPPO, "MlpLstmPolicy") if config.network.lstm else (PPO, "MlpPolicy")
    model: OnPolicyAlgorithm = made(
        policy, scaled, policy_kwargs=policy_kwargs(config.network), device="cpu", **keywords
    )
    return model


class Watch(BaseCallback):  # type: ignore[misc]
    """Writes the curve and the checkpoints, and tells the progress.

    Args:
        path: of the checkpoint.
        args: that it is kept with.
        curve: what was seen before a resume.
        every: seconds between two checkpoints.
        tell: called with the moves made so far and the last point of the curve.
    """

    def __init__(
        self,
        path: Path,
        args: dict[str, Any],
        curve: checkpoint.Curve,
        every: float,
        tell: Callable[[int, dict[str, float]], None],
    ) -> None:
        """Nothing was seen yet."""
        super().__init__()
        self.curve = curve
        self._path, self._args, self._every, self._tell = path, args, every, tell
        self._seen: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=LATELY))
        self._begun = time.monotonic()
        self._before = curve[-1]["minutes"] if curve else 0.0
        self._saved = self._begun

    def keep(self) -> None:
        """Write the checkpoint."""
        checkpoint.save(self._path, self.model, self.curve, self._args)
        self._saved = time.monotonic()

    def _on_step(self) -> bool:
        """Take note of the episodes that ended."""
        for info in self.locals["infos"]:
            if "episode" in info:
                task = info["task"]
                self._seen[f"{task}/return"].append(info["episode"]["r"])
                self._seen[f"{task}/area"].append(info["area"])
                self._seen[f"{task}/success"].append(float(info["is_success"]))
        return True

    def _on_rollout_start(self) -> None:
        """After an update: add a point to the curve, and keep all if it is time."""
        minutes = self._before + (time.monotonic() - self._begun) / 60.0
        point = {"steps": float(self.num_timesteps), "minutes": minutes}
        point |= {key: float(np.mean(values)) for key, values in sorted(self._seen.items())}
        self.curve.append(point)
        for key, value in point.items():
            self.logger.record(f"offices/{key.replace('/', '_')}", value)
        self._tell(self.num_timesteps, point)
        if time.monotonic() - self._saved >= self._every:
            self.keep()
