"""Interquartile means, bootstrap intervals and who beats whom, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.metrics import wilson
from cogmap_gym.statistics import (
    bootstrap,
    goal_rate,
    interquartile_mean,
    interquartile_mean_of,
    mean_of,
    paired_difference,
    probability_of_improvement,
)


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def test_the_middle_half_of_the_scores_counts() -> None:
    assert interquartile_mean(np.array([0.0, 1.0, 2.0, 100.0])) == 1.5
    assert interquartile_mean(np.arange(8.0)) == pytest.approx((2 + 3 + 4 + 5) / 4)
    assert interquartile_mean(np.array([7.0])) == 7.0
    assert math.isnan(interquartile_mean(np.zeros(0)))
    assert float(interquartile_mean_of([np.array([0.0, 100.0]), np.array([1.0, 2.0])])) == 1.5


def test_a_statistic_of_many_resamples_is_that_of_each() -> None:
    many = np.random.default_rng(0).random((9, 5))
    each = [float(interquartile_mean_of([many[:, k]])) for k in range(5)]
    assert interquartile_mean_of([many]).tolist() == pytest.approx(each)


def test_scores_that_are_all_the_same_leave_no_doubt() -> None:
    strata = [np.full(5, 0.4), np.full(3, 0.4)]
    assert bootstrap(strata, interquartile_mean_of, rng()) == pytest.approx((0.4, 0.4))


def test_each_map_keeps_its_share() -> None:
    easy, hard = np.ones(10), np.zeros(10)
    assert bootstrap([easy, hard], mean_of, rng()) == (0.5, 0.5), "within a map nothing varies"
    low, high = bootstrap([np.concatenate((easy, hard))], mean_of, rng())
    assert low < 0.4
    assert high > 0.6


def test_maps_with_a_single_trial_are_drawn_from_together() -> None:
    apart = [np.array([float(k % 2)]) for k in range(20)]
    assert bootstrap(apart, mean_of, rng()) == bootstrap([np.concatenate(apart)], mean_of, rng())
    assert all(math.isnan(x) for x in bootstrap(apart[:1], mean_of, rng())), "one tells nothing"


def test_the_interval_of_a_mean_is_about_that_of_the_textbook() -> None:
    scores = np.random.default_rng(2).normal(1.0, 2.0, 400)
    low, high = bootstrap([scores], mean_of, rng())
    half = 1.96 * scores.std() / 20.0
    assert (low, high) == pytest.approx((scores.mean() - half, scores.mean() + half), abs=0.02)


def test_goals_of_one_trial_are_no_independent_trials() -> None:
    alike = np.array([[4, 4]] * 10 + [[0, 4]] * 10)
    rate, low, high = goal_rate([alike], rng())
    assert rate == 0.5
    assert (low, high) == pytest.approx(wilson(10, 20), abs=0.04), "20 trials, not 80 goals"
    narrow = wilson(40, 80)
    assert low < narrow[0] < narrow[1] < high


def test_trials_with_more_goals_weigh_more() -> None:
    assert goal_rate([np.array([[1, 1], [0, 3]])], rng())[0] == 0.25


def test_a_rate_without_a_miss_is_as_doubtful_as_its_few_trials() -> None:
    assert goal_rate([np.array([[4, 4]] * 3), np.array([[5, 5]])], rng()) == (1.0, *wilson(4, 4))
    assert goal_rate([np.array([[3, 4]])], rng()) == (0.75, *wilson(0.75, 1))
    assert math.isnan(goal_rate([], rng())[0])


def test_what_is_paired_differs_less_than_what_is_not() -> None:
    luck = np.random.default_rng(3).normal(0.0, 1.0, 50)
    mean, low, high = paired_difference([luck + 0.1], [luck], rng())
    assert (mean, low, high) == pytest.approx((0.1, 0.1, 0.1))
    with pytest.raises(ValueError, match="as many scores"):
        paired_difference([luck], [luck[1:]], rng())


def won(ours: list[float], theirs: list[float]) -> float:
    return probability_of_improvement([np.array(ours)], [np.array(theirs)], rng())[0]


def test_who_wins_more_often_is_likely_the_better() -> None:
    assert won([2.0, 3.0], [1.0, 2.5]) == 0.75
    assert won([1.0, 1.0], [1.0, 1.0]) == 0.5
    two = [np.array([1.0]), np.array([0.0])]
    assert probability_of_improvement(two, two[::-1], rng())[0] == 0.5
    with pytest.raises(ValueError, match="as many scores"):
        probability_of_improvement([np.zeros(0)], [np.zeros(1)], rng())


def test_who_always_wins_wins_in_every_resample_and_doubt_shows_otherwise() -> None:
    better, worse = [np.arange(5.0) + 10.0] * 2, [np.arange(5.0)] * 2
    assert probability_of_improvement(better, worse, rng()) == (1.0, 1.0, 1.0)
    share, low, high = probability_of_improvement([np.arange(9.0)], [np.arange(9.0) + 0.5], rng())
    assert share == pytest.approx(36 / 81)
    assert low < share < high
    singles = [np.array([float(k % 3 > 0)]) for k in range(9)], [np.array([0.5])] * 9
    share, low, high = probability_of_improvement(*singles, rng())
    assert share == pytest.approx(6 / 9)
    assert low < share < high


def test_without_scores_nothing_is_claimed() -> None:
    assert all(math.isnan(x) for x in bootstrap([np.zeros(0)], interquartile_mean_of, rng()))
    assert all(math.isnan(x) for x in paired_difference([np.zeros(0)], [np.zeros(0)], rng()))
    nobody = probability_of_improvement([np.zeros(0)], [np.zeros(0)], rng())
    assert all(math.isnan(x) for x in nobody)


def test_the_same_chance_gives_the_same_interval() -> None:
    strata = [np.random.default_rng(4).random(9)]
    assert bootstrap(strata, interquartile_mean_of, rng()) == bootstrap(
        strata, interquartile_mean_of, rng()
    )
