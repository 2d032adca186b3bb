"""Out and home on a floor plan: a row a run, told apart by what went wrong."""

from __future__ import annotations

import pytest

from agents.plan_trials import PlanTrial, run_plan_trial
from scripts.plan_rates import table


@pytest.mark.slow
def test_the_robot_goes_out_and_comes_home() -> None:
    row = run_plan_trial(PlanTrial("office:1001", 0, "low"))
    assert row["coverage"] >= 0.7
    assert row["home"]
    assert row["success"] == (row["why"] == "")
    assert row["moves_home"] > 0


def test_a_plan_that_cannot_be_run_is_a_row_that_says_why() -> None:
    row = run_plan_trial(PlanTrial('{"image": "nowhere.png", "metres_per_pixel": 0.05}', 0, "low"))
    assert not row["success"]
    assert "nowhere.png" in row["why"]


def test_the_table_counts_small_plans_and_tells_larger_ones_apart() -> None:
    rows = [
        {"plan": "a", "seed": k, "size": size, "success": good, "home": True, "coverage": 0.8,
         "why": "" if good else "saw 60%"}
        for size in (20.0, 100.0) for k, good in enumerate((True, False))
    ]  # fmt: skip
    text = table(rows)
    assert "plans up to 60 m: out and home | 1/2" in text
    assert "plans over 60 m: out and home | 1/2" in text
    assert text.count("saw 60%") == 2
