"""Sweeps: a trial is a function of its key, and whoever is killed goes on where it stopped."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.cogmap import CogMapAgent
from agents.rollout import run_episode
from agents.sweep import COLUMNS, TIMES, Trial, broken_row, check_trials, run_trial, trials_of
from agents.workers import run_here, run_on_ray
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

ROOT = Path(__file__).parents[1]
TRIAL = Trial("wall_follower", "home", "two_rooms", "medium", 3)
ASKED = (
    "--agents", "random_walk,wall_follower", "--tasks", "explore,home", "--maps", "two_rooms",
    "--seeds", "4", "--odometry", "low,medium",
)  # fmt: skip


def timeless(row: dict[str, Any]) -> dict[str, str]:
    return {name: str(row[name]) for name in COLUMNS if name not in TIMES}


def test_a_trial_is_a_function_of_its_key() -> None:
    first, second = run_trial(TRIAL), run_trial(TRIAL)
    assert timeless(first) == timeless(second)
    assert tuple(first) == COLUMNS
    assert first["error"] is None
    assert first["goals"] == 1
    assert 0.0 < first["area"] <= first["coverage"] <= 1.0


class Lame(CogMapAgent):
    """A robot that breaks down on its way."""

    def act(self, observation: Observation) -> np.ndarray[Any, Any]:
        if observation["goal"]:
            raise RuntimeError("out of\noil")
        return super().act(observation)


def test_a_trial_that_breaks_down_is_a_row_with_its_traceback() -> None:
    lame = "tests.test_sweep:Lame"
    row = run_trial(replace(TRIAL, agent=lame))
    assert row["error"].startswith("Traceback")
    assert "RuntimeError: out of" in row["error"]
    assert "\n" not in row["error"]
    assert (row["success"], row["goals"], row["goals_met"], row["soft_spl"]) == (0, 1, 0, 0.0)
    assert row["params"] == run_trial(replace(TRIAL, agent="cogmap"))["params"] != ""
    assert tuple(row) == COLUMNS


def test_a_broken_trial_misses_as_many_goals_as_it_had() -> None:
    trial = Trial("tests.test_sweep:Lame", "goto", "office:1000", "medium", 1)
    whole = run_trial(replace(trial, agent="random_walk"))
    broken = broken_row(trial, "Traceback\nValueError: oops")
    assert broken["goals"] == whole["goals"] >= 3
    assert (broken["goals_met"], broken["spl"], broken["area"]) == (0, 0.0, 0.0)
    exploring = broken_row(replace(trial, task="explore"), "Traceback")
    assert (exploring["goals"], exploring["soft_spl"], exploring["area"]) == (None, None, 0.0)


def test_every_combination_is_tried_and_unknown_tasks_are_refused() -> None:
    trials = trials_of(["a", "b"], ["explore"], ["m", "n"], ["low"], range(3))
    assert len({trial.key for trial in trials}) == 12
    assert [trial.agent for trial in trials[:2]] == ["a", "b"]
    with pytest.raises(ValueError, match="tasks: expected some of"):
        trials_of(["a"], ["swim"], ["m"], ["low"], range(1))
    assert len(trials_of(["a"], ["home"], ["m"], ["low"], range(2), ["off", "busy"])) == 4


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"map": "no_such"}, "no_such"),
        ({"odometry": "wild"}, "odometry: .*wild"),
        ({"dynamics": "wild"}, "dynamics: .*wild"),
        ({"task": "shortcut"}, "two_rooms"),
        ({"task": "shortcut", "map": "thesis_office", "dynamics": "doors"}, "dynamics: .*doors"),
    ],
)
def test_what_cannot_be_run_is_refused_at_once(changed: dict[str, str], message: str) -> None:
    check_trials([TRIAL])
    with pytest.raises(ValueError, match=message):
        check_trials([TRIAL, replace(TRIAL, **changed)])


def test_workers_give_the_rows_that_one_gives() -> None:
    trials = trials_of(["random_walk"], ["explore"], ["two_rooms"], ["medium"], range(3))
    rows = sorted(run_here(trials, 2), key=lambda row: row["seed"])
    assert [timeless(row) for row in rows] == [timeless(run_trial(trial)) for trial in trials]


@pytest.mark.slow
def test_a_local_ray_cluster_gives_the_same_rows() -> None:
    pytest.importorskip("ray", reason="Ray is the extra 'cluster'")
    trials = trials_of(["random_walk"], ["explore"], ["two_rooms"], ["medium"], range(3))
    rows = sorted(run_on_ray(trials, "local"), key=lambda row: row["seed"])
    assert [timeless(row) for row in rows] == [timeless(run_trial(trial)) for trial in trials]


def evaluate(out: Path, *more: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, str(ROOT / "scripts" / "evaluate.py"), *ASKED, "--out", str(out)]
    return subprocess.Popen(
        [*command, *more], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "results.csv").open(newline="") as file:
        return sorted(map(timeless, csv.DictReader(file)), key=lambda row: list(row.values())[:5])


@pytest.mark.slow
def test_a_sweep_killed_three_times_and_resumed_is_the_sweep_unbroken(tmp_path: Path) -> None:
    whole, torn = tmp_path / "whole", tmp_path / "torn"
    assert evaluate(whole).wait() == 0
    rng = np.random.default_rng(5)
    for _ in range(3):
        process = evaluate(torn, "--resume")
        time.sleep(float(rng.uniform(2.0, 6.0)))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    assert evaluate(torn, "--resume").wait() == 0
    assert rows_of(torn) == rows_of(whole)
    assert (torn / "report.html").read_text().count("<table>") == 2


def test_without_resume_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "results.csv").write_text("something\n")
    assert evaluate(tmp_path).wait() == 2
    assert (tmp_path / "results.csv").read_text() == "something\n"


class Thief:
    """A robot that keeps whatever it is given."""

    def __init__(self) -> None:
        self.given: list[Any] = []

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        self.given += [robot, laser]

    def act(self, observation: Observation) -> np.ndarray[Any, Any]:
        self.given.append(observation)
        return RobotSpec().move(0.3, 1.0)

    def sketch(self) -> None:
        return None


def test_a_robot_is_given_observations_and_nothing_else() -> None:
    import gymnasium as gym

    thief, env = Thief(), gym.make("CogMap/GoHome-v0", map="two_rooms", max_moves=5)
    run_episode(env, thief, 0)
    robot, laser, *seen = thief.given
    assert (type(robot), type(laser)) == (RobotSpec, LaserSpec)
    for observation in seen:
        assert set(observation) == {"scan", "odometry", "bump", "mark", "goal"}
        assert env.observation_space.contains(observation)
    shared = [a for o in seen for a in o.values() if isinstance(a, np.ndarray) and a.base]
    assert not shared, "no array is a window on the world's memory"
