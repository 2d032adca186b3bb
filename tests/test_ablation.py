"""The ablation: its parameter sets, its table, and the script that makes it."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

import pytest

from agents.ablation import ORDER, changed_groups, ladder, left_out
from agents.cogmap.params import Params
from agents.trials import Trial, read_rows, run_missing, seeds_of
from cogmap_gym.ablation_report import COLUMNS, ablation_figure, ablation_table, counted
from cogmap_gym.saving import save_png
from cogmap_gym.score_table import broken

ROOT = Path(__file__).parents[1]
PNG = b"\x89PNG"


def different(a: Params, b: Params) -> set[str]:
    return {f.name for f in fields(Params) if getattr(a, f.name) != getattr(b, f.name)}


def rows_of(params: str, seed: int, *, well: bool) -> list[dict[str, object]]:
    """A fabricated run of each experiment."""
    return [
        {"experiment": k, "odometry": "medium", "seed": seed, "params": params,
         **broken(k, "", ""), **dict.fromkeys(("a", "goals"), well)}
        for k in (1, 2, 3)
    ]  # fmt: skip


# The parameter sets


def test_the_ladder_leads_from_the_text_to_the_default_and_each_rung_changes_something() -> None:
    rungs = [variant.params for variant in ladder()]
    assert rungs[0] == Params.literal()
    assert rungs[-1] == Params()
    steps = [different(a, b) for a, b in pairwise(rungs)]
    assert steps == [set(rung) for rung in changed_groups()]
    assert all(steps)


def test_no_group_of_parameters_is_forgotten_and_none_is_changed_twice() -> None:
    names = [name for rung in changed_groups() for name in rung]
    assert len(names) == len(set(names))
    assert set(names) == different(Params.literal(), Params())


def test_the_order_names_groups_that_exist() -> None:
    assert {name for rung in ORDER for name in rung} <= {field.name for field in fields(Params)}


def test_each_repair_is_taken_out_alone() -> None:
    default, *others = left_out()
    assert default.params == Params()
    literal = Params.literal()
    for rung, variant in zip(changed_groups(), others, strict=True):
        assert different(variant.params, Params()) == set(rung)
        assert different(variant.params, literal).isdisjoint(rung)


def test_the_same_parameters_have_one_key_whatever_they_are_called() -> None:
    assert ladder()[-1].key == left_out()[0].key
    assert len({variant.key for variant in ladder()}) == len(ladder())


# Table and figure


def test_the_table_has_a_row_a_parameter_set_and_a_column_a_question() -> None:
    rows = [*rows_of("p", 1, well=True), *rows_of("p", 2, well=False), *rows_of("q", 1, well=True)]
    assert counted(rows, "p", "exp 1 (a)") == (1, 2)
    assert counted(rows, "p", "exp 3 goals") == (1, 2)
    assert counted(rows, "q", "exp 3 own doors, network") == (0, 1)
    table = ablation_table(rows, {"One": [("first", "p")], "Two": [("second", "q"), ("none", "r")]})
    lines = table.splitlines()
    assert lines[0] == "## One"
    assert all(line.count("|") == len(COLUMNS) + 2 for line in lines if line.startswith("|"))
    assert "| first | 1/2 (9-91) | 0/2 (0-66) |" in table
    assert "| none | - |" in table


@pytest.mark.parametrize("rows", [[], rows_of("p", 1, well=True)], ids=["none", "some"])
def test_the_figure_can_be_drawn_with_and_without_runs(
    tmp_path: Path, rows: list[dict[str, object]]
) -> None:
    figure = ablation_figure(rows, {"One": [("first", "p"), ("second", "q")]}, "title")
    assert save_png(figure, tmp_path / "a.png").read_bytes().startswith(PNG)


# Trials


def test_a_range_of_seeds_is_read_and_anything_else_refused() -> None:
    assert list(seeds_of("1000:1002")) == [1000, 1001]
    for text in ("1000", "a:b", "2:2", "3:1", "-1:2", ""):
        with pytest.raises(ValueError, match="FIRST:LAST"):
            seeds_of(text)


def test_a_trial_with_an_unknown_odometry_is_refused() -> None:
    with pytest.raises(ValueError, match="wonderful"):
        Trial(1, "wonderful", 1000, Params())


def test_trials_that_have_a_row_are_not_run_again_and_a_cut_row_does_not_count(
    tmp_path: Path,
) -> None:
    path = tmp_path / "runs.jsonl"
    trials = [Trial(1, "medium", seed, Params(), {"params": "p"}) for seed in (1000, 1001)]
    path.write_text("\n".join(json.dumps({**trial.key, "a": True}) for trial in trials))
    counts: list[int] = []

    def watch(rows, count):
        counts.append(count)
        return rows

    assert run_missing(trials, 1, path, watch)
    path.write_text(path.read_text()[:-5])
    assert len(read_rows(path)) == 1
    assert counts == [0]


def test_ctrl_c_while_waiting_ends_the_runs_in_peace(tmp_path: Path) -> None:
    def watch(rows, count):
        raise KeyboardInterrupt

    trial = Trial(1, "medium", 1000, Params())
    assert run_missing([trial], 1, tmp_path / "runs.jsonl", watch) is False


# The scripts


def run(script: str, *arguments: object) -> tuple[int, str]:
    command = [sys.executable, str(ROOT / "scripts" / script), *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("script", "bad"),
    [("rates.py", ("--odometry", "wonderful")), ("ablation.py", ("--seeds", "7"))],
)
def test_a_bad_argument_of_a_sweep_is_refused_in_words(
    tmp_path: Path, script: str, bad: tuple[str, str]
) -> None:
    code, said = run(script, *bad, "--out", tmp_path / "out")
    assert code == 2
    assert "Traceback" not in said
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_rates_of_experiment_3_leave_rows_and_a_table(tmp_path: Path) -> None:
    wanted = ("--experiment", 3, "--odometry", "low", "--seeds", "1000:1001", "--workers", 1)
    code, said = run("rates.py", *wanted, "--out", tmp_path)
    assert code == 0, said
    (row,) = read_rows(tmp_path / "runs.jsonl")
    assert (row["experiment"], row["seed"]) == (3, 1000)
    assert "raised" not in row
    table = (tmp_path / "rates.md").read_text()
    assert "## Experiment 3, low odometry, default parameters, 1 runs" in table
    assert "Failures by stage and cause" in table
    pictures = list(tmp_path.glob("failures/exp3_low_1000.png"))
    assert len(pictures) == bool(row["failures"])
    before = (tmp_path / "runs.jsonl").read_bytes()
    assert run("rates.py", *wanted, "--out", tmp_path)[0] == 0
    assert (tmp_path / "runs.jsonl").read_bytes() == before


@pytest.mark.slow
def test_a_run_that_raises_is_a_failed_row(tmp_path: Path) -> None:
    no_number = replace(Params(), exploration=None)  # type: ignore[arg-type]
    trial = Trial(3, "medium", 1000, no_number, {"params": "none"})
    assert run_missing([trial], 1, tmp_path / "runs.jsonl", lambda rows, _: rows)
    (row,) = read_rows(tmp_path / "runs.jsonl")
    assert row["raised"].startswith("AttributeError")
    assert row["failures"][0][:2] == ["1 lap", "raised"]
    assert not row["goals"]


@pytest.mark.slow
def test_the_ablation_runs_what_is_missing_and_leaves_table_and_figure(tmp_path: Path) -> None:
    keys = {variant.key for variant in (*ladder(), *left_out())} - {ladder()[-1].key}
    rows = [row for key in keys for row in rows_of(key, 1000, well=True)]
    (tmp_path / "runs.jsonl").write_text("\n".join(json.dumps(row) for row in rows))
    code, said = run("ablation.py", "--seeds", "1000:1001", "--experiment", 1, "--out", tmp_path)
    assert code == 0, said
    added = read_rows(tmp_path / "runs.jsonl")[len(rows) :]
    assert [(row["experiment"], row["params"]) for row in added] == [(1, ladder()[-1].key)]
    table = (tmp_path / "ablation.md").read_text()
    assert all(f"| {variant.name} |" in table for variant in (*ladder(), *left_out()))
    assert (tmp_path / "ablation.png").read_bytes().startswith(PNG)
