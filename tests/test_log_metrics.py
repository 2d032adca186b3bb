"""Scores of pose sequences against corrected poses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cogmap_gym import log_metrics
from cogmap_gym.carmen import read_carmen
from cogmap_gym.geometry import Pose, relative_poses

LOGS = Path(__file__).parents[1].parent / "shared" / "data" / "logs"
needs_logs = pytest.mark.skipif(not LOGS.is_dir(), reason="no recordings in ../shared/data/logs")
coordinates = st.floats(-100, 100)
motions = st.builds(Pose, coordinates, coordinates, st.floats(-math.pi, math.pi))


def line(metres: int) -> np.ndarray:
    """A straight drive along x, a pose a metre."""
    return np.column_stack((np.arange(metres + 1.0), np.zeros(metres + 1), np.zeros(metres + 1)))


def moved(motion: Pose, poses: np.ndarray) -> np.ndarray:
    turned = motion.apply(poses[:, :2])
    return np.column_stack((turned, poses[:, 2] + motion.theta))


def circles(rng: np.random.Generator, laps: int = 2) -> np.ndarray:
    """Laps round a circle of 5 m radius, with a little noise."""
    angle = np.linspace(0.0, laps * math.tau, 60 * laps)
    poses = np.column_stack((5 * np.cos(angle), 5 * np.sin(angle), angle + math.pi / 2))
    return poses + rng.normal(0.0, 0.02, poses.shape)


def test_relative_poses_agree_with_composing_poses() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-9, 9, (2, 50, 3))
    for row, p, q in zip(relative_poses(a, b), a, b, strict=True):
        wanted = Pose(*p).inverse() @ Pose(*q)
        np.testing.assert_allclose(row, (wanted.x, wanted.y, wanted.theta), atol=1e-9)


def test_a_scale_error_of_one_tenth_is_one_metre_over_ten() -> None:
    reference = line(30)
    poses = reference * (1.1, 1.0, 1.0)
    errors = log_metrics.relative_errors(poses, reference, np.arange(31))
    np.testing.assert_allclose(errors, np.ones(21))
    metres, radians = log_metrics.adjacent_errors(poses, reference, np.arange(31), spacing=2.0)
    np.testing.assert_allclose(metres, np.full(15, 0.2))
    np.testing.assert_allclose(radians, np.zeros(15))


def test_the_pair_is_the_first_pose_at_least_the_travel_later() -> None:
    reference = line(30)
    poses = reference.copy()
    poses[11:, 1] += 0.5
    errors = log_metrics.relative_errors(poses, reference, np.arange(31), travel=9.5)
    np.testing.assert_allclose(errors, [0.0] + [0.5] * 10 + [0.0] * 10)


def test_travel_runs_along_all_corrected_poses_when_few_are_scored() -> None:
    there_and_back = np.vstack((line(10), line(10)[-2::-1]))
    ends = np.array([0, 20])
    errors = log_metrics.relative_errors(there_and_back[ends], there_and_back, ends)
    np.testing.assert_allclose(errors, [0.0])


@given(motions, motions)
def test_scores_do_not_depend_on_either_origin(a: Pose, b: Pose) -> None:
    rng = np.random.default_rng(2)
    reference = circles(rng)
    poses = reference + np.cumsum(rng.normal(0, 0.01, reference.shape), axis=0)
    index = np.arange(len(poses))
    here = log_metrics.score_poses(poses, reference, index)
    there = log_metrics.score_poses(moved(a, poses), moved(b, reference), index)
    for name in ("relative", "key_metres", "key_degrees", "revisit_mean", "absolute"):
        assert getattr(there, name) == pytest.approx(getattr(here, name), abs=1e-6)


def test_revisits_are_the_pairs_a_lap_apart_and_show_the_drift() -> None:
    reference = circles(np.random.default_rng(3))
    index = np.arange(len(reference))
    assert np.all(log_metrics.revisit_errors(reference, reference, index) == 0.0)
    drifted = reference + np.outer(index >= 60, (3.0, 0.0, 0.0))
    errors = log_metrics.revisit_errors(drifted, reference, index)
    assert len(errors) > 50
    assert np.median(errors) == pytest.approx(3.0, abs=0.1)


@given(motions)
def test_a_rigid_fit_finds_the_motion_that_was_made(motion: Pose) -> None:
    points = np.random.default_rng(4).normal(0.0, 5.0, (20, 2))
    fit = log_metrics.rigid_fit(points, motion.apply(points))
    np.testing.assert_allclose(fit.apply(points), motion.apply(points), atol=1e-9)


def test_a_rigid_fit_never_mirrors_or_scales() -> None:
    points = np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0), (5.0, 1.0)])
    for target in (points * (1, -1), 3 * points):
        fitted = log_metrics.rigid_fit(points, target).apply(points)
        steps = np.diff(points, axis=0)
        np.testing.assert_allclose(
            np.hypot(*np.diff(fitted, axis=0).T), np.hypot(*steps.T), atol=1e-12
        )


def test_one_pose_has_no_pairs_and_scores_nan() -> None:
    score = log_metrics.score_poses(line(0), line(0), np.array([0]))
    assert math.isnan(score.relative)
    assert math.isnan(score.revisit_median)
    assert score.absolute == 0.0


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "line 1: expected a column scan_index"),
        ("scan_index,x,y\n0,1,2\n", "expected a column theta"),
        ("scan_index,x,y,theta\n", "expected at least one row"),
        ("scan_index,x,y,theta\n0,1,nan,0\n", "line 2, y: expected a finite number, got 'nan'"),
        ("scan_index,x,y,theta\n0,1,2\n", "line 2, theta: expected a finite number, got None"),
        ("scan_index,x,y,theta\n1,0,0,0\n1,0,0,0\n", "line 3, scan_index: expected whole, incr"),
        ("scan_index,x,y,theta\n0.5,0,0,0\n", "line 2, scan_index: expected whole"),
    ],
)
def test_a_bad_table_is_refused_with_its_line_and_column(
    tmp_path: Path, text: str, named: str
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=named) as refusal:
        log_metrics.read_corrected(path)
    assert "bad.csv" in str(refusal.value)


@needs_logs
@pytest.mark.parametrize(
    ("name", "relative", "key_metres", "key_degrees", "mean", "median"),
    [
        ("csail_dense", 0.934, 0.063, 3.2, 11.0, 10.1),
        ("aces", 0.470, 0.066, 1.0, 4.5, 0.57),
    ],
)
def test_raw_odometry_has_the_errors_that_were_measured_before(
    name: str, relative: float, key_metres: float, key_degrees: float, mean: float, median: float
) -> None:
    log = read_carmen(LOGS / f"{name}.clf.gz")
    corrected = log_metrics.read_corrected(LOGS / f"{name}.corrected.csv")
    score = log_metrics.score_poses(log.poses_odometry, corrected.poses, corrected.scan_index)
    assert score.relative == pytest.approx(relative, abs=0.001)
    assert score.key_metres == pytest.approx(key_metres, abs=0.0005)
    assert score.key_degrees == pytest.approx(key_degrees, abs=0.05)
    assert score.revisit_mean == pytest.approx(mean, abs=0.05)
    assert score.revisit_median == pytest.approx(median, abs=0.05)
