"""Why trials fail: each is run again, and its failure is classed and drawn."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.failures import CAUSES, examine
from agents.sweep import COLUMNS, Trial, run_trial
from agents.wall_follower import WallFollowerAgent
from cogmap_gym.observation import Observation
from tests.test_scripts import PNG, run

Action = np.ndarray[Any, Any]


class Quitter(WallFollowerAgent):
    """A robot that says at once that it is there, and knows better."""

    def act(self, observation: Observation) -> Action:
        action = super().act(observation)
        return self.robot.declare() if observation["goal"] else action


class Dreamer(Quitter):
    """One that believes it."""

    def sketch(self) -> dict[str, Any]:
        told = super().sketch()
        return {**told, "marks": [{"id": 1, "point": told["pose"][:2]}]}


class Sleeper(WallFollowerAgent):
    """One that stays where it is once it is called."""

    def act(self, observation: Observation) -> Action:
        action = super().act(observation)
        return self.robot.move(0.1, 0.0) if observation["goal"] else action


class Fragile(WallFollowerAgent):
    """One that breaks down."""

    def act(self, observation: Observation) -> Action:
        raise RuntimeError("out of oil")


FATES = {"Quitter": "gave up", "Dreamer": "lost", "Sleeper": "out of time", "Fragile": "raised"}


@pytest.mark.parametrize(("robot", "cause"), FATES.items())
def test_a_missed_way_home_has_a_cause(robot: str, cause: str) -> None:
    (miss,) = examine(Trial(f"tests.test_failures:{robot}", "home", "two_rooms", "low", 0))
    assert miss.cause == cause
    assert miss.cause in CAUSES
    assert miss.mark == (0 if cause == "raised" else 1)
    assert "m off" in miss.told or "out of oil" in miss.told


def test_what_was_not_seen_and_marks_not_given_have_causes() -> None:
    still = "tests.test_failures:Still"
    (unseen,) = examine(Trial(still, "explore", "two_rooms", "low", 0))
    assert unseen.cause == "unseen"
    assert "%" in unseen.told
    misses = examine(Trial(still, "goto", "office:1000:easy", "low", 0))
    assert {miss.cause for miss in misses if miss.mark != 1} == {"not given"}


class Still(WallFollowerAgent):
    """One that never moves."""

    def act(self, observation: Observation) -> Action:
        super().act(observation)
        return self.robot.move(0.1, 0.0)


def test_a_trial_that_came_out_well_missed_nothing(tmp_path: Path) -> None:
    trial = Trial("cogmap", "home", "two_rooms", "low", 0)
    assert run_trial(trial)["success"] == 1
    assert examine(trial, tmp_path) == []
    assert not list(tmp_path.iterdir())


def test_the_script_tells_and_draws_the_failures_of_one_robot(tmp_path: Path) -> None:
    trial = Trial("tests.test_failures:Quitter", "home", "two_rooms", "low", 0)
    table = tmp_path / "results.csv"
    with table.open("w", newline="") as file:
        rows = csv.DictWriter(file, COLUMNS)
        rows.writeheader()
        rows.writerow(run_trial(trial))
        rows.writerow(run_trial(Trial("wall_follower", "explore", "two_rooms", "low", 0)))
    code, said = run("failures.py", table, "--agent", trial.agent, "--out", tmp_path / "out")
    assert code == 0, said
    assert "| low | home | gave up | 1 |" in (tmp_path / "out" / "failures.md").read_text()
    (picture,) = (tmp_path / "out").glob("*.png")
    assert picture.read_bytes().startswith(PNG)
    code, said = run("failures.py", table, "--agent", "nobody", "--out", tmp_path / "none")
    assert code == 2
    assert "nobody" in said
    assert not (tmp_path / "none").exists()
