"""The page of a sweep says what its rows say."""

from __future__ import annotations

import numpy as np
import pytest

from agents.sweep import COLUMNS
from cogmap_gym.sweep_report import cells, curves_figure, drift_figure, report_page, scores_by_map


def row(agent: str, task: str, odometry: str, seed: int, **told: object) -> dict[str, str]:
    base = dict.fromkeys(COLUMNS, "")
    key = {"agent": agent, "task": task, "map": "m", "odometry": odometry, "seed": seed}
    return base | {name: str(value) for name, value in {**key, **told}.items()}


GOALS = [
    row("a", "goto", "low", 0, goals=4, goals_met=3, soft_spl=0.6, cpu_ms=2.0),
    row("a", "goto", "low", 1, goals=4, goals_met=4, soft_spl=0.8, cpu_ms=4.0),
    row("b", "goto", "low", 0, error="Traceback | ValueError: <oops>"),
]
SEEN = [
    row("a", "explore", "low", 0, success=1, area=0.9, curve="0.1;0.9;1.0"),
    row("a", "explore", "high", 0, success=0, area=0.5, curve="0.1;0.5;0.6"),
]


def test_goals_are_counted_over_trials_and_a_broken_trial_is_a_miss() -> None:
    a, b = cells(GOALS, np.random.default_rng(0))
    assert (a.agent, a.trials, a.failed) == ("a", 2, 0)
    assert a.rate[0] == 7 / 8
    assert a.score[0] == pytest.approx(0.7)
    assert a.cpu_ms == 3.0
    assert (b.agent, b.failed, b.rate[0]) == ("b", 1, 0.0)


def test_exploring_is_judged_by_the_trial() -> None:
    low, high = cells(SEEN, np.random.default_rng(0))
    assert (low.odometry, low.rate[0], low.score[0]) == ("low", 1.0, pytest.approx(0.9))
    assert (high.odometry, high.rate[0]) == ("high", 0.0)


def test_scores_stay_apart_by_map_in_the_order_of_seeds() -> None:
    rows = [row("a", "goto", "low", seed, soft_spl=seed / 10) for seed in (2, 0, 1)]
    rows.append({**row("a", "goto", "low", 0, soft_spl=0.9), "map": "n"})
    first, second = scores_by_map(rows, "soft_spl")
    assert (first.tolist(), second.tolist()) == ([0.0, 0.1, 0.2], [0.9])


def test_the_page_holds_all_and_asks_nothing_of_the_network() -> None:
    rows = [*GOALS, *SEEN]
    found = cells(rows, np.random.default_rng(0))
    figures = {"Coverage": curves_figure(rows), "Drift": drift_figure(found)}
    page = report_page(rows, found, {k: v for k, v in figures.items() if v is not None})
    assert page.count("data:image/png;base64,") == 2
    assert "88 % (53-98)" in page
    assert "&lt;oops&gt;" in page
    assert "<oops>" not in page
    assert "http" not in page


def test_what_the_rows_do_not_hold_is_left_out() -> None:
    assert curves_figure(GOALS) is None
    assert drift_figure(cells(GOALS, np.random.default_rng(0))) is None
