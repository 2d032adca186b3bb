"""Sweeps: a trial is a function of its key, and whoever is killed goes on where it stopped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.cogmap import CogMapAgent
from agents.sweep import COLUMNS, Trial, broken_row, check_trials, possible, run_trial, trials_of
from agents.trial_row import TIMES
from agents.workers import run_here
from cogmap_gym.observation import Observation

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
    assert (row["doors_changed"], row["boxes_moved"]) == (0, 0), "as it was when it broke down"
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


def test_a_task_is_left_out_where_it_cannot_be_set_and_the_reason_is_told() -> None:
    tasks, maps = ["home", "shortcut"], ["two_rooms", "thesis_office"]
    trials = trials_of(["random_walk"], tasks, maps, ["medium"], range(2))
    kept, reasons = possible(trials)
    assert {(t.task, t.map) for t in kept} == {
        ("home", "two_rooms"),
        ("home", "thesis_office"),
        ("shortcut", "thesis_office"),
    }
    assert len(kept) == 6
    assert len(reasons) == 1
    assert "chords" in reasons[0]


def test_workers_give_the_rows_that_one_gives() -> None:
    trials = trials_of(["random_walk"], ["explore"], ["two_rooms"], ["medium"], range(3))
    rows = sorted(run_here(trials, 2), key=lambda row: row["seed"])
    assert [timeless(row) for row in rows] == [timeless(run_trial(trial)) for trial in trials]
