"""Trials of robots in tasks: each a row, a pure function of its key, run by many workers."""

from __future__ import annotations

import hashlib
import subprocess
import time
import traceback
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import product
from pathlib import Path
from typing import Any

import gymnasium as gym
import joblib
import numpy as np
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401 - registers the environments
from agents.base import Agent
from agents.registry import make_agent, wrap
from agents.rollout import Episode, run_episode
from cogmap_gym.observation import Observation
from cogmap_gym.tasks import HOME
from cogmap_gym.trial_scores import SHARES, coverage_curve, curve_area, distance_to, goal_scores

TASKS = {
    "explore": "CogMap/Explore-v0",
    "home": "CogMap/GoHome-v0",
    "goto": "CogMap/GoTo-v0",
    "shortcut": "CogMap/Shortcut-v0",
}
"""The environment of each task."""
Row = dict[str, Any]
SCORES = (
    "success", "goals", "goals_met", "spl", "spl_learning", "soft_spl", "coverage", "area",
    *(f"distance_{share:.0%}" for share in SHARES), "moves", "path_length", "collisions", "reward",
    "curve", "cpu_ms", "map_bytes", "commit", "params", "error",
)  # fmt: skip
"""What a row tells of its trial."""
TIMES = ("cpu_ms",)
"""Columns that differ from run to run."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What is run: the key of a row."""

    agent: str
    task: str
    map: str
    odometry: str
    seed: int

    @property
    def key(self) -> tuple[str, ...]:
        """As it stands in the file."""
        return tuple(str(value) for value in asdict(self).values())


KEY = tuple(field.name for field in fields(Trial))
COLUMNS = (*KEY, *SCORES)


def trials_of(
    agents: Sequence[str],
    tasks: Sequence[str],
    maps: Sequence[str],
    levels: Sequence[str],
    seeds: Iterable[int],
) -> list[Trial]:
    """Every combination; all robots on a trial before the next, so that few hours tell much.

    Raises:
        ValueError: there is no such task.
    """
    if unknown := set(tasks) - set(TASKS):
        raise ValueError(f"tasks: expected some of {sorted(TASKS)}, got {sorted(unknown)}")
    every = product(seeds, maps, levels, tasks, agents)
    return [Trial(agent, task, plan, level, seed) for seed, plan, level, task, agent in every]


class _Watch:
    """Keeps what the scores need, at each step."""

    def __init__(self, agent: Agent) -> None:
        self.agent = agent
        self.seen: list[float] = []
        self.driven: list[float] = []
        self.bumps = 0
        self.seconds: list[float] = []

    def reset(self, *specs: Any) -> None:
        self.agent.reset(*specs)

    def act(self, observation: Observation) -> NDArray[np.float32]:
        begun = time.process_time()
        action = self.agent.act(observation)
        self.seconds.append(time.process_time() - begun)
        return action

    def sketch(self) -> dict[str, Any] | None:
        return self.agent.sketch()

    def __call__(
        self, _step: int, observation: Observation, _action: Any, info: dict[str, Any], _agent: Any
    ) -> None:
        self.seen.append(info["coverage"])
        self.driven.append(info["path_length"])
        self.bumps += int(observation["bump"])


def run_trial(trial: Trial) -> Row:
    """Run one trial; one that breaks down is a row with its traceback."""
    row: Row = dict.fromkeys(COLUMNS) | asdict(trial) | {"commit": commit()}
    try:
        agent = make_agent(trial.agent, trial.seed)
        made = gym.make(TASKS[trial.task], map=trial.map, odometry=trial.odometry)
        env = wrap(trial.agent, made)
        watch = _Watch(agent)
        episode = run_episode(env, watch, trial.seed, watch)
        row |= _scores(watch, episode, made.unwrapped) | {"params": params_of(agent)}
        row["map_bytes"] = getattr(agent, "map_bytes", None)
    except Exception:  # noqa: BLE001 - a failed trial is a row, too
        row["error"] = " | ".join(traceback.format_exc().splitlines())
    return row


def _scores(watch: _Watch, episode: Episode, world: Any) -> Row:
    """The columns of an episode."""
    seen = np.array([*watch.seen, episode.info["coverage"]])
    driven = np.array([*watch.driven, episode.info["path_length"]])
    goals = [phase for phase in episode.phases if phase["task"] != "explore"]
    marks = [_mark(phase["task"]) for phase in goals]
    curve = coverage_curve(seen, world.max_moves)
    return {
        "success": int(episode.is_success),
        **goal_scores(goals, episode.info, marks),
        "coverage": float(seen[-1]),
        "area": curve_area(seen, world.max_moves),
        **{f"distance_{share:.0%}": distance_to(share, seen, driven) for share in SHARES},
        "moves": episode.steps,
        "path_length": float(driven[-1]),
        "collisions": watch.bumps,
        "reward": episode.reward,
        "curve": ";".join(f"{share:.4f}" for share in curve),
        "cpu_ms": 1e3 * float(np.median(watch.seconds)),
    }


def _mark(task: str) -> int:
    return HOME if task == "home" else int(task.partition(":")[2])


def params_of(agent: Any) -> str:
    """The same for the same parameters alone; empty for a robot without any."""
    params = getattr(agent, "params", None)
    return "" if params is None else hashlib.sha256(repr(params).encode()).hexdigest()[:12]


def commit() -> str:
    """The commit of the code, with a plus where it was changed since; empty outside git."""
    here = Path(__file__).parent
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty=+"],  # noqa: S607 - git as the user has it
        cwd=here, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return told.stdout.strip()


def run_here(trials: Sequence[Trial], workers: int) -> Iterator[Row]:
    """Rows as they come, from processes of this machine."""
    jobs = (joblib.delayed(run_trial)(trial) for trial in trials)
    pool = joblib.Parallel(workers, return_as="generator_unordered", batch_size=1)
    yield from pool(jobs)


def run_on_ray(trials: Sequence[Trial], address: str) -> Iterator[Row]:
    """Rows as they come, from the workers of a Ray cluster.

    Args:
        trials: what to run; one whose worker died is run again elsewhere.
        address: of the cluster, as in ``ray.init``; ``local`` starts one here.

    Raises:
        ModuleNotFoundError: Ray, the extra ``cluster``, is not installed.
    """
    import ray

    ray.init(address=None if address == "local" else address, log_to_driver=False)
    try:
        remote = ray.remote(max_retries=-1)(run_trial)
        room = 2 * max(int(ray.cluster_resources().get("CPU", 1)), 1)
        waiting = list(trials)[::-1]
        running: list[Any] = []
        while waiting or running:
            while waiting and len(running) < room:
                running.append(remote.remote(waiting.pop()))
            done, running = ray.wait(running)
            yield from ray.get(done)
    finally:
        ray.shutdown()
