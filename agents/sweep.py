"""Trials of robots in tasks: each a row, a pure function of its key."""

from __future__ import annotations

import time
import traceback
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401 - registers the environments
from agents.base import Agent
from agents.provenance import commit, params_of
from agents.registry import make_agent, wrap
from agents.rollout import Episode, run_episode
from cogmap_gym.courses import course_of
from cogmap_gym.dynamics import dynamics_level
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array
from cogmap_gym.observation import Observation
from cogmap_gym.sensors import OdometrySpec
from cogmap_gym.trial_scores import (
    CURVE_POINTS,
    SHARES,
    coverage_curve,
    curve_area,
    distance_to,
    goal_scores,
)

TASKS = {
    "explore": "CogMap/Explore-v0",
    "home": "CogMap/GoHome-v0",
    "goto": "CogMap/GoTo-v0",
    "shortcut": "CogMap/Shortcut-v0",
}
"""The environment of each task."""
Row = dict[str, Any]
GOAL_SCORES = ("spl", "spl_learning", "soft_spl")
"""Scores of trials with goals."""
SHARES_SEEN = ("coverage", "area")
"""Scores of any trial."""
SCORES = (
    "success", "goals", "goals_met", *GOAL_SCORES, *SHARES_SEEN,
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
    dynamics: str = "off"

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
    dynamics: Sequence[str] = ("off",),
) -> list[Trial]:
    """Every combination; all robots on a trial before the next, so that few hours tell much.

    Raises:
        ValueError: there is no such task.
    """
    if unknown := set(tasks) - set(TASKS):
        raise ValueError(f"tasks: expected some of {sorted(TASKS)}, got {sorted(unknown)}")
    every = product(seeds, dynamics, maps, levels, tasks, agents)
    return [Trial(agent, task, plan, level, seed, d) for seed, d, plan, level, task, agent in every]


def check_trials(trials: Iterable[Trial]) -> None:
    """See that every task can be set on its map, before hours go by.

    Raises:
        ValueError: a plan that cannot be read, or lacks what a task needs; a level of odometry or
            of dynamics that is none, or not for a task.
    """
    settings = dict.fromkeys(replace(trial, agent="", seed=0) for trial in trials)
    plans = {name: FloorPlan.load(name) for name in dict.fromkeys(t.map for t in settings)}
    for trial in settings:
        course_of(trial.task, None).check(plans[trial.map])
        OdometrySpec.of(trial.odometry)
        dynamics_level(trial.dynamics, trial.task)


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
    """Run one trial; one that breaks down is a row with its traceback, and all of it missed."""
    params = ""
    try:
        agent = make_agent(trial.agent, trial.seed)
        params = params_of(agent)
        made = made_env(trial)
        watch = _Watch(agent)
        episode = run_episode(wrap(trial.agent, made), watch, trial.seed, watch)
        scores = _scores(watch, episode, made.unwrapped)
    except Exception:  # noqa: BLE001 - a failed trial is a row, too
        return broken_row(trial, traceback.format_exc(), params)
    return _head(trial, params) | scores | {"map_bytes": getattr(agent, "map_bytes", None)}


def broken_row(trial: Trial, error: str, params: str = "") -> Row:
    """The row of a trial that broke down: its scores are nought, and all its goals are missed.

    Args:
        trial: what was run.
        error: the traceback.
        params: the digest of the robot's parameters, as far as there was a robot.
    """
    try:
        env: Any = made_env(trial)
        env.reset(seed=trial.seed)
        goals = len(env.unwrapped.task.goals)
    except Exception:  # noqa: BLE001 - it may be the very error that is told
        goals = 0
    nothing = dict.fromkeys((*SHARES_SEEN, *(GOAL_SCORES if goals else ())), 0.0)
    counts = {"success": 0, **({"goals": goals, "goals_met": 0} if goals else {})}
    flat = curve_text(np.zeros(CURVE_POINTS))
    told = {"curve": flat, "error": " | ".join(error.splitlines())}
    return _head(trial, params) | nothing | counts | told


def made_env(trial: Trial) -> gym.Env[Any, Any]:
    """The environment of a trial, for a robot that is told nothing more."""
    return gym.make(
        TASKS[trial.task], map=trial.map, odometry=trial.odometry, dynamics=trial.dynamics
    )


def _head(trial: Trial, params: str) -> Row:
    """A row with what is known of every trial."""
    return dict.fromkeys(COLUMNS) | asdict(trial) | {"commit": commit(), "params": params}


def _scores(watch: _Watch, episode: Episode, world: Any) -> Row:
    """The columns of an episode."""
    seen = np.array([*watch.seen, episode.info["coverage"]])
    driven = np.array([*watch.driven, episode.info["path_length"]])
    goals = [phase for phase in episode.phases if phase["task"] != "explore"]
    return {
        "success": int(episode.is_success),
        **goal_scores(goals, episode.info, world.task.goals),
        "coverage": float(seen[-1]),
        "area": curve_area(seen, world.max_moves),
        **{f"distance_{share:.0%}": distance_to(share, seen, driven) for share in SHARES},
        "moves": episode.steps,
        "path_length": float(driven[-1]),
        "collisions": watch.bumps,
        "reward": episode.reward,
        "curve": curve_text(coverage_curve(seen, world.max_moves)),
        "cpu_ms": 1e3 * float(np.median(watch.seconds)),
    }


def curve_text(curve: Array) -> str:
    """A curve as it stands in the file."""
    return ";".join(f"{share:.4f}" for share in curve)
