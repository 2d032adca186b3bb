"""Scores of trials, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from cogmap_gym.trial_scores import (
    coverage_curve,
    curve_area,
    distance_area,
    distance_curve,
    distance_to,
    goal_scores,
    horizon,
    soft_spl,
)

SEEN = np.array([0.0, 0.5, 1.0])


@pytest.mark.parametrize(
    ("oracle", "driven", "final", "score"),
    [
        (10.0, 10.0, 0.0, 1.0),
        (10.0, 20.0, 0.0, 0.5),
        (10.0, 10.0, 5.0, 0.5),
        (10.0, 20.0, 5.0, 0.25),
        (10.0, 3.0, 15.0, 0.0),
        (0.0, 1.0, 0.0, 1.0),
        (0.0, 1.0, 2.0, 0.0),
    ],
)
def test_soft_spl_is_progress_times_the_share_of_the_way(
    oracle: float, driven: float, final: float, score: float
) -> None:
    assert soft_spl(oracle, driven, final) == pytest.approx(score)


def test_a_curve_stays_as_it_ended() -> None:
    assert coverage_curve(SEEN, 4, 5).tolist() == [0.0, 0.5, 1.0, 1.0, 1.0]
    assert curve_area(SEEN, 4) == pytest.approx((0.0 + 0.5 + 1.0 + 1.0 + 1.0) / 5)
    assert curve_area(SEEN[:1], 4) == 0.0


def test_coverage_is_averaged_over_the_way() -> None:
    driven = np.array([0.0, 3.0, 7.0])
    assert distance_area(SEEN, driven, 10.0) == pytest.approx((3 * 0.0 + 4 * 0.5 + 3 * 1.0) / 10)
    assert distance_area(SEEN, driven, 5.0) == pytest.approx((3 * 0.0 + 2 * 0.5) / 5)
    assert distance_area(SEEN[:2], driven[:2], 5.0) == pytest.approx(2 * 0.5 / 5), "it stands"
    with pytest.raises(ValueError, match=r"expected metres above 0, got 0\.0"):
        distance_area(SEEN, driven, 0.0)


def test_the_distance_to_a_share_is_told_once_it_was_seen() -> None:
    driven = np.array([0.0, 3.0, 7.0])
    assert distance_to(0.5, SEEN, driven) == 3.0
    assert distance_to(0.9, SEEN, driven) == 7.0
    assert distance_to(0.9, SEEN[:2], driven[:2]) is None


def test_goals_are_scored_together_and_one_never_begun_counts_nothing() -> None:
    phases = [
        {"success": True, "oracle_length": 10.0, "path_length": 20.0},
        {"success": False, "oracle_length": 10.0, "path_length": 10.0},
        {"success": False, "oracle_length": -1.0, "path_length": 0.0},
    ]
    info = {
        "final_distance": np.array([-1.0, -1.0, 0.0, 5.0, -1.0]),
        "spl": np.array([-1.0, -1.0, 0.5, 0.0, -1.0]),
        "spl_learning": np.array([-1.0, -1.0, 1.0, 0.0, -1.0]),
    }
    scores = goal_scores(phases, info, [2, 3, 4])
    assert (scores["goals"], scores["goals_met"]) == (3, 1)
    assert scores["spl"] == pytest.approx(0.5 / 3)
    assert scores["spl_learning"] == pytest.approx(1.0 / 3)
    assert scores["soft_spl"] == pytest.approx((0.5 + 0.5 + 0.0) / 3)
    assert goal_scores([], info, [])["goals"] is None


def test_a_goal_that_was_never_begun_is_missed() -> None:
    phases = [{"success": True, "oracle_length": 10.0, "path_length": 10.0}]
    info = {
        "final_distance": np.array([-1.0, -1.0, 0.0, -1.0]),
        "spl": np.array([-1.0, -1.0, 1.0, -1.0]),
        "spl_learning": np.array([-1.0, -1.0, 1.0, -1.0]),
    }
    scores = goal_scores(phases, info, [2, 3])
    assert (scores["goals"], scores["goals_met"]) == (2, 1)
    assert (scores["spl"], scores["soft_spl"]) == (0.5, 0.5)


def test_coverage_against_distance_by_hand() -> None:
    driven = np.array([0.0, 2.0, 5.0])
    assert distance_curve(SEEN, driven, 8.0, 5).tolist() == [0.0, 0.5, 0.5, 1.0, 1.0]
    assert distance_area(SEEN, driven, 8.0) == pytest.approx((0.0 * 2 + 0.5 * 3 + 1.0 * 3) / 8)
    assert distance_area(SEEN, driven, 4.0) == pytest.approx((0.0 * 2 + 0.5 * 2) / 4)


def test_who_turns_on_the_spot_is_given_what_it_sees_there() -> None:
    turning = np.zeros(3)
    assert distance_area(SEEN, turning, 10.0) == 1.0
    assert distance_curve(SEEN, turning, 10.0, 3).tolist() == [1.0, 1.0, 1.0]


def test_the_horizon_grows_with_the_tour() -> None:
    assert (horizon(0.0), horizon(50.0)) == (10.0, 200.0)
