"""The short memory of what not to touch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.cogmap.obstacles import remember_obstacles
from agents.cogmap.params import Obstacles
from cogmap_gym.geometry import Points, Pose, Segments, point_segment_distances
from cogmap_gym.observation import LaserSpec
from tests.rooms import room_with_pillar, square_room
from tests.simulated import SYMMETRIC, segments, solid, view_of

NONE = np.zeros((0, 2))
CELL = Obstacles().cell


def remembered(known: Points, walls: Segments, pose: Pose, laser: LaserSpec = SYMMETRIC) -> Points:
    """What is remembered after a view; the map lies as the walls do."""
    points = view_of(walls, pose, laser).points
    return remember_obstacles(known, points, pose, laser, Obstacles())


def test_all_that_is_seen_near_is_remembered_where_it_is() -> None:
    walls = solid(room_with_pillar())
    points = remembered(NONE, walls, Pose(1.2, 1.1, 0.3))
    assert len(points) > 150
    assert point_segment_distances(points, walls).min(axis=1).max() < 1e-6


def test_one_point_is_kept_a_cell_so_that_the_same_view_adds_nothing() -> None:
    walls, at = solid(room_with_pillar()), Pose(1.2, 1.1, 0.3)
    once = remembered(NONE, walls, at)
    twice = remembered(once, walls, at)
    assert len(np.unique(np.floor(once / CELL), axis=0)) == len(once)
    assert np.sort(twice.sum(axis=1)) == pytest.approx(np.sort(once.sum(axis=1)))


def test_what_lies_behind_the_robot_is_kept() -> None:
    walls, at = solid(square_room()), Pose(3.0, 3.0, 0.0)
    ahead = remembered(NONE, walls, at)
    both = remembered(ahead, walls, at @ Pose(0.0, 0.0, math.pi))
    assert (both[:, 0] < 2.9).any()
    assert (both[:, 0] > 3.1).any()


def test_a_door_that_opened_is_forgotten_once_seen_through() -> None:
    jambs = segments((3, -3, 3, -0.5), (3, 0.5, 3, 3), (8, -3, 8, 3))
    shut = np.concatenate((jambs, segments((3, -0.5, 3, 0.5))))
    before = remembered(NONE, shut, Pose())
    after = remembered(before, jambs, Pose())
    in_door = (np.abs(before[:, 0] - 3) < 0.1) & (np.abs(before[:, 1]) < 0.4)
    assert in_door.sum() > 10
    assert not ((np.abs(after[:, 0] - 3) < 0.1) & (np.abs(after[:, 1]) < 0.4)).any()
    assert ((np.abs(after[:, 0] - 3) < 0.1) & (np.abs(after[:, 1]) > 0.6)).any()


def test_what_something_nearer_hides_is_kept() -> None:
    wall = segments((5, -2, 5, 2))
    before = remembered(NONE, wall, Pose())
    after = remembered(before, np.concatenate((wall, segments((2, -1, 2, 1)))), Pose())
    assert (np.abs(after[:, 0] - 5) < 0.1).sum() == len(before)


def test_what_is_far_is_forgotten() -> None:
    far = np.array([[11.9, 0.0], [12.1, 0.0], [0.0, -30.0]])
    blind = np.full((361, 2), np.nan)
    kept = remember_obstacles(far, blind, Pose(), SYMMETRIC, Obstacles())
    assert kept.tolist() == [[11.9, 0.0]]


@pytest.mark.parametrize("shape", [(361, 2), (0, 2)])
def test_a_view_without_evidence_forgets_nothing_near(shape: tuple[int, int]) -> None:
    known = remembered(NONE, solid(square_room()), Pose(3.0, 3.0, 0.0))
    kept = remember_obstacles(
        known, np.full(shape, np.nan), Pose(3.0, 3.0, 1.0), SYMMETRIC, Obstacles()
    )
    assert np.sort(kept.sum(axis=1)) == pytest.approx(np.sort(known.sum(axis=1)))


def test_a_laser_that_sits_askew_sees_through_the_same_points() -> None:
    askew = LaserSpec(mount=(0.2, -0.1, 0.3))
    walls, at = solid(square_room()), Pose(3.0, 3.0, 0.0)
    ghosts = at.apply(np.array([[1.0, 0.0], [1.5, 1.0], [-1.0, 0.0]]))
    kept = remembered(ghosts, walls, at, askew)
    assert point_segment_distances(kept, walls).min(axis=1).max() == pytest.approx(2.0)


@given(theta=st.floats(-3.1, 3.1), x=st.floats(-9, 9), y=st.floats(-9, 9))
def test_every_obstacle_was_seen_wherever_the_map_has_its_origin(
    theta: float, x: float, y: float
) -> None:
    moved, walls = Pose(x, y, theta), solid(room_with_pillar())
    view = view_of(walls, Pose(1.2, 1.1, 0.3))
    points = remember_obstacles(
        NONE, view.points, moved @ Pose(1.2, 1.1, 0.3), SYMMETRIC, Obstacles()
    )
    back = moved.inverse().apply(points)
    assert point_segment_distances(back, walls).min(axis=1).max() < 1e-6
    assert len(points) > 150
