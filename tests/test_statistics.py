"""Interquartile means, bootstrap intervals and who beats whom, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.statistics import (
    bootstrap,
    interquartile_mean,
    interquartile_mean_of,
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


def test_scores_that_are_all_the_same_leave_no_doubt() -> None:
    strata = [np.full(5, 0.4), np.full(3, 0.4)]
    assert bootstrap(strata, interquartile_mean_of, rng()) == pytest.approx((0.4, 0.4))


def test_each_map_keeps_its_share() -> None:
    easy, hard = np.ones(10), np.zeros(10)
    low, high = bootstrap([easy, hard], lambda x: float(np.concatenate(x).mean()), rng())
    assert (low, high) == (0.5, 0.5), "within a map nothing varies"
    low, high = bootstrap(
        [np.concatenate((easy, hard))], lambda x: float(np.concatenate(x).mean()), rng()
    )
    assert low < 0.4
    assert high > 0.6


def test_the_interval_of_a_mean_is_about_that_of_the_textbook() -> None:
    scores = np.random.default_rng(2).normal(1.0, 2.0, 400)
    low, high = bootstrap([scores], lambda x: float(np.concatenate(x).mean()), rng())
    half = 1.96 * scores.std() / 20.0
    assert (low, high) == pytest.approx((scores.mean() - half, scores.mean() + half), abs=0.02)


def test_what_is_paired_differs_less_than_what_is_not() -> None:
    luck = np.random.default_rng(3).normal(0.0, 1.0, 50)
    mean, low, high = paired_difference([luck + 0.1], [luck], rng())
    assert (mean, low, high) == pytest.approx((0.1, 0.1, 0.1))
    with pytest.raises(ValueError, match="as many scores"):
        paired_difference([luck], [luck[1:]], rng())


def test_who_wins_more_often_is_likely_the_better() -> None:
    assert probability_of_improvement([np.array([2.0, 3.0])], [np.array([1.0, 2.5])]) == 0.75
    same = [np.array([1.0, 1.0])]
    assert probability_of_improvement(same, same) == 0.5
    two = [np.array([1.0]), np.array([0.0])]
    assert probability_of_improvement(two, two[::-1]) == 0.5
    assert math.isnan(probability_of_improvement([np.zeros(0)], same))


def test_without_scores_nothing_is_claimed() -> None:
    assert all(math.isnan(x) for x in bootstrap([np.zeros(0)], interquartile_mean_of, rng()))
    assert all(math.isnan(x) for x in paired_difference([np.zeros(0)], [np.zeros(0)], rng()))


def test_the_same_chance_gives_the_same_interval() -> None:
    strata = [np.random.default_rng(4).random(9)]
    assert bootstrap(strata, interquartile_mean_of, rng()) == bootstrap(
        strata, interquartile_mean_of, rng()
    )
