"""Algorithm 8 and the boundary walk."""

from __future__ import annotations

import numpy as np

from agents.cogmap.boundary import candidates, touches
from agents.cogmap.connection import lay, round_trip
from agents.cogmap.params import Boundary
from agents.cogmap.walk import gather
from cogmap_gym.geometry import NO_SEGMENTS, Pose, Segments

PARAMS = Boundary()


def test_small_surfaces_that_cross_make_a_corner_point_where_they_cross() -> None:
    small = np.array([[[0.0, 0.0], [1.0, 0.0]], [[0.5, -0.5], [0.5, 0.5]]])
    np.testing.assert_allclose(candidates(small, PARAMS).corners, [[0.5, 0.0]])


def test_small_surfaces_nearly_meeting_make_a_corner_point_where_they_would_have_met() -> None:
    small = np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.2, 0.3], [1.2, 1.0]]])
    np.testing.assert_allclose(candidates(small, PARAMS).corners, [[1.2, 0.0]])


def test_collinear_small_surfaces_make_a_corner_point_between_them() -> None:
    small = np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.4, 0.0], [2.0, 0.0]]])
    np.testing.assert_allclose(candidates(small, PARAMS).corners, [[1.2, 0.0]])


def test_small_surfaces_far_apart_and_large_ones_make_no_corner_point() -> None:
    apart = np.array([[[0.0, 0.0], [1.0, 0.0]], [[1.6, 0.0], [2.0, 0.0]]])
    large = np.array([[[0.0, 0.0], [3.0, 0.0]], [[3.0, 0.0], [3.0, 3.0]]])
    assert len(candidates(apart, PARAMS).corners) == 0
    assert len(candidates(large, PARAMS).corners) == 0


def test_large_surfaces_that_cross_lose_their_shorter_parts() -> None:
    large = np.array([[[0.0, 0.0], [4.3, 0.0]], [[4.0, -0.2], [4.0, 3.0]]])
    cut = candidates(large, PARAMS).large
    np.testing.assert_allclose(cut, [[[0.0, 0.0], [4.0, 0.0]], [[4.0, 0.0], [4.0, 3.0]]])


def test_candidates_move_rigidly() -> None:
    rng = np.random.default_rng(3)
    start = rng.uniform(0, 6, (30, 2))
    surfaces = np.stack((start, start + rng.normal(0, 1.2, (30, 2))), axis=1)
    move = Pose(5.0, 9.0, -2.0)
    here, there = candidates(surfaces, PARAMS), candidates(move.apply(surfaces), PARAMS)
    np.testing.assert_allclose(move.apply(here.corners), there.corners, atol=1e-9)
    np.testing.assert_allclose(move.apply(here.large), there.large, atol=1e-9)


def test_nothing_makes_no_candidates() -> None:
    options = candidates(NO_SEGMENTS, PARAMS)
    assert options.corners.shape == (0, 2)
    assert options.large.shape == (0, 2, 2)


def connection(lines: Segments) -> tuple[list[float], list[float], float]:
    """Leaving point, entering point and gap from the first line to the second."""
    leave, enter, gap = lay(lines, np.zeros(2, dtype=np.bool_), 0.6, 2.5, 0.3, 0.34)
    return leave[0, 1].round(9).tolist(), enter[0, 1].round(9).tolist(), float(gap[0, 1])


def test_two_walls_short_of_their_corner_are_lengthened_to_it() -> None:
    lines = np.array([[[0.0, 0.0], [3.0, 0.0]], [[4.0, 0.5], [4.0, 3.0]]])
    assert connection(lines) == ([4.0, 0.0], [4.0, 0.0], 1.5)


def test_two_walls_beyond_their_corner_are_cut_at_it() -> None:
    lines = np.array([[[0.0, 0.0], [4.25, 0.0]], [[4.0, -0.25], [4.0, 3.0]]])
    assert connection(lines) == ([4.0, 0.0], [4.0, 0.0], 0.5)


def test_one_wall_mapped_twice_is_joined_in_the_overlap() -> None:
    lines = np.array([[[0.0, 0.0], [3.0, 0.0]], [[2.5, 0.125], [5.0, 0.125]]])
    assert connection(lines) == ([2.75, 0.0], [2.75, 0.125], 0.125)


def test_pieces_of_one_wall_are_joined_straight() -> None:
    lines = np.array([[[0.0, 0.0], [1.0, 0.0]], [[2.0, 0.0], [3.0, 0.0]]])
    assert connection(lines) == ([1.0, 0.0], [2.0, 0.0], 1.0)


def test_the_cheapest_round_must_turn_once() -> None:
    cost = np.full((3, 3), 5.0)
    cost[0, 1] = cost[1, 0] = 1.0
    turn = np.zeros((3, 3), dtype=np.int64)
    turn[0, 2] = 1
    total, chain = round_trip(cost, turn)
    assert total == 10.0
    assert chain.tolist() == [2]
    assert round_trip(cost, np.zeros_like(turn))[0] == np.inf


def test_an_exit_may_be_followed_either_way_round() -> None:
    door = np.array([[0.0, 0.0], [1.0, 0.0]])
    other = np.array([[[5.0, 0.0], [6.0, 0.0]]])
    items = gather(door, other, other + 2.0)
    np.testing.assert_allclose(items.lines[2], items.lines[1, ::-1])
    assert items.group.tolist() == [0, 1, 1, 2]
    assert items.surface.tolist() == [-1, -1, -1, 0]


def test_a_surface_belongs_to_a_polygon_that_holds_its_middle() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    lines = np.array([[[1.0, 1.0], [2.0, 1.0]], [[4.1, 0.0], [4.1, 4.0]], [[6.0, 0.0], [6.0, 4.0]]])
    assert touches(lines, square, 0.3).tolist() == [True, True, False]
