"""Whoever is killed goes on where it stopped: the script, and workers of a Ray cluster."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.random_walk import RandomWalkAgent
from agents.sweep import COLUMNS, KEY, Trial, run_trial
from agents.trial_row import TIMES
from agents.workers import RETRIES, run_on_ray
from cogmap_gym.observation import Observation

ROOT = Path(__file__).parents[1]
ASKED = (
    "--agents", "random_walk,wall_follower", "--tasks", "explore,home", "--maps", "two_rooms",
    "--seeds", "3", "--odometry", "low,medium",
)  # fmt: skip
TRIALS = 2 * 2 * 3 * 2
MARKER = "FRAGILE_MARKER"
"""The environment variable that says where a fragile robot keeps that it has died."""


def timeless(row: dict[str, Any]) -> dict[str, str]:
    told = {name: "" if row[name] is None else str(row[name]) for name in COLUMNS}
    return {name: value for name, value in told.items() if name not in TIMES}


def evaluate(out: Path, *more: str, asked: tuple[str, ...] = ASKED) -> subprocess.Popen[bytes]:
    command = [sys.executable, str(ROOT / "scripts" / "evaluate.py"), *asked, "--out", str(out)]
    return subprocess.Popen(
        [*command, *more], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        start_new_session=True,
    )  # fmt: skip


def rows_of(out: Path) -> list[dict[str, str]]:
    """All rows without what differs from run to run, in the order of their keys."""
    with (out / "results.csv").open(newline="") as file:
        rows = [timeless(row) for row in csv.DictReader(file)]
    return sorted(rows, key=lambda row: [row[name] for name in KEY])


def whole_lines(out: Path) -> int:
    """Rows written so far."""
    path = out / "results.csv"
    return max(path.read_bytes().count(b"\n") - 1, 0) if path.exists() else 0


@pytest.mark.slow
def test_a_sweep_killed_three_times_and_resumed_is_the_sweep_unbroken(tmp_path: Path) -> None:
    whole, torn = tmp_path / "whole", tmp_path / "torn"
    assert evaluate(whole).wait() == 0
    rng = np.random.default_rng(5)
    before, seen = 0, []
    for share in (0.25, 0.5, 0.75):
        wanted = max(round(share * TRIALS) + int(rng.integers(-2, 3)), before + 1)
        process = evaluate(torn, "--resume")
        while whole_lines(torn) < wanted and process.poll() is None:
            time.sleep(0.005)
        assert process.poll() is None, "the sweep was over before it was killed"
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        seen.append(whole_lines(torn))
        assert before < seen[-1] < TRIALS, "some rows are there at the kill, but not all"
        before = seen[-1]
    assert evaluate(torn, "--resume").wait() == 0
    assert len(rows_of(whole)) == TRIALS
    assert rows_of(torn) == rows_of(whole)
    assert not [row["error"] for row in rows_of(whole) if row["error"]]


def test_without_resume_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "results.csv").write_text("something\n")
    assert evaluate(tmp_path).wait() == 2
    assert (tmp_path / "results.csv").read_text() == "something\n"


@pytest.mark.slow
def test_rows_of_other_code_are_mixed_only_on_demand(tmp_path: Path) -> None:
    asked = ("--agents", "random_walk", "--tasks", "home", "--maps", "two_rooms", "--seeds", "1")
    assert evaluate(tmp_path, asked=asked).wait() == 0
    path = tmp_path / "results.csv"
    with path.open(newline="") as file:
        (row,) = csv.DictReader(file)
    path.write_text(path.read_text().replace(row["commit"], "older"))
    refused = evaluate(tmp_path, "--resume", asked=asked)
    _, said = refused.communicate()
    assert refused.returncode == 2
    words = " ".join(said.decode().replace("\u2502", " ").split())
    assert "commit: " in words
    assert "older" in words
    assert evaluate(tmp_path, "--resume", "--mix", asked=asked).wait() == 0
    assert len(rows_of(tmp_path)) == 1
    assert "older" in (tmp_path / "report.html").read_text()


class Fragile(RandomWalkAgent):
    """A random walk that kills its own process in the middle of a walk, once in all."""

    def act(self, observation: Observation) -> np.ndarray[Any, Any]:
        self.steps = getattr(self, "steps", 0) + 1
        if self.steps == 10 and mark_death():
            os.kill(os.getpid(), signal.SIGKILL)
        return super().act(observation)


class Doomed(RandomWalkAgent):
    """A robot that always kills its process."""

    def act(self, observation: Observation) -> np.ndarray[Any, Any]:
        with Path(os.environ[MARKER]).open("a") as file:
            file.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
        return super().act(observation)


def mark_death() -> bool:
    """Whether nobody has died yet; from now on somebody has."""
    try:
        Path(os.environ[MARKER]).touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


@pytest.mark.slow
def test_a_ray_cluster_of_two_workers_one_killed_gives_the_same_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray", reason="Ray is the extra 'cluster'")
    monkeypatch.setenv(MARKER, str(tmp_path / "died"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")  # else it leaves a token in the home folder
    fragile = [
        Trial("tests.test_killed_sweeps:Fragile", "home", "two_rooms", "low", k) for k in range(4)
    ]
    doomed = Trial("tests.test_killed_sweeps:Doomed", "home", "two_rooms", "low", 0)
    rows = sorted(run_on_ray(fragile, "local", 2), key=lambda row: row["seed"])
    assert (tmp_path / "died").exists(), "a worker was killed"
    assert [timeless(row) for row in rows] == [timeless(run_trial(trial)) for trial in fragile]
    assert not [row["error"] for row in rows if row["error"]]
    (tmp_path / "died").write_text("")
    (row,) = run_on_ray([doomed], "local", 2)
    assert "WorkerCrashedError" in row["error"]
    assert (row["success"], row["goals"], row["goals_met"]) == (0, 1, 0)
    assert len((tmp_path / "died").read_text()) == 1 + RETRIES
