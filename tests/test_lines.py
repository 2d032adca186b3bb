"""Surfaces of a scan (thesis 3.2)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from agents.cogmap.lines import extract_view
from agents.cogmap.params import Lines
from cogmap_gym.geometry import Pose, headings, lengths, midpoints, point_segment_distances
from cogmap_gym.observation import LaserSpec
from tests.rooms import corridor, l_room, room_with_pillar, square_room
from tests.simulated import SYMMETRIC, mirrored, scan, segments, solid, view_of

LITERAL = Lines(literal=True)
BOTH = pytest.mark.parametrize("params", [Lines(), LITERAL], ids=["default", "literal"])
ROOMS = pytest.mark.parametrize(
    "plan", [square_room(), corridor(), l_room(), room_with_pillar()], ids=lambda p: p.name
)
INSIDE = Pose(1.3, 1.1, 0.4)


def distances_to(walls: np.ndarray, pose: Pose, surfaces: np.ndarray) -> np.ndarray:
    return point_segment_distances(pose.apply(surfaces).reshape(-1, 2), walls).min(axis=1)


def test_a_square_room_seen_from_its_middle_shows_three_walls_cut_at_the_corners() -> None:
    view = view_of(solid(square_room(6.0)), Pose(3.0, 3.0, 0.0))
    assert len(view.surfaces) == 3
    assert lengths(view.surfaces) == pytest.approx([3.0, 6.0, 3.0], abs=0.1)


def test_surfaces_are_ordered_counter_clockwise_with_free_space_on_their_left() -> None:
    view = view_of(solid(square_room(6.0)), Pose(3.0, 3.0, 0.0))
    bearings = np.arctan2(midpoints(view.surfaces)[:, 1], midpoints(view.surfaces)[:, 0])
    assert (np.diff(bearings) > 0.0).all()
    start, along = view.surfaces[:, 0], view.surfaces[:, 1] - view.surfaces[:, 0]
    to_robot = -start
    assert (along[:, 0] * to_robot[:, 1] - along[:, 1] * to_robot[:, 0] > 0.0).all()


@ROOMS
def test_every_surface_of_an_exact_scan_lies_on_a_wall(plan) -> None:
    view = view_of(solid(plan), INSIDE)
    assert len(view.surfaces) >= 3
    assert distances_to(solid(plan), INSIDE, view.surfaces).max() < Lines().split_distance


@ROOMS
def test_with_the_noise_of_the_laser_nearly_all_beams_lie_on_surfaces(plan) -> None:
    view = view_of(solid(plan), INSIDE, rng=np.random.default_rng(1))
    assert view.hits.sum() > 0.95 * SYMMETRIC.beams
    assert distances_to(solid(plan), INSIDE, view.surfaces).max() < 0.1


def test_a_corridor_wall_is_one_surface_for_a_dozen_metres() -> None:
    walls = solid(corridor(20.0, 2.0))
    view = view_of(walls, Pose(1.0, 1.0, 0.0), LaserSpec(), rng=np.random.default_rng(3))
    assert np.sort(lengths(view.surfaces))[-2] > 12.0
    literal = view_of(walls, Pose(1.0, 1.0, 0.0), LaserSpec(), LITERAL, np.random.default_rng(3))
    assert np.sort(lengths(literal.surfaces))[-2] < 11.0


def test_a_depth_jump_under_the_cluster_distance_leaves_no_phantom_along_the_beam() -> None:
    walls = segments((3, -4, 3, 0), (4, 0, 4, 4), (3, 0, 4, 0))
    view = view_of(walls, Pose(), rng=np.random.default_rng(0))
    bearing = np.arctan2(midpoints(view.surfaces)[:, 1], midpoints(view.surfaces)[:, 0])
    off = headings(view.surfaces) - bearing
    assert (np.abs(np.sin(off)) > 0.2).all()


def test_an_end_hidden_by_something_nearer_is_no_end_of_the_wall() -> None:
    walls = segments((4, -3, 4, 3), (2, 0.5, 2, 1.0))
    view = view_of(walls, Pose())
    far = np.flatnonzero(midpoints(view.surfaces)[:, 0] > 3.5)
    near = np.flatnonzero(midpoints(view.surfaces)[:, 0] < 2.5)
    assert len(far) == 2
    assert len(near) == 1
    assert view.physical[far].tolist() == [[True, False], [False, True]]
    assert view.physical[near].tolist() == [[True, True]]


def test_a_wall_cut_by_the_field_of_view_has_no_end_there() -> None:
    view = view_of(solid(square_room(6.0)), Pose(3.0, 3.0, 0.0))
    assert view.physical.tolist() == [[False, True], [True, True], [True, False]]


@BOTH
def test_a_fan_that_is_its_own_mirror_image_sees_the_mirror_image(params: Lines) -> None:
    for plan in (square_room(), corridor(), l_room(), room_with_pillar()):
        ranges = scan(solid(plan), INSIDE)
        here = extract_view(ranges, SYMMETRIC, params)
        there = extract_view(ranges[::-1], SYMMETRIC, params)
        if params.literal:  # a line is grown from the right: cuts may fall a beam aside
            assert there.hits.sum() == pytest.approx(here.hits.sum(), abs=8)
            continue
        assert there.surfaces[::-1] == pytest.approx(mirrored(here.surfaces), abs=1e-9)
        assert (there.physical[::-1, ::-1] == here.physical).all()


@given(st.floats(-math.pi, math.pi), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.booleans())
def test_a_view_does_not_depend_on_where_the_origin_is(
    theta: float, x: float, y: float, literal: bool
) -> None:
    moved, walls = Pose(x, y, theta), solid(room_with_pillar())
    # Clear of ties: half-way values would round either way.
    params = LITERAL if literal else Lines()
    here = extract_view(np.round(scan(walls, INSIDE), 6), SYMMETRIC, params)
    there = extract_view(np.round(scan(moved.apply(walls), moved @ INSIDE), 6), SYMMETRIC, params)
    assert there.surfaces == pytest.approx(here.surfaces, abs=1e-4)


def test_a_view_does_not_depend_on_the_order_of_the_walls() -> None:
    walls = solid(room_with_pillar())
    here = view_of(walls, INSIDE)
    assert view_of(walls[::-1], INSIDE).surfaces == pytest.approx(here.surfaces)


def test_a_laser_that_sits_askew_on_the_robot_shows_the_same_surfaces() -> None:
    walls = solid(room_with_pillar())
    askew = LaserSpec(mount=(0.2, -0.1, 0.3))
    laser_at = INSIDE @ askew.robot_from_laser
    here = laser_at.apply(view_of(walls, laser_at, LaserSpec()).surfaces)
    there = INSIDE.apply(view_of(walls, INSIDE, askew).surfaces)
    assert there == pytest.approx(here)
    ends = (view_of(walls, laser_at, LaserSpec()).physical, view_of(walls, INSIDE, askew).physical)
    assert (ends[0] == ends[1]).all()


@BOTH
@pytest.mark.parametrize("value", [math.nan, 0.0, -1.0, math.inf, -math.inf, 32.0, 99.0], ids=str)
def test_a_scan_without_evidence_has_no_surfaces(params: Lines, value: float) -> None:
    view = extract_view(np.full(361, value), SYMMETRIC, params)
    assert view.surfaces.shape == (0, 2, 2)
    assert view.physical.shape == (0, 2)


@BOTH
def test_one_beam_is_no_surface(params: Lines) -> None:
    laser = LaserSpec(first_angle=0.0, beams=1)
    assert len(extract_view(np.array([2.0]), laser, params).surfaces) == 0
    ranges = np.full(361, 32.0)
    ranges[100] = 2.0
    assert len(extract_view(ranges, SYMMETRIC, params).surfaces) == 0


def test_broken_beams_do_not_break_a_wall() -> None:
    ranges = scan(solid(square_room(6.0)), Pose(3.0, 3.0, 0.0))
    whole = extract_view(ranges, SYMMETRIC, Lines())
    for value in (math.nan, 0.0, 32.0, math.inf):
        broken = ranges.copy()
        broken[[40, 160, 161, 180, 300]] = value
        view = extract_view(broken, SYMMETRIC, Lines())
        assert view.surfaces == pytest.approx(whole.surfaces, abs=1e-6)


def test_a_scan_of_the_wrong_length_is_refused() -> None:
    with pytest.raises(ValueError, match="expected 361 ranges"):
        extract_view(np.ones(360), SYMMETRIC, Lines())


def test_a_scan_is_not_changed() -> None:
    ranges = scan(solid(square_room()), INSIDE)
    before = ranges.copy()
    extract_view(ranges, SYMMETRIC, Lines())
    assert (ranges == before).all()


@BOTH
@given(
    ranges=arrays(
        np.float64, 61, elements=st.one_of(st.floats(), st.floats(-1.0, 40.0), st.just(32.0))
    )
)
def test_no_scan_is_too_odd_and_every_surface_rests_on_beams(
    params: Lines, ranges: np.ndarray
) -> None:
    laser = LaserSpec(step=math.radians(3.0), beams=61)
    view = extract_view(ranges, laser, params)
    assert np.isfinite(view.surfaces).all()
    assert (lengths(view.surfaces) >= params.min_length).all()
    assert (view.hits >= (2 if params.literal else params.min_hits)).all()
    for first, last in view.beams:
        assert np.isfinite(view.points[[first, last]]).all()
