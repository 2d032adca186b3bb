"""Algorithm 7: surfaces that came into view after crossing an exit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.crossing import find_crossing, look_from, looks, seen_after_crossing
from agents.cogmap.params import Boundary
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, lengths

SLACK = Boundary().exit_slack
DOOR = np.array([[4.0, -0.5], [4.0, 0.5]])
PATH = np.array([[0.0, 0.0], [2.0, 0.2], [3.5, 0.0], [4.5, 0.0]])


def test_the_crossing_lies_where_path_and_exit_meet() -> None:
    crossing = find_crossing(PATH, DOOR, SLACK)
    np.testing.assert_allclose(crossing.point, (4.0, 0.0))
    np.testing.assert_allclose(crossing.outward, (1.0, 0.0))
    np.testing.assert_allclose(crossing.position, (4.5, 0.0))
    np.testing.assert_allclose(crossing.path[-1, 1], (4.0, 0.0))


def test_the_exit_is_directed_with_the_space_just_left_on_its_left() -> None:
    for door in (DOOR, DOOR[::-1]):
        np.testing.assert_allclose(find_crossing(PATH, door, SLACK).exit, DOOR)


def test_a_look_outside_and_back_is_no_part_of_the_path_inside() -> None:
    path = np.array([[0.0, 0.0], [5.0, 0.1], [3.0, -0.1], [1.0, 1.0], [5.0, -0.2]])
    inside = find_crossing(path, DOOR, SLACK).path
    assert inside[..., 0].max() <= 4.0 + 1e-9
    assert lengths(inside).sum() > 8.0


def test_a_path_that_begins_beyond_the_same_exit_is_cut_at_the_entry() -> None:
    path = np.array([[4.6, 0.1], [3.0, 0.0], [1.0, 1.0], [4.6, 0.0]])
    crossing = find_crossing(path, DOOR, SLACK)
    np.testing.assert_allclose(crossing.path[0, 0, 0], 4.0)
    np.testing.assert_allclose(crossing.exit, DOOR)


def test_a_path_that_misses_the_exit_leaves_at_its_end() -> None:
    path = np.array([[0.0, 3.0], [1.0, 3.0], [3.0, 3.0]])
    crossing = find_crossing(path, DOOR, SLACK)
    assert len(crossing.path) == 2
    np.testing.assert_allclose(crossing.exit, DOOR)


def test_what_is_seen_beyond_the_exit_is_eliminated_and_the_room_kept() -> None:
    beyond = [[6.0, 2.0], [6.0, -2.0]][::-1]
    room = [[0.0, -2.0], [4.0, -2.0]]
    surfaces = np.array([beyond, room])
    for params in (Boundary(), Boundary.literal()):
        gone = seen_after_crossing(surfaces, find_crossing(PATH, DOOR, SLACK), params)
        assert gone.tolist() == [True, False]


def test_the_virtual_line_of_a_slanted_path_takes_no_wall_of_the_room() -> None:
    wall = np.array([[[4.0, 0.8], [4.0, 6.0]]])[:, ::1]
    path = np.array([[2.5, -1.5], [4.4, 0.4]])
    crossing = find_crossing(path, DOOR, SLACK)
    assert not seen_after_crossing(wall, crossing, Boundary())[0]


def test_a_surface_behind_another_exit_is_not_seen_from_the_path() -> None:
    wall = np.array([[[3.0, 2.0], [2.4, 2.0]], [[1.5, 2.0], [-3.0, 2.0]], [[2.2, 5.0], [1.6, 5.0]]])
    exits = np.array([[[1.5, 2.0], [2.4, 2.0]]])
    crossing = find_crossing(PATH, DOOR, SLACK)
    eyes = looks(crossing.path, None, Boundary())
    through = look_from(eyes, wall, crossing.exit, NO_SEGMENTS, Boundary())
    shut = look_from(eyes, wall, crossing.exit, exits, Boundary())
    assert set(shut.rows) == {0, 1, 3}  # row 3 is the exit itself
    assert set(through.rows) == {0, 1}  # a gap as wide as an exit is not seen through either
    wide = wall.copy()
    wide[0] += (0.8, 0.0)
    assert 2 in set(look_from(eyes, wide, crossing.exit, NO_SEGMENTS, Boundary()).rows)


def test_the_weights_of_a_surface_wholly_seen_add_up_to_its_length() -> None:
    wall = np.array([[[3.5, 2.0], [-3.0, 2.0]]])
    crossing = find_crossing(PATH, DOOR, SLACK)
    eyes = looks(crossing.path, None, Boundary())
    sight = look_from(eyes, wall, crossing.exit, NO_SEGMENTS, Boundary())
    np.testing.assert_allclose(sight.weights.sum(), 6.5)


def test_a_surface_shows_only_its_left_side() -> None:
    wall = np.array([[[-3.0, 2.0], [3.5, 2.0]]])
    crossing = find_crossing(PATH, DOOR, SLACK)
    eyes = looks(crossing.path, None, Boundary())
    sight = look_from(eyes, wall, crossing.exit, NO_SEGMENTS, Boundary())
    assert len(sight.rows) == 0


def test_crossings_move_rigidly() -> None:
    move = Pose(-8.0, 3.0, 1.1)
    here = find_crossing(PATH, DOOR, SLACK)
    there = find_crossing(move.apply(PATH), move.apply(DOOR), SLACK)
    np.testing.assert_allclose(move.apply(here.point), there.point)
    np.testing.assert_allclose(move.apply(here.path), there.path)
    np.testing.assert_allclose(move.apply(here.exit), there.exit)


def test_a_sight_over_what_was_never_seen_to_be_free_is_none() -> None:
    wall = np.array([[[3.5, 2.0], [-3.0, 2.0]]])
    crossing = find_crossing(PATH, DOOR, SLACK)
    eyes = looks(crossing.path, None, Boundary())

    def rows(free: bool, params: Boundary) -> int:
        def seen(points: Points) -> NDArray[np.bool_]:
            return np.full(len(points), free)

        return len(look_from(eyes, wall, crossing.exit, NO_SEGMENTS, params, seen).rows)

    assert rows(free=True, params=Boundary()) > 0
    assert rows(free=False, params=Boundary()) == 0
    assert rows(free=False, params=Boundary.literal()) > 0


def test_a_space_is_looked_at_from_where_it_was_looked_at_before_too() -> None:
    path = find_crossing(PATH, DOOR, SLACK).path
    own = looks(path, None, Boundary())
    far, near = np.array([[-2.0, 1.5]]), own[:1] + 0.1
    assert np.array_equal(looks(path, np.concatenate((far, near)), Boundary())[len(own) :], far)
    assert np.array_equal(looks(path, far, Boundary.literal()), own)
    many = np.stack((np.arange(0.0, 100.0, 0.8), np.full(125, 9.0)), axis=-1)
    assert len(looks(path, many, Boundary())) <= 2 * Boundary().max_looks
