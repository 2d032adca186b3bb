"""What a place still hides: gaps, and walls seen too sparsely to show a door."""

from __future__ import annotations

import numpy as np
import pytest

from agents.cogmap.curiosity import (
    before_walls,
    follow_gaps,
    follow_walls,
    lead_points,
    not_yet_squarely,
    see_free,
    wall_pieces,
    worth_coming_back,
)
from agents.cogmap.exits import Exit
from agents.cogmap.free_space import cells_of
from agents.cogmap.memory import Leads
from agents.cogmap.params import Params
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.geometry import NO_SEGMENTS, Pose
from tests.rooms import corridor
from tests.simulated import SYMMETRIC, segments, solid, view_of

PARAMS = Params()
P = PARAMS.curiosity
GAP = segments((5, 1, 5, -1))
"""Ahead of a robot at the origin; what it hides, at x < 5, is on its right."""
AHEAD = GAP[:, ::-1]
"""The same, hiding what lies beyond it."""
HALL = solid(corridor(20.0, 2.0))


def test_a_gap_that_hides_something_waits_to_be_explored() -> None:
    leads = follow_gaps(Leads(), AHEAD, Pose(), (), P)
    assert np.array_equal(leads.gaps, AHEAD)
    assert lead_points(leads, PARAMS) == pytest.approx(np.array([[5.0, 0.0]]))


def test_a_gap_seen_again_is_one_gap_whatever_the_order() -> None:
    two = np.concatenate((AHEAD, AHEAD + 0.2, AHEAD + 3.0))
    for rows in (two, two[::-1]):
        once = follow_gaps(Leads(), rows, Pose(), (), P)
        again = follow_gaps(once, rows, Pose(), (), P)
        assert len(once.gaps) == 2
        assert np.array_equal(again.gaps, once.gaps)


def test_a_gap_is_explored_once_what_it_hid_was_seen() -> None:
    x, y = np.meshgrid(np.arange(5, 7, 0.1), np.arange(-1.5, 1.5, 0.1))
    seen = np.unique(cells_of(np.stack((x, y), axis=-1), P))
    assert len(follow_gaps(Leads(seen=seen), AHEAD, Pose(), (), P).gaps) == 0
    assert len(follow_gaps(Leads(seen=seen), GAP, Pose(), (), P).gaps) == 1, "on its other side"


def test_a_gap_the_robot_is_near_to_is_done_and_does_not_come_back() -> None:
    leads = follow_gaps(Leads(), AHEAD, Pose(4.5, 0.0, 0.0), (), P)
    assert len(leads.gaps) == 0
    assert leads.done == pytest.approx(np.array([[5.0, 0.0]]))
    assert len(follow_gaps(leads, AHEAD, Pose(), (), P).gaps) == 0


def test_a_gap_behind_an_exit_is_another_places() -> None:
    between = Exit(1, np.array([[3.0, -0.5], [3.0, 0.5]]), 1, 0, 2, -1)
    assert len(follow_gaps(Leads(), AHEAD, Pose(), (between,), P).gaps) == 0
    assert len(follow_gaps(Leads(), AHEAD, Pose(4.0, 3.0, 0.0), (between,), P).gaps) == 1


def test_only_wide_gaps_are_worth_coming_back_for() -> None:
    narrow = segments((5, -0.5, 5, 0.5))
    both = np.concatenate((narrow, AHEAD))
    assert np.array_equal(worth_coming_back(both, P), AHEAD)
    assert worth_coming_back(NO_SEGMENTS, P).shape == (0, 2, 2)


def test_nothing_seen_leaves_nothing_to_explore() -> None:
    leads = follow_walls(Leads(), EMPTY_VIEW, Pose(), SYMMETRIC, (), P)
    leads = follow_gaps(leads, NO_SEGMENTS, Pose(), (), P)
    assert lead_points(leads, PARAMS).shape == (0, 2)
    assert len(see_free(leads, EMPTY_VIEW, Pose(), SYMMETRIC, P).seen) == 0


def test_the_far_walls_of_a_corridor_are_looked_at_until_they_were_seen_well() -> None:
    leads = Leads()
    start = Pose(1.0, 1.0, 0.0)
    leads = follow_walls(leads, view_of(HALL, start), start, SYMMETRIC, (), P)
    far = leads.dim.mean(axis=1)[:, 0]
    assert len(far) > 4
    assert far.min() > 3.0
    for x in np.arange(2.0, 19.5, 1.0):
        pose = Pose(x, 1.0, 0.0)
        leads = follow_walls(leads, view_of(HALL, pose), pose, SYMMETRIC, (), P)
    assert len(leads.dim) == 0


def test_a_wall_is_looked_at_from_its_free_side_wherever_the_origin_is() -> None:
    wall, moved = segments((0, 0, 1, 0), (0, 5, 0, 4)), Pose(3.0, -2.0, 0.7)
    spots = before_walls(wall, P)
    assert spots == pytest.approx(np.array([[0.5, P.stand], [P.stand, 4.5]]))
    assert before_walls(moved.apply(wall), P) == pytest.approx(moved.apply(spots))


def test_what_is_done_is_no_place_to_go() -> None:
    leads = Leads(gaps=AHEAD, dim=segments((0, 0, 1, 0)), done=np.array([[5.2, 0.0]]))
    assert lead_points(leads, PARAMS) == pytest.approx(np.array([[0.5, P.stand]]))


def test_a_wall_is_seen_squarely_only_with_room_for_both_jambs_in_view() -> None:
    wall = segments((0.375, 1.0, -0.375, 1.0))
    facing = Pose(0.0, 0.0, np.pi / 2)
    assert len(not_yet_squarely(wall, facing, SYMMETRIC, P)) == 0
    aside = Pose(0.0, 0.0, 0.3)
    assert len(not_yet_squarely(wall, aside, SYMMETRIC, P)) == 1, "its left jamb is behind"
    assert len(not_yet_squarely(wall, Pose(4.0, 0.8, np.pi), SYMMETRIC, P)) == 1, "too flat"


def test_short_sides_of_a_boundary_are_searched_too() -> None:
    sides = segments((0, 0, 0.5, 0), (0, 1, 3, 1), (0, 2, 0.2, 2))
    pieces = wall_pieces(sides, P)
    assert len(pieces) == 1 + 4
    assert np.array_equal(pieces[-1], sides[0])
