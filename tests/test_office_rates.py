"""The script that runs many episodes in offices."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from agents.office_trials import Trial, run_trial
from tests.test_scripts import PNG, run


@pytest.mark.parametrize("arguments", [("--offices", "1000"), ("--difficulty", "absurd")])
def test_a_bad_argument_is_refused_in_words(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    code, said = run("office_rates.py", *arguments, "--out", tmp_path / "out")
    assert code == 2
    assert "expected" in said
    assert not (tmp_path / "out").exists()


def test_trials_of_other_variants_have_other_plans_and_the_same_doors() -> None:
    trials = [
        Trial("explore", 1000, 0, "medium", "easy", v) for v in ("plain", "moved", "mirrored")
    ]
    plain, moved, mirrored = (trial.plan() for trial in trials)
    assert plain.door_names == moved.door_names == mirrored.door_names
    assert plain.home != moved.home != mirrored.home


@pytest.mark.slow
def test_a_failed_run_leaves_a_picture_as_long_as_the_folder_may_hold_it(tmp_path: Path) -> None:
    trial = Trial("noroute", 1000, 0, "medium", "easy", "plain")
    row = run_trial(trial, tmp_path, 1)
    assert set(Trial.__slots__) <= set(row)
    again = run_trial(trial, tmp_path, 0)
    assert {k: row[k] for k in ("doors", "why")} == {k: again[k] for k in ("doors", "why")}
    pictures = [path.read_bytes() for path in tmp_path.iterdir()]
    assert all(picture.startswith(PNG) for picture in pictures)
    assert len(pictures) == (not row["success"])


@pytest.mark.slow
def test_rates_are_resumed_where_they_stood(tmp_path: Path) -> None:
    arguments = ("--offices", "1000:1001", "--difficulty", "easy", "--tasks", "home",
                 "--workers", 1, "--out", tmp_path)  # fmt: skip
    code, said = run("office_rates.py", *arguments, "--seeds", "0:1")
    assert code == 0, said
    first = (tmp_path / "runs.jsonl").read_text()
    code, said = run("office_rates.py", *arguments, "--seeds", "0:2")
    assert code == 0, said
    rows = (tmp_path / "runs.jsonl").read_text()
    assert rows.startswith(first)
    assert [json.loads(line)["seed"] for line in rows.strip().splitlines()] == [0, 1]
    assert "## easy offices" in (tmp_path / "offices.md").read_text()
