"""Journeys: what is tried where the way is shut, and when there is no route."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.asr import ASR
from agents.cogmap.exits import Book, Exit
from agents.cogmap.journeys import travel
from agents.cogmap.memory import NEWBORN, Journey, Mark, Memory, place_of
from agents.cogmap.params import Params
from agents.cogmap.places import Network
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.observation import RobotSpec

P, ROBOT = Params(), RobotSpec()
GOAL = np.array((10.0, 0.0))
MARK = Mark(7, 2, GOAL)


def door(number: int, at: tuple[float, float], left: int, right: int, crossed: int = 1) -> Exit:
    line = np.array(at) + np.array([[0.0, -0.5], [0.0, 0.5]])
    return Exit(number, line, left, right, 2, crossed)


def bound(book: Book, blocked: set[int], failed: set[int] | None = None) -> Memory:
    """In place 1 at the origin, bound for the mark in place 2, some exits found shut."""
    journey = Journey(7, frozenset(blocked), frozenset(failed or ()), looking=False)
    stay = replace(NEWBORN.stay, known=True)
    return replace(NEWBORN, book=book, marks=(MARK,), journey=journey, stay=stay)


def stepped(memory: Memory) -> tuple[Memory, bool]:
    """One step of the journey, and whether it is declared to be over."""
    memory, action = travel(memory, MARK, EMPTY_VIEW, ROBOT, P)
    return memory, bool(np.array_equal(action, ROBOT.declare()))


def square(number: int, x: float) -> ASR:
    corners = np.array([[x, 0], [x + 2, 0], [x + 2, 2], [x, 2.0]])
    ids = np.arange(0)
    return ASR(number, corners, ids, ids, np.zeros((0, 2)), np.zeros((0, 2, 2)))


def test_where_all_doors_to_the_goal_are_shut_no_route_is_said_and_declared() -> None:
    memory, declared = stepped(bound((door(1, (5, 0), 1, 2),), {1}))
    assert declared
    assert memory.status == "no route to mark 7"
    assert memory.route is None


def test_an_open_way_is_taken() -> None:
    memory, declared = stepped(bound((door(1, (5, 0), 1, 2),), set()))
    assert not declared
    assert memory.route == (1,)


def test_at_the_goal_the_journey_is_declared() -> None:
    here = replace(bound((), set()), stay=replace(NEWBORN.stay, place=2))
    mark = replace(MARK, point=np.array((0.1, 0.0)))
    memory, action = travel(here, mark, EMPTY_VIEW, ROBOT, P)
    assert np.array_equal(action, ROBOT.declare())
    assert memory.status == "at mark 7"


def test_a_journey_begins_with_a_look_round() -> None:
    memory = replace(bound((door(1, (5, 0), 1, 2),), set()), journey=None)
    memory, declared = stepped(memory)
    assert not declared
    assert memory.status == "looking round"


def test_an_exit_never_crossed_is_tried_before_giving_in() -> None:
    book = (door(1, (5, 0), 1, 2), door(2, (0, 5), 1, 0, crossed=-1))
    memory, declared = stepped(bound(book, {1}))
    assert not declared
    assert memory.route == (2,)
    assert stepped(bound(book, {1, 2}))[1]


def test_an_exit_never_crossed_of_another_place_is_tried_too() -> None:
    book = (
        door(1, (5, 0), 1, 2),
        door(2, (0, 5), 1, 3),
        door(3, (5, 9), 3, 0, crossed=-1),
    )
    memory, declared = stepped(bound(book, {1}))
    assert not declared
    assert memory.intent is not None
    assert memory.intent.exit == 2


def test_an_exit_not_seen_to_be_shut_is_tried_once_more_and_no_more() -> None:
    memory, declared = stepped(bound((door(1, (5, 0), 1, 2),), {1}, {1}))
    assert not declared
    assert memory.journey is not None
    assert memory.journey.retried
    assert memory.status == "looking round", "afresh"
    while memory.status == "looking round":
        memory, declared = stepped(memory)
    assert not declared
    assert memory.route == (1,)
    assert memory.journey is not None
    again = replace(memory.journey, blocked=frozenset({1}), failed=frozenset({1}))
    assert stepped(replace(memory, journey=again))[1]


def test_a_robot_that_believes_to_be_shut_in_itself_doubts_all_blocks() -> None:
    book = (door(1, (5, 0), 1, 2), door(2, (10, 5), 2, 3), door(3, (15, 5), 3, 4))
    memory, declared = stepped(bound(book, {1}))
    assert not declared
    assert memory.journey is not None
    assert memory.journey.blocked == frozenset()


def test_what_was_learned_on_a_journey_is_not_held_against_the_next() -> None:
    old = replace(bound((door(1, (5, 0), 1, 2),), {1}), journey=Journey(3, frozenset({1})))
    memory, declared = stepped(old)
    assert not declared
    assert memory.journey is not None
    assert (memory.journey.mark, memory.journey.blocked) == (7, frozenset())


def test_a_mark_lies_in_the_place_whose_boundary_holds_it() -> None:
    memory = replace(NEWBORN, network=Network((square(1, 0.0), square(2, 2.0)), 2))
    assert place_of(memory, Mark(1, 1, np.array((3.0, 1.0)))) == 2
    assert place_of(memory, Mark(1, 2, np.array((3.0, 1.0)))) == 2
    assert place_of(memory, Mark(1, 1, np.array((9.0, 1.0)))) == 1
    assert place_of(NEWBORN, Mark(1, 4, np.zeros(2))) == 4


def test_a_mark_that_is_not_reached_though_the_robot_is_in_its_place_has_no_route() -> None:
    here = replace(bound((), set()), stay=replace(NEWBORN.stay, place=2, known=True))
    assert here.journey is not None
    late = replace(here, journey=replace(here.journey, there=P.journeys.there_steps))
    memory, declared = stepped(late)
    assert declared
    assert memory.status == "no route to mark 7"
    assert not stepped(here)[1]


def test_a_step_without_a_known_way_counts_once_and_looking_counts_too() -> None:
    book = (door(1, (5, 0), 1, 2), door(2, (0, 5), 1, 0, crossed=-1))
    begun = replace(bound(book, {1}), mapping=replace(NEWBORN.mapping, step=5))
    memory, _ = stepped(begun)
    assert memory.journey is not None
    assert memory.journey.lost == 1
    assert stepped(memory)[0].journey == memory.journey, "the same step"


def test_a_robot_that_was_lost_for_long_gives_in() -> None:
    book = (door(1, (5, 0), 1, 2), door(2, (0, 5), 1, 3), door(3, (5, 9), 3, 0, crossed=-1))
    memory = bound(book, {1})
    assert not stepped(memory)[1], "the exit of place 3 is worth a try"
    assert memory.journey is not None
    tired = replace(memory.journey, lost=P.journeys.lost_steps, lost_at=-2)
    assert stepped(replace(memory, journey=tired))[1]
