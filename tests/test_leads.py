"""What other places still hide, and whether a robot turns back for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.exits import Exit
from agents.cogmap.leads import unexplored, way_to_leads
from agents.cogmap.memory import NEWBORN, Leads, Memory
from agents.cogmap.params import Params
from cogmap_gym.geometry import Segments
from tests.simulated import segments

P = Params()


def door(number: int, x: float, left: int, right: int, crossed: int = 1) -> Exit:
    return Exit(number, segments((x, -0.5, x, 0.5))[0], left, right, 2, crossed)


def in_a_row(gap: Segments | None, wall: Segments | None, onward: bool) -> Memory:
    """In place 2, come from place 1 at x < 0, which hides something; place 3 lies at x > 4."""
    none = np.zeros((0, 2, 2))
    left = Leads(gaps=none if gap is None else gap, dim=none if wall is None else wall)
    book = (door(1, 0.0, 1, 2), *((door(2, 4.0, 2, 3),) if onward else ()))
    stay = replace(NEWBORN.stay, place=2, known=True, settled=True, entry=1, came_from=1)
    mapping = replace(NEWBORN.mapping, mfis_from_robot=replace(NEWBORN.pose, x=1.0), step=10_000)
    return replace(NEWBORN, mapping=mapping, book=book, stay=stay, leads=((1, left),))


def first_exit(memory: Memory) -> int | None:
    way = way_to_leads(memory, P)
    return None if way is None else way.id


NEAR = segments((-5, 1, -5, -1))


def test_a_robot_turns_back_for_what_a_place_hides_only_if_it_cannot_go_on() -> None:
    for gap, wall in ((NEAR, None), (None, NEAR)):
        assert first_exit(in_a_row(gap, wall, onward=True)) is None
        assert first_exit(in_a_row(gap, wall, onward=False)) == 1


def test_it_turns_back_for_an_exit_never_crossed() -> None:
    memory = in_a_row(None, None, onward=True)
    assert first_exit(replace(memory, book=(*memory.book, door(3, -5.0, 1, 0, crossed=-1)))) == 1


def test_where_nothing_is_left_nothing_is_unexplored() -> None:
    assert not unexplored(in_a_row(None, None, onward=True), P)
    assert unexplored(in_a_row(NEAR, None, onward=False), P)
    here = in_a_row(None, None, onward=True)
    assert unexplored(here.with_leads(gaps=NEAR), P)
