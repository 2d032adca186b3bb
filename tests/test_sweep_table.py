"""What the rows of a sweep say, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.metrics import wilson
from cogmap_gym.sweep_table import (
    Row,
    cells,
    counts_by_map,
    duels,
    quartiles,
    rate_of,
    scores_by_map,
)
from tests.sweep_rows import GOALS, SEEN, row


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_goals_are_counted_over_trials() -> None:
    a, b = cells(GOALS, rng())
    assert (a.agent, a.trials, a.failed) == ("a", 2, 0)
    assert a.rate[0] == 7 / 8
    assert a.score[0] == pytest.approx(0.7)
    assert (b.agent, b.failed, b.rate[0], b.score[0]) == ("b", 1, 0.0, 0.0)


def with_end(rows: list[Row], **told: object) -> list[Row]:
    return [*rows, row("a", "goto", "low", 9, **told)]


def test_crashing_is_never_better_than_failing() -> None:
    sound = [row("a", "goto", "low", k, goals=4, goals_met=4, soft_spl=0.9) for k in range(2)]
    missed = {"success": 0, "goals": 4, "goals_met": 0, "soft_spl": 0.0}
    (failed,) = cells(with_end(sound, **missed), rng())
    (broken,) = cells(with_end(sound, **missed, error="Traceback | ValueError"), rng())
    assert (broken.rate, broken.score) == (failed.rate, failed.score)
    assert broken.rate[0] == 8 / 12
    (early,) = cells(with_end(sound, error="Traceback | before its goals were known"), rng())
    assert early.rate[0] == 8 / 9
    assert early.score[0] == failed.score[0] < 0.9


def test_a_broken_exploration_saw_nothing() -> None:
    rows = [
        *SEEN[:1],
        row("a", "explore", "low", 1, success=0, coverage_auc=0.0, error="Traceback"),
    ]
    (cell,) = cells(rows, rng())
    assert cell.rate == (0.5, *wilson(1, 2))
    assert cell.score[0] == pytest.approx(0.45)


def test_one_outcome_a_trial_is_wilsons_and_several_are_not() -> None:
    home = [row("a", "home", "low", k, goals=1, goals_met=k % 2) for k in range(8)]
    assert rate_of(home, rng()) == (0.5, *wilson(4, 8))
    goto = [row("a", "goto", "low", k, goals=4, goals_met=4 * (k % 2)) for k in range(8)]
    rate, low, high = rate_of(goto, rng())
    assert rate == 0.5
    assert high - low > np.ptp(wilson(16, 32)) + 0.2


def test_exploring_is_judged_by_the_trial() -> None:
    low, high = cells(SEEN, rng())
    assert (low.odometry, low.rate[0], low.score[0]) == ("low", 1.0, pytest.approx(0.9))
    assert (high.odometry, high.rate[0]) == ("high", 0.0)


def test_scores_stay_apart_by_map_in_the_order_of_seeds() -> None:
    rows = [row("a", "goto", "low", seed, soft_spl=seed / 10) for seed in (2, 0, 10)]
    rows.append({**row("a", "goto", "low", 0, soft_spl=0.9, goals=3, goals_met=2), "map": "n"})
    first, second = scores_by_map(rows, "soft_spl")
    assert (first.tolist(), second.tolist()) == ([0.0, 0.2, 1.0], [0.9])
    assert counts_by_map(rows)[1].tolist() == [[2, 3]]


def test_robots_are_compared_on_the_trials_that_both_have_run() -> None:
    theirs = [row("b", "goto", "low", k, soft_spl=0.1 * k) for k in range(4)]
    ours = [row("a", "goto", "low", k, soft_spl=0.1 * k + 0.05) for k in (3, 2, 1)]
    ours.append(row("a", "goto", "high", 0, soft_spl=0.0))
    (duel,) = duels([*theirs, *ours], "b", rng())
    assert (duel.agent, duel.task, duel.odometry, duel.trials) == ("a", "goto", "low", 3)
    assert duel.difference == pytest.approx((0.05, 0.05, 0.05))
    assert duel.improvement[0] == pytest.approx(6 / 9)


def test_a_crash_loses_against_the_baseline() -> None:
    theirs = [row("b", "goto", "low", k, soft_spl=0.5) for k in range(2)]
    ours = [row("a", "goto", "low", k, soft_spl=0.0, error="Traceback") for k in range(2)]
    (duel,) = duels([*theirs, *ours], "b", rng())
    assert (duel.difference[0], duel.improvement[0]) == (-0.5, 0.0)


def test_without_the_baseline_there_is_nothing_to_compare() -> None:
    assert duels(GOALS, "nobody", rng()) == []


def test_what_was_never_reached_is_far_and_what_is_not_told_is_left_out() -> None:
    rows = [row("a", "explore", "low", k, **{"distance_90%": d}) for k, d in enumerate((5, "", ""))]
    assert quartiles(rows, "distance_90%") == (math.inf, 5.0, math.inf)
    assert quartiles(
        [{**r, "ate": a} for r, a in zip(rows, ["1", "3", ""], strict=True)], "ate"
    ) == (1.0, 1.0, 1.0)
    assert all(math.isnan(x) for x in quartiles(rows, "ate"))
