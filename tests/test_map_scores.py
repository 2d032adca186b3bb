"""Scores of remembered maps and of poses, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.cognitive_map_scores import bidimensional_regression, pointing_errors
from cogmap_gym.geometry import Pose
from cogmap_gym.pose_scores import pose_scores

CROSS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])


def test_a_map_that_is_larger_turned_and_shifted_is_not_distorted() -> None:
    remembered = 2.0 * Pose(3.0, -1.0, 0.3).apply(CROSS)
    found = bidimensional_regression(remembered, CROSS)
    assert found is not None
    assert (found.scale, found.turn) == pytest.approx((2.0, 0.3))
    assert found.distortion == pytest.approx(0.0, abs=1e-5)


def test_a_map_stretched_one_way_is_distorted() -> None:
    found = bidimensional_regression(CROSS * (2.0, 1.0), CROSS)
    assert found is not None
    assert found.scale == pytest.approx(1.5), "(2 + 2 + 1 + 1) / 4"
    assert found.distortion == pytest.approx(100.0 * math.sqrt(0.1)), "1.5^2 4 of 10 explained"


def test_a_mirrored_cross_is_all_distortion() -> None:
    found = bidimensional_regression(CROSS * (1.0, -1.0), CROSS)
    assert found is not None
    assert (found.scale, found.distortion) == pytest.approx((0.0, 100.0))


def test_too_few_places_or_all_at_one_spot_tell_nothing() -> None:
    assert bidimensional_regression(CROSS[:2], CROSS[:2]) is None
    assert bidimensional_regression(np.zeros((4, 2)), CROSS) is None
    assert bidimensional_regression(CROSS, np.ones((4, 2))) is None


def test_pointing_is_judged_by_the_angle_in_any_frame() -> None:
    true, places = Pose(5.0, 5.0, math.pi / 2), {1: np.array((5.0, 9.0)), 2: np.array((1.0, 5.0))}
    believed = Pose(0.0, 0.0, 0.0)
    remembered = {1: np.array((4.0, 0.0)), 2: np.array((3.0, 3.0))}
    found = pointing_errors(believed, remembered, true, places)
    assert found == pytest.approx({1: 0.0, 2: math.pi / 4}), "2 is to the left, not ahead of it"


def test_nobody_points_to_what_is_here_or_forgotten() -> None:
    here, near, far = Pose(), np.array((0.5, 0.0)), np.array((5.0, 0.0))
    assert pointing_errors(here, {1: near, 2: far}, here, {1: far, 2: near, 3: far}) == {}


def test_errors_of_poses_after_one_rigid_fit() -> None:
    true = np.array([(-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    told = pose_scores(true * (2.0, 1.0, 1.0), true)
    assert told["ate"] == pytest.approx(math.sqrt(2.0 / 3.0))
    assert told["rpe"] is None, "the way is shorter than 10 m"


def test_errors_of_motions_over_ten_metres() -> None:
    true = np.zeros((31, 3))
    true[:, 0] = np.arange(31.0)
    told = pose_scores(true * (1.1, 1.0, 1.0), true)
    assert told["rpe"] == pytest.approx(1.0), "a tenth of 10 m"
    moved = np.array([(*Pose(4.0, 2.0, 1.0).apply(p[:2]), p[2] + 1.0) for p in true])
    assert pose_scores(moved, true) == pytest.approx({"ate": 0.0, "rpe": 0.0})
