"""Trials of robots in tasks: each a row, a pure function of its key."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import product
from typing import Any

import gymnasium as gym

import cogmap_gym  # noqa: F401 - registers the environments
from agents.provenance import commit, params_of
from agents.registry import make_agent, wrap
from agents.rollout import run_episode
from agents.trial_row import SCORES, Row, nothing, plan_columns, scores_of
from agents.watch import Watch
from cogmap_gym.courses import course_of
from cogmap_gym.dynamics import dynamics_level
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.peak_memory import forget_peak, peak_megabytes
from cogmap_gym.sensors import OdometrySpec

TASKS = {
    "explore": "CogMap/Explore-v0",
    "home": "CogMap/GoHome-v0",
    "goto": "CogMap/GoTo-v0",
    "shortcut": "CogMap/Shortcut-v0",
}
"""The environment of each task."""


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


def possible(trials: Iterable[Trial]) -> tuple[list[Trial], list[str]]:
    """The trials whose task can be set on their map, and why the others cannot, once a reason.

    Raises:
        ValueError: a plan that cannot be read.
    """
    trials = list(trials)
    plans = {name: FloorPlan.load(name) for name in dict.fromkeys(t.map for t in trials)}
    reasons: dict[tuple[str, str], str] = {}
    for task, name in dict.fromkeys((t.task, t.map) for t in trials):
        try:
            course_of(task, None).check(plans[name])
        except ValueError as error:
            reasons[task, name] = str(error)
    return [t for t in trials if (t.task, t.map) not in reasons], list(reasons.values())


def run_trial(trial: Trial) -> Row:
    """Run one trial; one that breaks down is a row with its traceback, and all of it missed."""
    params, watches_memory, watch = "", forget_peak(), None
    try:
        agent = make_agent(trial.agent, trial.seed)
        params = params_of(agent)
        made = made_env(trial)
        watch = Watch(agent, made.unwrapped)
        episode = run_episode(wrap(trial.agent, made), watch, trial.seed, watch)
        scores = scores_of(watch, episode, made.unwrapped, trial.map)
        peak = peak_megabytes() if watches_memory else None
        cost = {"peak_mb": peak, "map_bytes": getattr(agent, "map_bytes", None)}
    except (Exception, SystemExit):  # noqa: BLE001 - a failed trial is a row, too
        changes = {} if watch is None else watch.changes()
        return broken_row(trial, traceback.format_exc(), params) | changes
    return _head(trial, params) | scores | cost


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
        known = nothing(len(env.unwrapped.task.goals)) | plan_columns(env.unwrapped.plan, trial.map)
    except Exception:  # noqa: BLE001 - it may be the very error that is told
        known = nothing(0)
    return _head(trial, params) | known | {"error": " | ".join(error.splitlines())}


def made_env(trial: Trial) -> gym.Env[Any, Any]:
    """The environment of a trial, for a robot that is told nothing more."""
    return gym.make(
        TASKS[trial.task], map=trial.map, odometry=trial.odometry, dynamics=trial.dynamics
    )


def _head(trial: Trial, params: str) -> Row:
    """A row with what is known of every trial."""
    return dict.fromkeys(COLUMNS) | asdict(trial) | {"commit": commit(), "params": params}
