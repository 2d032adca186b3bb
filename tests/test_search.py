"""Looking for new exits where the way is shut: which walls, from where, and until when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.asr import ASR
from agents.cogmap.exits import Exit
from agents.cogmap.memory import GAP, NEWBORN, Journey, Mark, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import Network
from agents.cogmap.search import search_place, unsearched
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.observation import RobotSpec

P, ROBOT = Params(), RobotSpec()
MARK = Mark(7, 2, np.array((3.0, 6.0)))


def room(number: int, x: float, y: float, wide: float, deep: float) -> ASR:
    ring = np.array([[x, y], [x + wide, y], [x + wide, y + deep], [x, y + deep]])
    ids = np.arange(0)
    return ASR(number, ring, ids, ids, np.zeros((0, 2)), np.zeros((0, 2, 2)))


def at_a_block(x: float = 3.0, y: float = 2.0, heading: float = 0.0) -> Memory:
    """In room 1, 6 x 4 m, looked round; the goal's room 2 lies above, room 3 far away."""
    shut = Exit(1, np.array([[5.0, 4.1], [5.9, 4.1]]), 2, 1, 2, 1)
    aside = Exit(2, np.array([[-0.1, 1.0], [-0.1, 2.0]]), 3, 1, 2, 1)
    rooms = (room(1, 0, 0, 6, 4), room(2, 0, 4.2, 6, 4), room(3, -9, 0, 8.8, 3))
    stay = replace(NEWBORN.stay, known=True, settled=True, looked=True, searching=0)
    pose = replace(NEWBORN.pose, x=x, y=y, theta=heading)
    return replace(
        NEWBORN,
        mapping=replace(NEWBORN.mapping, mfis_from_robot=pose),
        network=Network(rooms, 3),
        book=(shut, aside),
        stay=stay,
        journey=Journey(7, frozenset({1}), looking=False),
        marks=(MARK,),
    )


def test_a_door_to_the_goal_may_be_where_walls_are_shared_and_not_elsewhere() -> None:
    spots = unsearched(at_a_block(), MARK, P)
    assert list(spots) == [1], "room 3 shares no wall with the goal's"
    assert spots[1][1] == 4.0


def test_a_place_once_searched_is_searched_no_more_on_this_journey() -> None:
    memory = at_a_block()
    assert memory.journey is not None
    done = replace(memory.journey, searched=frozenset({1}))
    assert unsearched(replace(memory, journey=done), MARK, P) == {}


def test_the_robot_goes_to_a_wall_and_faces_it_before_it_is_done_with_it() -> None:
    wall = np.array([[[3.4, 4.0], [2.6, 4.0]]])
    memory = at_a_block().with_stay(search=wall)
    memory, action = search_place(memory, MARK, None, EMPTY_VIEW, ROBOT, P)
    assert action is not None
    assert memory.intent is not None
    assert memory.intent.kind == GAP
    np.testing.assert_allclose(memory.intent.target, (3.0, 4.0 - P.curiosity.stand))
    there = at_a_block(3.0, 4.0 - P.curiosity.stand).with_stay(search=wall)
    memory, action = search_place(there, MARK, None, EMPTY_VIEW, ROBOT, P)
    assert action is not None
    assert action[0] > 0.0, "it turns to its left, where the wall is"
    facing = at_a_block(3.0, 4.0 - P.curiosity.stand, np.pi / 2).with_stay(search=wall)
    memory, action = search_place(facing, MARK, None, EMPTY_VIEW, ROBOT, P)
    assert action is None
    assert memory.journey is not None
    assert 1 in memory.journey.searched


def test_a_search_ends_when_it_has_cost_what_it_may_save() -> None:
    wall = np.array([[[3.4, 4.0], [2.6, 4.0]]])
    memory = at_a_block().with_stay(search=wall, search_end=5.0)
    assert search_place(memory, MARK, None, EMPTY_VIEW, ROBOT, P)[1] is not None
    assert search_place(replace(memory, travelled=5.1), MARK, None, EMPTY_VIEW, ROBOT, P)[1] is None
