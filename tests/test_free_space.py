"""What was seen to be free, and coarse ways over it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.cogmap.curiosity import see_free
from agents.cogmap.free_space import Cells, cells_of, free_cells, spot_on_the_way
from agents.cogmap.memory import Leads
from agents.cogmap.params import Curiosity
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.geometry import Points, Pose
from tests.rooms import square_room
from tests.simulated import SYMMETRIC, solid, view_of

P = Curiosity()
ROOM = solid(square_room())
LOW, HIGH = P.cell, 6.0 - P.cell
"""Between these the cells of the room lie wholly inside it [m]."""


def floor(x0: float, y0: float, x1: float, y1: float) -> Cells:
    """The cells of a rectangle."""
    x, y = np.meshgrid(np.arange(x0, x1, P.cell), np.arange(y0, y1, P.cell))
    return np.unique(cells_of(np.stack((x, y), axis=-1) + 0.5 * P.cell, P))


def share(points: Points, cells: Cells) -> float:
    """The share of points (P, 2) that lie in one of the cells."""
    return float(np.isin(cells_of(points, P), cells).mean())


@given(x=st.floats(-500.0, 500.0), y=st.floats(-500.0, 500.0))
def test_points_of_one_cell_share_its_number_and_points_apart_do_not(x: float, y: float) -> None:
    corner = np.floor(np.array((x, y)) / P.cell) * P.cell
    inside = corner + P.cell * np.array(((0.1, 0.1), (0.9, 0.9)))
    assert len(np.unique(cells_of(inside, P))) == 1
    around = corner + P.cell * (np.array(((1, 0), (0, 1), (-1, 0), (0, -1), (0, 0))) + 0.5)
    assert len(np.unique(cells_of(around, P))) == 5


@settings(max_examples=10)
@given(x=st.floats(1.0, 5.0), y=st.floats(1.0, 5.0), theta=st.floats(-3.1, 3.1))
def test_what_a_view_shows_to_be_free_lies_ahead_and_inside_the_room(
    x: float, y: float, theta: float
) -> None:
    pose = Pose(x, y, theta)
    cells = free_cells(view_of(ROOM, pose), pose, SYMMETRIC, P)
    inside = np.random.default_rng(0).uniform(LOW, HIGH, (500, 2))
    ahead = pose.inverse().apply(inside)[:, 0]
    assert share(inside[ahead > 2.0 * P.cell], cells) > 0.9
    assert share(inside[ahead < -2.0 * P.cell], cells) == 0.0
    outside = np.array(((-0.5, 3.0), (6.5, 3.0), (3.0, -0.5), (3.0, 6.5)))
    assert share(outside, cells) == 0.0


@settings(max_examples=10)
@given(
    moved=st.builds(Pose, st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1)),
)
def test_about_as_much_is_free_wherever_the_origin_is(moved: Pose) -> None:
    view, pose = view_of(ROOM, Pose(2.0, 3.0, 0.4)), Pose(2.0, 3.0, 0.4)
    here = free_cells(view, pose, SYMMETRIC, P)
    there = free_cells(view, moved @ pose, SYMMETRIC, P)
    assert len(there) == pytest.approx(len(here), rel=0.15)


def test_a_view_of_nothing_shows_nothing_to_be_free() -> None:
    assert free_cells(EMPTY_VIEW, Pose(), SYMMETRIC, P).shape == (0,)
    leads = Leads()
    assert see_free(leads, EMPTY_VIEW, Pose(), SYMMETRIC, P) is leads


def test_what_was_seen_to_be_free_grows_and_is_kept_in_order_once() -> None:
    leads = Leads()
    for pose in (Pose(2, 3, 0), Pose(2, 3, 2.0), Pose(2, 3, -2.0)):
        before = leads.seen
        leads = see_free(leads, view_of(ROOM, pose), pose, SYMMETRIC, P)
        assert np.isin(before, leads.seen).all()
        assert (np.diff(leads.seen) > 0).all()
    again = see_free(leads, view_of(ROOM, Pose(2, 3, 0)), Pose(2, 3, 0), SYMMETRIC, P)
    assert again is leads, "what is seen twice is noted once"
    inside = np.random.default_rng(0).uniform(LOW, HIGH, (300, 2))
    assert share(inside, leads.seen) > 0.95


def test_a_spot_on_the_way_lies_round_the_corner_no_farther_than_a_leg() -> None:
    bent = np.union1d(floor(0, 0, 10, 2), floor(8, 0, 10, 10))
    start, goal = np.array((1.0, 1.0)), np.array((9.0, 9.0))
    spots = [start]
    short = Curiosity(leg=2.0)
    for _ in range(10):
        spot = spot_on_the_way(bent, spots[-1], goal, short)
        assert spot is not None
        assert share(spot[None], bent) == 1.0
        assert np.hypot(*(spot - spots[-1])) <= short.leg + P.cell
        spots.append(spot)
    assert np.hypot(*(spots[-1] - goal)) < P.cell
    assert any(s[0] > 7.5 and s[1] < 3.0 for s in spots), "it leads round the corner"


def test_a_coarse_way_keeps_off_the_edge_of_what_is_free() -> None:
    hall = floor(0, 0, 4, 4)
    spot = spot_on_the_way(hall, np.array((0.2, 0.2)), np.array((3.8, 0.2)), Curiosity(leg=2.0))
    assert spot is not None
    assert spot[1] > P.cell


def test_there_is_no_way_between_what_does_not_hang_together() -> None:
    start, goal = np.array((1.0, 1.0)), np.array((7.0, 1.0))
    apart = np.union1d(floor(0, 0, 2, 2), floor(6, 0, 8, 2))
    assert spot_on_the_way(apart, start, goal, P) is None
    assert spot_on_the_way(floor(0, 0, 2, 2), start, goal, P) is None, "the goal is far from it"
    assert spot_on_the_way(floor(0, 0, 2, 2)[:0], start, goal, P) is None


def test_a_way_to_where_one_stands_ends_there() -> None:
    at = np.array((1.0, 1.0))
    spot = spot_on_the_way(floor(0, 0, 2, 2), at, at, P)
    assert spot is not None
    assert np.hypot(*(spot - at)) < P.cell
