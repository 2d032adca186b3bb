"""One episode of an agent in an environment; the agent gets observations only."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from agents.base import Agent
from cogmap_gym.observation import Observation

OnStep = Callable[[int, Observation, NDArray[np.float32], dict[str, Any], Agent], None]
"""Called as ``on_step(step, observation, action, info, agent)`` after the agent has acted and
before the world moves: ``info`` is the truth at the moment of ``observation``."""


@dataclass(frozen=True, slots=True, eq=False)
class Episode:
    """What happened in one episode."""

    seed: int
    """The seed of the environment."""
    steps: int
    """How many actions were taken."""
    reward: float
    """Sum of the rewards."""
    is_success: bool
    """Whether every goal was met."""
    terminated: bool
    """Whether the task came to its end; otherwise the limit cut it."""
    success: NDArray[np.float64]
    """By mark, (10,): 1 success, 0 failure, -1 not finished."""
    info: dict[str, Any]
    """The last ``info``."""
    path: NDArray[np.float64]
    """True pose at each observation, (steps + 1, 3) [m, rad]."""
    phases: list[dict[str, Any]]
    """A finished phase each, as in ``result.json``: ``task``, ``success``, ``moves``,
    ``path_length``, ``oracle_length``, and what the agent believed: ``asrs``, ``exits``,
    ``links``."""


def run_episode(
    env: gym.Env[Any, Any], agent: Agent, seed: int, on_step: OnStep | None = None
) -> Episode:
    """Run one episode of ``agent`` in ``env``.

    Args:
        env: a CogMap environment, wrapped or not.
        agent: is reset with the specs of robot and laser, and then gets copies of the
            observations and nothing else.
        seed: of the environment.
        on_step: called before each move; see ``OnStep``.
    """
    world = env.unwrapped
    observation, info = env.reset(seed=seed)
    agent.reset(env.get_wrapper_attr("robot"), env.get_wrapper_attr("laser"))
    path, total, done, terminated = [info["pose"]], 0.0, False, False
    phases: list[dict[str, Any]] = []
    while not done:
        action = agent.act(copy.deepcopy(observation))
        if on_step is not None:
            on_step(len(path) - 1, observation, action, info, agent)
        observation, reward, terminated, truncated, info = env.step(action)
        results = world.task.results  # type: ignore[attr-defined]
        phases += [_phase(result, agent) for result in results[len(phases) :]]
        path.append(info["pose"])
        total, done = total + float(reward), terminated or truncated
    return Episode(
        seed,
        len(path) - 1,
        total,
        bool(info["is_success"]),
        terminated,
        info["success"],
        info,
        np.array(path),
        phases,
    )


def _phase(result: Any, agent: Agent) -> dict[str, Any]:
    """How a phase came out, and what the agent believes at its end."""
    sketch = agent.sketch() or {}
    return {
        **asdict(result),
        "asrs": len(sketch.get("asrs", ())),
        "exits": len(sketch.get("exits", ())),
        "links": [list(link) for link in sketch.get("links", ())],
    }
