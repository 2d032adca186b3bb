"""Algorithm 4: landmarks in view, and the worked cases of thesis 3.4."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.cogmap.landmarks import candidates, compare, find_landmarks
from agents.cogmap.params import Landmarks
from cogmap_gym.geometry import Pose, Segments
from tests.simulated import mirrored, segments

LITERAL = Landmarks(literal=True)
BOTH = pytest.mark.parametrize("params", [Landmarks(), LITERAL], ids=["default", "literal"])
ANGLES = st.floats(-math.pi, math.pi)
METRES = st.floats(-20.0, 20.0)


def random_surfaces(seed: int, count: int) -> Segments:
    rng = np.random.default_rng(seed)
    starts, along = rng.uniform(-5, 5, (count, 2)), rng.uniform(0, 2 * np.pi, count)
    steps = rng.uniform(0.5, 4.0, count)[:, None] * np.stack((np.cos(along), np.sin(along)), -1)
    return np.stack((starts, starts + steps), axis=1)


def turned(surface: Segments, degrees: float) -> Segments:
    """The surface turned about its middle."""
    middle = surface.mean(axis=(0, 1))
    pose = Pose(*middle, math.radians(degrees)) @ Pose(*-middle, 0.0)
    return pose.apply(surface)


def test_figure_3_10_lines_stand_each_half_metre_along_x_from_its_end() -> None:
    y = segments((-10, 0.3, 10, 0.3))
    for length, lines in ((0.4, 1), (0.5, 2), (1.2, 3), (2.0, 5), (2.5, 6)):
        assert compare(segments((0, 0, length, 0)), y, LITERAL).hits.tolist() == [[lines]]


def test_figure_3_10_lines_reach_one_metre_to_both_sides() -> None:
    x = segments((0, 0, 2, 0))
    for away, hits in ((0.99, 5), (-0.99, 5), (1.01, 0), (-1.01, 0)):
        y = segments((-1, away, 3, away))
        assert compare(x, y, LITERAL).hits.tolist() == [[hits]]


def test_figure_3_10_only_lines_that_meet_the_candidate_itself_count() -> None:
    x, y = segments((0, 0, 3, 0)), segments((0.9, 0.2, 2.1, 0.2))
    assert compare(x, y, LITERAL).hits.tolist() == [[3]]  # those at 1.0, 1.5 and 2.0 m


def test_more_than_five_lines_are_strong_evidence_and_five_are_weak() -> None:
    slanted = 20.0  # degrees: no similar orientation
    y = segments((-10, 0, 10, 0))
    weak = turned(segments((0, 0, 2.0, 0)), slanted)
    strong = turned(segments((0, 0, 2.5, 0)), slanted)
    assert compare(np.concatenate((weak, strong)), y, LITERAL).hits.ravel().tolist() == [5, 6]
    assert find_landmarks(np.concatenate((weak, strong)), y, LITERAL).tolist() == [-1, 0]


@pytest.mark.parametrize(("degrees", "found"), [(0.0, 0), (9.9, 0), (-9.9, 0), (10.1, -1)])
def test_weak_evidence_asks_for_an_orientation_within_ten_degrees(
    degrees: float, found: int
) -> None:
    x, y = turned(segments((0, 0.1, 1, 0.1)), degrees), segments((-2, 0, 3, 0))
    for params in (Landmarks(), LITERAL):
        assert find_landmarks(x, y, params).tolist() == [found]


def test_strong_evidence_has_a_limit_of_turn_but_not_as_written() -> None:
    x, y = turned(segments((-2, 0, 2, 0)), 25.0), segments((-5, 0, 5, 0))
    assert find_landmarks(x, y, LITERAL).tolist() == [0]
    assert find_landmarks(x, y, Landmarks()).tolist() == [-1]


def test_the_back_of_a_wall_is_another_surface_but_not_as_written() -> None:
    x, y = segments((0, 0, 3, 0)), segments((3, 0.1, 0, 0.1))
    assert find_landmarks(x, y, LITERAL).tolist() == [0]
    assert find_landmarks(x, y, Landmarks()).tolist() == [-1]


@BOTH
def test_of_many_candidates_the_most_similar_orientation_is_chosen(params: Landmarks) -> None:
    flat = segments((0, 0.2, 3, 0.2))
    y = np.concatenate((turned(flat, 6.0), turned(flat, 1.0), turned(flat, -4.0)))
    assert find_landmarks(segments((0, 0, 3, 0)), y, params).tolist() == [1]


def test_of_parallel_candidates_the_nearest_is_chosen() -> None:
    y = segments((0, 0.5, 3, 0.5), (0, 0.05, 3, 0.05), (0, -0.3, 3, -0.3))
    assert find_landmarks(segments((0, 0, 3, 0)), y, Landmarks()).tolist() == [1]


@BOTH
def test_figure_3_11_three_pieces_of_one_old_surface_are_all_that_surface(
    params: Landmarks,
) -> None:
    old = segments((0, 0, 9, 0), (9, 0, 9, 4))
    pieces = segments((0.1, 0.1, 2.5, 0.15), (3.4, 0.1, 5.2, 0.2), (6.5, 0.1, 8.8, 0.2))
    assert find_landmarks(pieces, old, params).tolist() == [0, 0, 0]


@BOTH
def test_figure_3_11_one_surface_over_three_old_pieces_is_one_of_them(params: Landmarks) -> None:
    pieces = turned(segments((0.0, 0, 2.5, 0), (3.4, 0, 5.2, 0), (6.5, 0, 8.8, 0)), 2.0)
    whole = pieces.mean(axis=(0, 1)) + np.array([[[-4.5, 0.1], [4.5, 0.1]]])
    assert (candidates(compare(whole, pieces, params), params)).all()
    assert find_landmarks(whole, pieces, params)[0] in (0, 1, 2)


@BOTH
def test_what_is_apart_along_its_own_line_is_no_landmark(params: Landmarks) -> None:
    x, y = segments((0, 0, 2, 0)), segments((2.6, 0, 5, 0))
    assert find_landmarks(x, y, params).tolist() == [-1]


@BOTH
def test_without_surfaces_there_is_no_landmark(params: Landmarks) -> None:
    none, some = np.zeros((0, 2, 2)), segments((0, 0, 2, 0))
    assert find_landmarks(none, some, params).shape == (0,)
    assert find_landmarks(some, none, params).tolist() == [-1]
    assert find_landmarks(none, none, params).shape == (0,)


@BOTH
def test_every_surface_is_its_own_landmark(params: Landmarks) -> None:
    surfaces = random_surfaces(7, 30)
    assert find_landmarks(surfaces, surfaces, params).tolist() == list(range(30))


@BOTH
@given(seed=st.integers(0, 999), theta=ANGLES, x=METRES, y=METRES)
def test_landmarks_do_not_depend_on_where_the_origin_is(
    params: Landmarks, seed: int, theta: float, x: float, y: float
) -> None:
    moved, old = Pose(x, y, theta), random_surfaces(seed, 8)
    seen = Pose(0.05, -0.04, 0.02).apply(old)
    here, there = compare(seen, old, params), compare(moved.apply(seen), moved.apply(old), params)
    assert (np.abs(here.hits - there.hits) <= 1).all()  # a line may just touch an end
    assert there.turn == pytest.approx(here.turn, abs=1e-6)
    assert there.offset == pytest.approx(here.offset, abs=1e-6)
    assert there.overlap == pytest.approx(here.overlap, abs=1e-6)


@BOTH
@given(seed=st.integers(0, 999))
def test_landmarks_do_not_depend_on_the_order_of_rows(params: Landmarks, seed: int) -> None:
    old, rng = random_surfaces(seed, 9), np.random.default_rng(seed)
    seen = Pose(0.1, -0.05, 0.03).apply(old)
    match = find_landmarks(seen, old, params)
    rows, columns = rng.permutation(9), rng.permutation(9)
    shuffled = find_landmarks(seen[rows], old[columns], params)
    named = np.where(shuffled >= 0, columns[shuffled], -1)
    assert named.tolist() == match[rows].tolist()


@given(seed=st.integers(0, 999))
def test_a_mirrored_scene_is_compared_as_its_mirror_image(seed: int) -> None:
    old = random_surfaces(seed, 6)
    seen = Pose(0.1, -0.05, 0.03).apply(old)
    here = compare(seen, old, Landmarks())
    there = compare(mirrored(seen), mirrored(old), Landmarks())
    assert there.turn == pytest.approx(-here.turn, abs=1e-9)
    assert there.offset == pytest.approx(here.offset, abs=1e-9)
    assert there.overlap == pytest.approx(here.overlap, abs=1e-9)
