"""Merges of places judged against the truth."""

from __future__ import annotations

from typing import Any

from cogmap_gym.reentries import MISSED, NEW, RIGHT, SPLIT, WRONG, entries
from tests.office_rows import moment


def stay(count: int, room: str, place: int, **fields: Any) -> list[tuple[Any, str]]:
    return [(moment(place=place, entry=place, **fields), room)] * count


HOME = [(moment(), "A")] * 4
IN_B = stay(4, "B", 2, began=4, came_from=1)
IN_C = stay(4, "C", 3, began=8, came_from=2)
"""From A by B to C, each for the first time."""
BACK_IN_A = stay(3, "A", 4, began=12, came_from=3)
"""In A once more, by a door that leads there for the first time."""


def judged(*stays: list[tuple[Any, str]]) -> list[tuple[str, str, str]]:
    moments, rooms = zip(*(pair for stay in stays for pair in stay), strict=True)
    return [(e.verdict, e.room, e.taken_for) for e in entries(moments, rooms)]


def test_rooms_entered_for_the_first_time_and_left_are_new() -> None:
    assert judged(HOME, IN_B, IN_C) == [(NEW, "B", "")]  # C is not decided yet


def test_a_place_recognised_in_its_own_room_is_a_right_merge() -> None:
    merged = stay(2, "A", 1, began=12, came_from=3, known=True)
    assert judged(HOME, IN_B, IN_C, BACK_IN_A, merged)[2:] == [(RIGHT, "A", "A")]


def test_a_place_taken_for_one_of_another_room_is_a_wrong_merge() -> None:
    merged = stay(2, "A", 2, began=12, came_from=3, known=True)
    assert judged(HOME, IN_B, IN_C, BACK_IN_A, merged)[2:] == [(WRONG, "A", "B")]


def test_a_place_recognised_at_the_last_moment_counts_where_it_was_left() -> None:
    beyond = stay(2, "D", 5, began=15, came_from=1)
    assert judged(HOME, IN_B, IN_C, BACK_IN_A, beyond)[2:] == [(RIGHT, "A", "A")]


def test_a_known_room_cut_once_more_is_a_missed_merge() -> None:
    beyond = stay(2, "D", 5, began=15, came_from=4)
    assert judged(HOME, IN_B, IN_C, BACK_IN_A, beyond)[2:] == [(MISSED, "A", "")]


def test_a_room_cut_in_two_is_no_missed_merge() -> None:
    second_half = stay(3, "C", 4, began=12, came_from=3)
    beyond = stay(2, "D", 5, began=15, came_from=4)
    assert judged(HOME, IN_B, IN_C, second_half, beyond)[2:] == [(SPLIT, "C", "")]


def test_a_link_walked_again_is_no_entry() -> None:
    back = stay(3, "B", 2, began=12, came_from=3, known=True)
    beyond = stay(2, "A", 1, began=15, came_from=2, known=True)
    assert len(judged(HOME, IN_B, IN_C, back, beyond)) == 2


def test_what_the_robot_believes_later_does_not_change_which_room_a_place_is() -> None:
    wrong = stay(20, "A", 2, began=12, came_from=3, known=True)  # from now on, 2 is mostly A
    assert judged(HOME, IN_B, IN_C, BACK_IN_A, wrong)[2:] == [(WRONG, "A", "B")]
