"""Where a view lies in the MFIS: by the nearest landmark (thesis 3.4), or by all of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.cogmap.frame import consensus, landmark_frame
from agents.cogmap.locate import NO_PAIRS, Located, Search, by_nearest, matched_share
from agents.cogmap.mapper import BLANK, update
from agents.cogmap.mfis import EMPTY_MFIS, MFIS
from agents.cogmap.params import Frame, Landmarks, Lines, Params, Transfer
from agents.cogmap.view import View
from cogmap_gym.geometry import Pose, Segments
from tests.rooms import corridor, l_room, room_with_pillar, square_room
from tests.simulated import segments, solid, view_of

SD = (0.05, 0.05)
ANGLES = st.floats(-math.pi, math.pi)
METRES = st.floats(-20.0, 20.0)
LITERAL = Params(
    frame=Frame(kind="nearest"),
    landmarks=Landmarks(literal=True),
    transfer=Transfer(literal=True),
)


def seen(surfaces: Segments, physical: bool = True) -> View:
    """A view that is sure of these surfaces."""
    count = len(surfaces)
    return View(
        np.zeros((0, 2)),
        surfaces,
        np.full((count, 2), physical),
        np.full((count, 2), 0.01),
        np.zeros((count, 2), dtype=np.int64),
        np.full(count, 100),
    )


def known(surfaces: Segments, physical: bool = True) -> MFIS:
    """A map that is sure of these surfaces, all seen at step 0."""
    count = len(surfaces)
    zeros = np.zeros(count, dtype=np.int64)
    return MFIS(
        surfaces=surfaces,
        physical=np.full((count, 2), physical),
        anchor=surfaces.mean(axis=1),
        anchor_sd=np.full(count, 0.002),
        heading_sd=np.full(count, 0.001),
        born=zeros,
        seen=zeros,
        asr=zeros,
        entered=np.ones(count, dtype=np.bool_),
        sighting=surfaces,
        sighted=zeros,
        ids=np.arange(1, count + 1),
    )


def same(a: Pose, b: Pose, metres: float = 1e-6, radians: float = 1e-6) -> bool:
    off = a.inverse() @ b
    return math.hypot(off.x, off.y) < metres and abs(off.theta) < radians


def nearest(view: Segments, mfis: Segments, odometry: Pose = Pose()) -> tuple[Located, list[Pose]]:  # noqa: B008
    """The frames of a view when V_{n-1} showed the whole of the map from the origin."""
    everything = np.ones(len(mfis), dtype=np.bool_)
    search = Search(seen(view), known(mfis), everything, everything, odometry, SD)
    return by_nearest(mfis, np.arange(1, len(mfis) + 1), search, odometry, LITERAL)


def fit(
    view: Segments,
    mfis: Segments,
    start: Pose,
    predicted: Pose | None = None,
    physical: bool = True,
    pairs: np.ndarray | None = None,
) -> Pose:
    rows = np.arange(len(view))
    pairs = np.stack((rows, rows), axis=-1) if pairs is None else pairs
    return consensus(
        seen(view, physical), known(mfis), pairs, predicted or start, SD, start, Frame()
    )


@given(theta=ANGLES, x=METRES, y=METRES)
def test_one_landmark_gives_the_rigid_motion_that_lays_it_on_its_surface(
    theta: float, x: float, y: float
) -> None:
    mfis_from_robot = Pose(x, y, theta)
    in_view = np.array([[1.0, 2.0], [3.0, 2.5]])
    assert same(landmark_frame(in_view, mfis_from_robot.apply(in_view)), mfis_from_robot)


def test_figure_3_14_the_ends_that_are_closest_are_the_centre() -> None:
    # ID 7 was seen from 0 to 2 m, now to 5 m, and a little turned; U3 stands beside its start.
    before, turned = segments((0, 0, 2, 0)), Pose(0.0, 0.0, 0.05)
    both = segments((0, 0, 5, 0), (-1, 0, -1, -2))
    _, frames = nearest(turned.apply(both), before)
    assert frames[1].apply(turned.apply(both[1])) == pytest.approx(both[1], abs=0.01)
    # Now from -3 m: its ends lie closest; U3 stands beside the end.
    about_end = Pose(2.0, 0.0, 0.05) @ Pose(-2.0, 0.0)
    both = segments((-3, 0, 2, 0), (3, 0, 3, 2))
    _, frames = nearest(about_end.apply(both), before)
    assert frames[1].apply(about_end.apply(both[1])) == pytest.approx(both[1], abs=0.01)


def test_figure_3_15_the_opposite_ends_would_distort_the_map_by_the_difference_of_lengths() -> None:
    before, now = segments((0, 0, 2, 0)), segments((0, 0, 5, 0))
    wrong = landmark_frame(now[0, ::-1], before[0, ::-1])
    right = landmark_frame(now[0], before[0])
    assert wrong.distance(right) == pytest.approx(3.0)


def test_figure_3_16_a_part_of_a_landmark_is_normalised_to_the_whole_and_slides_nowhere() -> None:
    # Both ends of what is seen now were made by occlusion: no end is the end of the wall.
    before = segments((0, 0, 10, 0))
    moved = Pose(0.3, -0.2, 0.02)
    now = moved.inverse().apply(segments((3, 0, 6, 0)))
    found, _ = nearest(now, before, odometry=moved)
    assert same(found.mfis_from_robot, moved, 0.01, 1e-6)


def test_the_nearest_landmark_of_each_surface_gives_its_frame() -> None:
    before = segments((0, 0, 2, 0), (10, 5, 12, 5))
    drifted = before + np.array([[[0.0, 0.1]], [[0.0, -0.2]]])
    near = segments((1, 2, 1, 3), (11, 2, 11, 4))
    _, frames = nearest(np.concatenate((drifted, near)), before)
    assert [round(f.y, 6) for f in frames] == [-0.1, 0.2, -0.1, 0.2]


def test_without_a_landmark_the_frame_is_that_of_the_odometry() -> None:
    odometry = Pose(0.5, 0.1, 0.2)
    found, frames = nearest(segments((0, 9, 2, 9)), segments((0, 0, 2, 0)), odometry)
    assert found.mfis_from_robot == odometry
    assert found.pairs.shape == NO_PAIRS.shape
    assert frames == [odometry]


def test_two_walls_at_an_angle_fix_the_pose_whatever_the_odometry_said() -> None:
    mfis = segments((0, 0, 4, 0), (4, 0, 4, 3))
    true = Pose(1.0, 1.5, 0.3)
    start = true @ Pose(0.2, -0.15, 0.08)
    found = fit(true.inverse().apply(mfis), mfis, start)
    assert same(found, true, 0.01, 0.003)


def test_an_end_of_a_wall_pulls_along_it_and_an_end_made_by_occlusion_does_not() -> None:
    mfis = segments((0, 0, 10, 0))
    true, start = Pose(5.0, 1.0, 0.0), Pose(5.2, 1.1, 0.0)
    in_view = true.inverse().apply(mfis)
    held = fit(in_view, mfis, start)
    free = fit(in_view, mfis, start, physical=False)
    assert abs(held.x - true.x) < 0.06
    assert free.x == pytest.approx(start.x, abs=1e-6)
    assert abs(free.y - true.y) < 0.01


def test_a_part_of_a_wall_lies_on_the_whole_and_slides_nowhere() -> None:
    mfis = segments((0, 0, 10, 0), (10, 0, 10, 5))
    true, start = Pose(6.0, 1.0, 0.1), Pose(6.1, 1.1, 0.05)
    part = segments((4, 0, 6, 0), (10, 1, 10, 2))
    assert same(fit(true.inverse().apply(part), mfis, start, physical=False), true, 0.02, 0.01)


def test_one_wrong_landmark_among_many_is_outvoted() -> None:
    mfis = segments((0, 0, 4, 0), (4, 0, 4, 4), (4, 4, 0, 4), (0, 4, 0, 0), (1, 1.5, 3, 1.5))
    true = Pose(2.0, 2.0, 0.2)
    in_view = true.inverse().apply(mfis)
    in_view[4] += np.array((0.0, 0.35))
    assert same(fit(in_view, mfis, true @ Pose(0.1, 0.1, 0.05)), true, 0.02, 0.01)


def test_without_landmarks_the_consensus_is_the_odometry() -> None:
    empty = np.zeros((0, 2, 2))
    start, predicted = Pose(1.0, 2.0, 0.5), Pose(1.3, 1.9, 0.4)
    found = consensus(seen(empty), EMPTY_MFIS, NO_PAIRS, predicted, SD, start, Frame())
    assert same(found, predicted)


@given(theta=ANGLES, x=METRES, y=METRES)
def test_the_consensus_does_not_depend_on_where_the_origin_is(
    theta: float, x: float, y: float
) -> None:
    mfis = segments((0, 0, 4, 0), (4, 0, 4, 3), (1, 2, 2, 3))
    moved, true = Pose(x, y, theta), Pose(1.0, 1.5, 0.3)
    start, in_view = true @ Pose(0.1, -0.1, 0.05), true.inverse().apply(mfis)
    here, there = fit(in_view, mfis, start), fit(in_view, moved.apply(mfis), moved @ start)
    assert same(moved @ here, there, 1e-5, 1e-5)


@given(seed=st.integers(0, 999))
def test_the_consensus_does_not_depend_on_the_order_of_landmarks(seed: int) -> None:
    mfis = segments((0, 0, 4, 0), (4, 0, 4, 3), (1, 2, 2, 3), (0, 3, 0, 0))
    true, order = Pose(1.0, 1.5, 0.3), np.random.default_rng(seed).permutation(4)
    start, in_view = true @ Pose(0.1, -0.1, 0.05), true.inverse().apply(mfis)
    pairs = np.stack((order, order), axis=-1)
    assert same(fit(in_view, mfis, start), fit(in_view, mfis, start, pairs=pairs))


@pytest.mark.parametrize(
    "plan", [square_room(), corridor(), l_room(), room_with_pillar()], ids=lambda p: p.name
)
def test_a_second_view_finds_its_place_in_the_first_to_a_centimetre(plan) -> None:
    first, moved = Pose(1.2, 1.1, 0.3), Pose(0.5, 0.1, 0.2)
    walls = solid(plan)
    wrong = moved @ Pose(0.06, -0.05, 0.03)
    last, _ = update(BLANK, view_of(walls, first), Pose(), Params())
    now, _ = update(last, view_of(walls, first @ moved), wrong, Params())
    off = now.mfis_from_robot.inverse() @ moved
    assert math.hypot(off.x, off.y) < (0.1 if plan.name == "corridor" else 0.02)
    assert abs(off.theta) < 0.005
    assert now.matched > 0.9


def test_a_turn_that_the_odometry_missed_is_found_by_searching_headings() -> None:
    walls, at = solid(l_room()), Pose(1.5, 1.5, 0.3)
    last, _ = update(BLANK, view_of(walls, at), Pose(), Params())
    turned = Pose(0.0, 0.0, 0.6)
    now, _ = update(last, view_of(walls, at @ turned), Pose(), Params())
    assert same(now.mfis_from_robot, turned, 0.05, 0.02)


def test_a_view_of_nowhere_known_keeps_the_odometry() -> None:
    at = Pose(1.5, 1.5, 0.3)
    last, _ = update(BLANK, view_of(solid(square_room(3.0)), at), Pose(), Params())
    elsewhere = view_of(segments((20, -5, 20, 5)), Pose())
    moved = Pose(0.4, 0.0, 0.1)
    now, _ = update(last, elsewhere, moved, Params())
    assert same(now.mfis_from_robot, moved)


def test_by_odometry_alone_no_surface_is_ever_recognised() -> None:
    blind = replace(Params(), frame=Frame(kind="odometry"))
    walls, at = solid(room_with_pillar()), Pose(1.2, 1.1, 0.3)
    moved, wrong = Pose(0.4, 0.0, 0.1), Pose(0.5, 0.1, 0.2)
    last, _ = update(BLANK, view_of(walls, at), Pose(), blind)
    now, _ = update(last, view_of(walls, at @ moved), wrong, blind)
    assert same(now.mfis_from_robot, wrong)
    assert len(now.pairs) == 0
    assert (now.ids[now.ids > 0] > len(last.mfis)).all()


def test_the_share_of_beams_counts_those_that_end_on_a_surface() -> None:
    wall = segments((0, 0, 4, 0))
    points = np.array([[1, 0.05], [3, -0.1], [2, 0.5], [4.5, 0], [np.nan, np.nan], [4.05, 0.05]])
    assert matched_share(points, wall, 0.12) == pytest.approx(3 / 5)
    assert matched_share(points[:0], wall, 0.12) == 0.0
    assert matched_share(points, wall[:0], 0.12) == 0.0


def test_the_literal_robot_locates_itself_too() -> None:
    literal = replace(LITERAL, lines=Lines())
    walls, first, moved = solid(room_with_pillar()), Pose(1.2, 1.1, 0.3), Pose(0.4, 0.0, 0.1)
    last, _ = update(BLANK, view_of(walls, first), Pose(), literal)
    now, _ = update(last, view_of(walls, first @ moved), moved @ Pose(0.05, 0.05, 0.02), literal)
    assert same(now.mfis_from_robot, moved, 0.15, 0.02)
