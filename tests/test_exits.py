"""Remembered exits, and the moment one is crossed (thesis 3.3, 3.5)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.cogmap.exit_sight import reach_to_exits, seen_through_exit
from agents.cogmap.exits import (
    NOWHERE,
    Book,
    Exit,
    crossed_exit,
    match_exit,
    remember_exits,
    rename_place,
    replace_exit,
)
from agents.cogmap.params import Exits
from cogmap_gym.geometry import Points, Pose, Segments
from tests.simulated import segments

P = Exits()
DOOR = segments((0, 0, 0, 1))
"""A doorway along y: its left is at x < 0."""
NONE: Segments = np.zeros((0, 2, 2))
ANYWHERE = st.builds(Pose, st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1))


def book(lines: Segments = DOOR, left: int = 1, right: int = NOWHERE, sightings: int = 2) -> Book:
    return tuple(Exit(k + 1, line, left, right, sightings, -1) for k, line in enumerate(lines))


def path(*points: tuple[float, float]) -> Points:
    return np.array(points, dtype=np.float64)


def crossing(way: Points, exits: Book | None = None) -> int | None:
    found = crossed_exit(book() if exits is None else exits, way, P)
    return None if found is None else found.id


def test_a_new_exit_has_the_place_it_was_seen_from_on_its_left() -> None:
    (new,) = remember_exits((), DOOR, 1, Pose(-2.0, 0.5, 0.0), 0, P)
    assert (new.id, new.left, new.right, new.sightings, new.crossed) == (1, 1, NOWHERE, 1, -1)
    assert new.middle == pytest.approx([0.0, 0.5])
    assert new.normal == pytest.approx([-1.0, 0.0])


def test_an_exit_counts_once_it_was_seen_twice() -> None:
    once = remember_exits((), DOOR, 1, Pose(-2.0, 0.5, 0.0), 0, P)
    twice = remember_exits(once, DOOR + 0.05, 1, Pose(-1.5, 0.5, 0.0), 0, P)
    assert [e.trusted(P) for e in (*once, *twice)] == [False, True]
    assert len(twice) == 1


def test_exits_of_an_empty_view_change_nothing() -> None:
    assert remember_exits((), NONE, 1, Pose(), 0, P) == ()
    known = book()
    assert remember_exits(known, NONE, 1, Pose(), 0, P) is known


def test_a_sighting_from_near_moves_the_line_more_than_one_from_far() -> None:
    moved = DOOR + np.array((0.2, 0.0))
    near = remember_exits(book(), moved, 1, Pose(-2.0, 0.5, 0.0), 0, P)[0].line
    far = remember_exits(book(), moved, 1, Pose(-9.0, 0.5, 0.0), 0, P)[0].line
    assert 0.0 < far[0, 0] < near[0, 0] < 0.2


def test_the_same_exit_seen_from_its_other_side_gets_the_place_there() -> None:
    door = replace(book()[0], crossed=5, right=NOWHERE)
    (seen,) = remember_exits((door,), DOOR[:, ::-1], 2, Pose(2.0, 0.5, 0.0), 0, P)
    assert (seen.left, seen.right) == (1, 2)
    assert (seen.line[1] - seen.line[0]) @ (DOOR[0, 1] - DOOR[0, 0]) > 0.0


def test_an_exit_seen_through_a_known_one_does_not_belong_to_this_place() -> None:
    beyond = segments((3, 0.2, 3, 1.2))
    known = book()
    assert remember_exits(known, beyond, 1, Pose(-2.0, 0.5, 0.0), 0, P) == known
    assert len(remember_exits(known, beyond, 1, Pose(1.0, 0.5, 0.0), 0, P)) == 2


def test_the_nearest_exit_of_like_direction_is_the_same_exit() -> None:
    two = book(segments((0, 0, 0, 1), (0, 0.5, 0, 1.4)))
    line = np.array([[0.0, 0.4], [0.0, 1.3]])
    found = match_exit(two, line, P)
    assert found is not None
    assert found.id == 2
    assert match_exit(two, line + 5.0, P) is None
    across = np.array([[-0.5, 0.5], [0.5, 0.5]])
    assert match_exit(book(), across, P) is None


def test_a_path_through_the_exit_and_well_beyond_crosses_it() -> None:
    assert crossing(path((-2, 0.5), (0.5, 0.5))) == 1
    assert crossing(path((0.8, 0.5), (-0.5, 0.3))) == 1


@pytest.mark.parametrize(
    "way",
    [
        path(),
        path((-2, 0.5)),
        path((-2, 0.5), (-0.4, 0.5)),
        path((-2, 0.5), (0.2, 0.5)),
        path((-2, 0.5), (0.6, 0.5), (-0.6, 0.5)),
        path((-2, 3), (2, 3)),
    ],
    ids=["no path", "a point", "up to it", "into it", "through and back", "past it"],
)
def test_this_path_crosses_no_exit(way: Points) -> None:
    assert crossing(way.reshape(-1, 2)) is None


def test_an_exit_seen_only_once_is_crossed_between_its_ends_alone() -> None:
    once = book(sightings=1)
    assert crossing(path((-2, 0.5), (1, 0.5)), once) == 1
    beside = path((-2, 1.1), (1, 1.1))
    assert crossing(beside, once) is None
    assert crossing(beside, book()) == 1
    assert crossing(path((-2, 0.5), (1, 0.5)), (replace(once[0], false=True),)) is None


def test_of_two_exits_crossed_in_one_move_the_last_counts() -> None:
    two = book(segments((0, 0, 0, 1), (1, 0, 1, 1)))
    assert crossing(path((-2, 0.5), (2, 0.5)), two) == 2
    assert crossing(path((3, 0.5), (-1, 0.5)), two) == 1


@given(moved=ANYWHERE, y=st.floats(-1.0, 2.0), x=st.floats(-2.0, 2.0))
def test_crossing_does_not_depend_on_where_the_origin_is(moved: Pose, y: float, x: float) -> None:
    near_tie = abs(abs(x) - P.beyond) < 1e-6 or min(abs(y + P.slack), abs(y - 1 - P.slack)) < 1e-6
    way = path((-2, y), (x, y))
    moved_way = moved.apply(way)
    here, there = crossing(way), crossing(moved_way, book(moved.apply(DOOR)))
    assert near_tie or here == there


def test_points_behind_an_exit_or_in_it_are_seen_through_it() -> None:
    points = path((2, 0.5), (0.1, 0.5), (-1, 0.5), (2, 5), (-2, 3))
    robot = np.array((-2.0, 0.5))
    seen = seen_through_exit(book(), robot, points, 0.1)
    assert seen.tolist() == [True, True, False, False, False]
    assert seen_through_exit((), robot, points, 0.1).tolist() == [False] * 5
    assert seen_through_exit(book(), robot, points[:0], 0.1).shape == (0,)
    false = (replace(book()[0], false=True),)
    assert not seen_through_exit(false, robot, points, 0.1).any(), "it parts nothing"


@given(moved=ANYWHERE, seed=st.integers(0, 99))
def test_what_is_seen_through_an_exit_does_not_depend_on_where_the_origin_is(
    moved: Pose, seed: int
) -> None:
    points = np.random.default_rng(seed).uniform(-3, 3, (20, 2))
    robot = np.array((-2.0, 0.7))
    here = seen_through_exit(book(), robot, points, 0.1)
    there = seen_through_exit(book(moved.apply(DOOR)), moved.apply(robot), moved.apply(points), 0.1)
    assert here.tolist() == there.tolist()


def test_a_place_is_renamed_on_both_sides_of_its_exits() -> None:
    exits = (*book(left=1, right=2), replace(book(left=2, right=3)[0], id=2))
    renamed = rename_place(exits, 2, 9)
    assert [(e.left, e.right) for e in renamed] == [(1, 9), (9, 3)]
    assert [(e.left, e.right) for e in exits] == [(1, 2), (2, 3)]


def test_an_exit_is_replaced_under_its_own_id() -> None:
    three = book(np.concatenate((DOOR, DOOR + 5, DOOR + 9)))
    changed = replace_exit(three, replace(three[1], crossed=7))
    assert [e.crossed for e in changed] == [-1, 7, -1]
    assert [e.id for e in changed] == [1, 2, 3]


def test_the_sides_of_an_exit_name_its_places() -> None:
    door = Exit(1, DOOR[0], 4, 5, 2, 3)
    assert [door.side_of(k) for k in (4, 5, 6)] == [1, -1, 0]
    assert (door.beyond(4), door.beyond(5)) == (5, 4)
    assert math.isclose(float(np.hypot(*door.normal)), 1.0)
    assert not replace(door, right=4).trusted(P), "an exit from a place to itself leads nowhere"


def test_an_exit_remembers_when_it_was_last_seen_open() -> None:
    once = remember_exits((), DOOR, 1, Pose(-2.0, 0.5, 0.0), 4, P)
    again = remember_exits(once, DOOR, 1, Pose(-2.0, 0.5, 0.0), 9, P)
    assert [once[0].seen, again[0].seen] == [4, 9]
    assert remember_exits(again, NONE, 1, Pose(-2.0, 0.5, 0.0), 12, P)[0].seen == 9


def test_an_exit_that_parts_nothing_does_not_count_however_often_it_was_seen() -> None:
    false = replace(book(sightings=9)[0], false=True)
    assert not false.trusted(P)
    assert crossing(path((-2, 0.5), (1, 0.5)), (false,)) is None


def test_one_sees_as_far_as_to_the_first_exit() -> None:
    two = book(segments((0, 0, 0, 1), (1, 0, 1, 1)))
    eye, ends = np.array((-2.0, 0.5)), path((3, 0.5), (-1, 0.5), (-2, 5), (-5, 0.5))
    reach = reach_to_exits(two, eye, ends, P)
    assert reach[0] == pytest.approx(2.0)
    assert (reach[1:] >= np.hypot(*(ends[1:] - eye).T)).all()
    assert reach_to_exits(two[::-1], eye, ends, P) == pytest.approx(reach)
    assert np.isinf(reach_to_exits((), eye, ends, P)).all()
    assert reach_to_exits(two, eye, ends[:0], P).shape == (0,)
    false = tuple(replace(e, false=True) for e in two)
    assert np.isinf(reach_to_exits(false, eye, ends, P)).all()


@given(moved=ANYWHERE, seed=st.integers(0, 99))
def test_how_far_one_sees_does_not_depend_on_where_the_origin_is(moved: Pose, seed: int) -> None:
    ends, eye = np.random.default_rng(seed).uniform(-3, 3, (20, 2)), np.array((-2.0, 0.7))
    here = reach_to_exits(book(), eye, ends, P)
    there = reach_to_exits(book(moved.apply(DOOR)), moved.apply(eye), moved.apply(ends), P)
    assert there == pytest.approx(here)
