"""The tables of many episodes in offices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cogmap_gym.office_comparison import first_difference, paired
from cogmap_gym.office_scores import office_score
from cogmap_gym.office_table import offices_table
from cogmap_gym.table_lines import bootstrap_mean, mean_line, rate_line
from tests.office_rows import RIGHT, moment, outcome, record


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def row(task: str = "goto", office: int = 1000, variant: str = "plain", **goal: Any) -> Any:
    way = [moment(), moment(RIGHT), moment(RIGHT, phase=1, declared=True, status="no route")]
    exploring = task == "explore"
    scored = office_score(record(way, [] if exploring else [outcome(**goal)]), exploring=exploring)
    key = {"task": task, "office": office, "seed": 0, "odometry": "medium"}
    return {**key, "difficulty": "medium", "variant": variant, **scored}


def lines_of(table: str, *words: str) -> list[str]:
    return [line for line in table.splitlines() if all(word in line for word in words)]


def test_rates_of_goals_count_goals_and_those_of_home_count_runs() -> None:
    rows = [row(), row(office=1001, success=False), row("home"), row("explore")]
    table = offices_table(rows, rng())
    assert "1/2 = 50.0%" in lines_of(table, "goto: goals met")[0]
    assert "1/1 = 100.0%" in lines_of(table, "home: within")[0]
    assert "1/1 = 100.0%" in lines_of(table, "explore: 95 %")[0]


def test_a_failure_is_listed_with_office_seed_and_cause() -> None:
    table = offices_table([row(office=1007, success=False)], rng())
    assert lines_of(table, "- goto, office 1007, seed 0: mark 2: said no route")


def test_no_route_is_right_of_unreachable_and_wrong_of_reachable_goals() -> None:
    rows = [row("noroute", reachable=False), row("goto")]
    table = offices_table(rows, rng())
    assert "1/1" in lines_of(table, "unreachable goals: said no route")[0]
    assert "1/1" in lines_of(table, "no route said of a reachable goal")[0]


def test_a_run_that_broke_down_counts_as_a_failure() -> None:
    key = {"office": 1001, "seed": 0, "odometry": "medium", "difficulty": "medium"}
    broken = {**key, "variant": "plain", "success": False, "why": "raised", "raised": "raised"}
    rows = [row("explore"), row(), *({**broken, "task": task} for task in ("explore", "goto"))]
    table = offices_table(rows, rng())
    assert "1/2" in lines_of(table, "explore: 95 %")[0]
    assert "1/2" in lines_of(table, "goto: goals met")[0]
    assert "1/2" in lines_of(table, "goto: failed, raised")[0]


def test_shortcut_paths_are_averaged_over_the_goals_met() -> None:
    rows = [row("shortcut", spl_learning=0.6), row("shortcut", 1001, spl_learning=0.8)]
    rows.append(row("shortcut", 1002, success=False, spl_learning=0.0))
    assert "0.700" in lines_of(offices_table(rows, rng()), "mean SPL")[0]


def test_each_variant_has_a_section_and_the_moved_are_compared() -> None:
    moved = {**row(variant="moved"), "doors": [["E2", 7]]}
    table = offices_table([row(), moved], rng())
    assert len(lines_of(table, "## ")) == 3
    assert "0/1" in lines_of(table, "the same doors")[0]
    assert lines_of(table, "- goto, office 1000, seed 0: other doors from step 1 on")


def test_mirrored_rates_stand_beside_those_with_the_same_fan() -> None:
    rows = [row("goto", k, v) for k in (1000, 1001) for v in ("symmetric", "mirrored")]
    table = offices_table(rows, rng())
    assert lines_of(table, "| goto | 2/2 = 100.0%")[0].count("2/2") == 2


def test_runs_without_a_partner_are_not_paired() -> None:
    rows = [row(), row(variant="moved"), row(office=1001)]
    assert [(a["variant"], b["variant"]) for a, b in paired(rows, "plain", "moved")] == [
        ("plain", "moved")
    ]


@pytest.mark.parametrize(
    ("other", "step"),
    [
        ([["A", 5], ["B", 9]], None),
        ([["A", 7], ["B", 8]], None),
        ([["A", 5], ["C", 8]], 8),
        ([["A", 5]], 9),
        ([], 5),
    ],
)
def test_sequences_differ_from_the_first_other_door_on(other: list[Any], step: int | None) -> None:
    assert first_difference([["A", 5], ["B", 9]], other) == step


def test_a_bootstrap_interval_holds_the_mean_and_is_a_point_for_equal_groups() -> None:
    low, mean, high = bootstrap_mean([[0.2, 0.4], [0.9], [0.6]], rng())
    assert low < mean < high
    assert mean == pytest.approx(0.525)
    assert bootstrap_mean([[0.5]] * 4, rng()) == pytest.approx((0.5, 0.5, 0.5))


def test_figures_without_a_trial_say_so() -> None:
    assert "no trial" in rate_line("x", 0, 0)
    assert mean_line("x", [[]], "", rng()) == "| x | - | |  |\n"
