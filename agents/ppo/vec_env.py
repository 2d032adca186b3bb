"""``CogMapVectorEnv`` as Stable-Baselines3 wants an environment: percepts in, chosen moves out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from agents.ppo.memory_kernel import Floats
from agents.ppo.moving import action_of
from agents.ppo.network import spaces_of
from agents.ppo.params import Config
from agents.ppo.perception import Perception
from cogmap_gym.observation import Observation
from cogmap_gym.tasks import STEP_REWARD
from cogmap_gym.vector import CogMapVectorEnv

Flags = NDArray[np.bool_]
Infos = list[dict[str, Any]]
Step = tuple[Floats, Floats, Flags, Infos]
"""Percepts, rewards, which episodes ended, infos."""


class PlainVecEnv(VecEnv):  # type: ignore[misc]
    """What Stable-Baselines3 asks of an environment and has no meaning here."""

    render_mode = None

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same attribute of this object for each robot asked for."""
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: robots have no attributes of their own."""
        raise NotImplementedError(f"{attr_name}: robots have no attributes of their own")

    def env_method(self, method_name: str, *_: Any, **__: Any) -> list[Any]:
        """Refuse: robots have no methods of their own."""
        raise NotImplementedError(f"{method_name}: robots have no methods of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:  # noqa: ARG002
        """No robot's environment is wrapped."""
        return [False] * len(list(self._get_indices(indices)))


class LearningEnv(PlainVecEnv):
    """Robots that learn, each with a perception of its own.

    An episode that ended is begun anew at once; ``infos`` then have the last percepts of the old
    one under ``terminal_observation``, and under ``TimeLimit.truncated`` whether a limit cut it,
    so that the learner goes on from the value of what was cut off. Besides, they have ``episode``
    (return ``r``, length ``l``), ``area`` (the mean share seen over ``most_moves``) and
    ``is_success``.

    Args:
        env: the world; ``autoreset_mode="SameStep"``, ``control="move"``.
        config: what the robots perceive and how they move.
        most_moves: of an episode.
        explore_weight: of what is newly seen, beside which the rewards of goals are large.

    Raises:
        ValueError: the world resets or moves otherwise, or has too few beams.
    """

    def __init__(
        self, env: CogMapVectorEnv, config: Config, most_moves: int, explore_weight: float = 1.0
    ) -> None:
        """Make the perceptions."""
        mode, control = env.autoreset_mode, env.robot.control
        if mode is not AutoresetMode.SAME_STEP:
            raise ValueError(f"LearningEnv: autoreset_mode: expected SameStep, got {mode.value!r}")
        if control != "move":
            raise ValueError(f"LearningEnv: control: expected 'move', got {control!r}")
        super().__init__(env.num_envs, *spaces_of(config))
        self.env, self._config = env, config
        self._most_moves, self._weight = most_moves, explore_weight
        self._perception = Perception(env.num_envs, env.robot, env.laser, config.percepts)
        self._goals = np.zeros(env.num_envs, dtype=np.int64)
        self._choices: NDArray[np.int64] = np.zeros((env.num_envs, 2), dtype=np.int64)
        self._lengths = np.zeros(env.num_envs, dtype=np.int64)
        self._returns, self._seen = np.zeros(env.num_envs), np.zeros(env.num_envs)

    def reset(self) -> Floats:
        """Begin all episodes; percepts (N, size)."""
        observation, _ = self.env.reset(seed=self._seeds[0])
        self._reset_seeds()
        for row in range(self.num_envs):
            self._begin(row)
        self._goals = observation["goal"]
        return self._perceived(observation, range(self.num_envs))

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Take what the networks chose, (N, 2)."""
        self._choices = actions

    def step_wait(self) -> Step:
        """Make the moves that were chosen."""
        observation, rewards, terminated, truncated, info = self.env.step(self._actions())
        # While exploring, discounting hurries already; the price of a step would only hide what
        # is newly seen.
        found = self._weight * (rewards - STEP_REWARD)
        weighted = np.where(self._goals == 0, found, rewards)
        done = terminated | truncated
        infos: Infos = [{} for _ in range(self.num_envs)]
        last = dict(observation)
        for row in np.flatnonzero(done).tolist():
            last = {key: value.copy() for key, value in last.items()}
            for key, value in info["final_obs"][row].items():
                last[key][row] = value
        self._count(weighted, self._coverage(info, done))
        percepts = self._perceived(last, range(self.num_envs))
        for row in np.flatnonzero(done).tolist():
            infos[row] = self._told(row, info, cut=bool(truncated[row] and not terminated[row]))
            infos[row]["terminal_observation"] = percepts[row].copy()
            self._begin(row)
            percepts[row] = self._perceived(observation, [row])[0]
        self._goals = observation["goal"]
        return percepts, weighted.astype(np.float32), done, infos

    def close(self) -> None:
        """Let the world go."""
        self.env.close()

    def _actions(self) -> NDArray[np.float32]:
        """The actions (N, 3) that were chosen."""
        eyes, moves, robot = self._perception, self._config.moves, self.env.robot
        ways = [eyes.to_goal(row, int(goal)) for row, goal in enumerate(self._goals)]
        chosen = zip(self._choices.tolist(), ways, strict=True)
        return np.array([action_of(choice, way, moves, robot) for choice, way in chosen])

    def _perceived(self, observation: Observation, rows: Iterable[int]) -> Floats:
        """Percepts of some robots, (R, size)."""
        seen = [({k: v[row] for k, v in observation.items()}, row) for row in rows]
        return np.stack([self._perception.perceive(row, one) for one, row in seen])

    def _begin(self, row: int) -> None:
        """Begin the life of a robot."""
        self._perception.forget(row)
        self._lengths[row], self._returns[row], self._seen[row] = 0, 0.0, 0.0

    def _coverage(self, info: dict[str, Any], done: Flags) -> NDArray[np.float64]:
        """The share seen of each robot, of those whose episode ended at its end."""
        seen: NDArray[np.float64] = info["coverage"].copy()
        for row in np.flatnonzero(done).tolist():
            seen[row] = info["final_info"]["coverage"][row]
        return seen

    def _count(self, rewards: NDArray[np.float64], coverage: NDArray[np.float64]) -> None:
        """Add a step to the scores."""
        self._lengths += 1
        self._returns += rewards
        self._seen += coverage
        self._last_seen = coverage

    def _told(self, row: int, info: dict[str, Any], *, cut: bool) -> dict[str, Any]:
        """The scores of an episode that ended."""
        length = int(self._lengths[row])
        rest = max(self._most_moves - length, 0) * self._last_seen[row]
        return {
            "TimeLimit.truncated": cut,
            "episode": {"r": float(self._returns[row]), "l": length, "t": 0.0},
            "area": float(self._seen[row] + rest) / max(self._most_moves, length),
            "is_success": bool(info["final_info"]["is_success"][row]),
        }


class Joined(PlainVecEnv):
    """Several environments as one: the robots of the first, then those of the next.

    Args:
        parts: by the name of their task; all have the same spaces.

    Raises:
        ValueError: there are none.
    """

    def __init__(self, parts: dict[str, LearningEnv]) -> None:
        """Join them."""
        if not parts:
            raise ValueError("Joined: expected robots that learn, got none")
        self.parts = parts
        first, counts = next(iter(parts.values())), [part.num_envs for part in parts.values()]
        super().__init__(sum(counts), first.observation_space, first.action_space)
        self.tasks = [name for name, part in parts.items() for _ in range(part.num_envs)]
        self._cuts = np.cumsum(counts)[:-1]

    def reset(self) -> Floats:
        """Begin all episodes."""
        for part, first in zip(self.parts.values(), (0, *self._cuts), strict=True):
            if self._seeds[first] is not None:
                part.seed(self._seeds[first])
        self._reset_seeds()
        return np.concatenate([part.reset() for part in self.parts.values()])

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Share out what the networks chose."""
        for part, own in zip(self.parts.values(), np.split(actions, self._cuts), strict=True):
            part.step_async(own)

    def step_wait(self) -> Step:
        """Make the moves that were chosen."""
        steps: Sequence[Step] = [part.step_wait() for part in self.parts.values()]
        percepts, rewards, done, infos = zip(*steps, strict=True)
        joined = np.concatenate(percepts), np.concatenate(rewards), np.concatenate(done)
        told = [
            {**info, "task": task}
            for task, info in zip(self.tasks, [i for part in infos for i in part], strict=True)
        ]
        return *joined, told

    def close(self) -> None:
        """Let all go."""
        for part in self.parts.values():
            part.close()
