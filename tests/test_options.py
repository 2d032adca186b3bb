"""The ways weighed at a block: the known one, going back, and new exits (thesis 4.4.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents.cogmap.exits import Exit
from agents.cogmap.memory import NEWBORN, Journey, Mark, Memory
from agents.cogmap.options import BACK, KNOWN, NEW, newly_chosen, weighed
from agents.cogmap.params import Params

GOAL = np.array((10.0, 0.0))


def door(number: int, at: tuple[float, float], left: int, right: int, crossed: int = 1) -> Exit:
    line = np.array(at) + np.array([[0.0, -0.5], [0.0, 0.5]])
    return Exit(number, line, left, right, 2, crossed)


def travelling(blocked: frozenset[int], route: tuple[int, ...] | None = None) -> Memory:
    """In place 1 at the origin, bound for place 2: door 1 is near, 2 and 3 far round, 4 is new."""
    book = (
        door(1, (5, 0), 1, 2),
        door(2, (0, 20), 1, 3),
        door(3, (10, 20), 3, 2),
        door(4, (5, 3), 1, 0, crossed=-1),
    )
    return replace(
        NEWBORN,
        book=book,
        marks=(Mark(7, 2, GOAL),),
        journey=Journey(7, blocked),
        route=route,
    )


def test_where_the_way_is_shut_it_is_weighed_with_going_back_and_a_new_exit() -> None:
    known, back, new = weighed(travelling(frozenset({1})), Params())
    assert (known.kind, known.exits, known.length) == (KNOWN, (1,), pytest.approx(10.0))
    assert (back.kind, back.exits, back.length) == (BACK, (2, 3), pytest.approx(50.0))
    assert (new.kind, new.exits) == (NEW, (4,))
    assert new.length == pytest.approx(2.0 * np.hypot(5.0, 3.0))
    for way in (known, back, new):
        assert np.allclose(way.points[[0, -1]], [[0.0, 0.0], GOAL])
        assert np.hypot(*np.diff(way.points, axis=0).T).sum() == pytest.approx(way.length)


def test_an_open_way_is_not_called_shut() -> None:
    kinds = [way.kind for way in weighed(travelling(frozenset()), Params())]
    assert kinds == [BACK, NEW]


def test_what_is_blocked_is_no_option() -> None:
    ways = weighed(travelling(frozenset({1, 2, 4})), Params())
    assert [(way.kind, way.exits) for way in ways] == [(KNOWN, (1,))]


def test_without_a_journey_nothing_is_weighed() -> None:
    memory = replace(travelling(frozenset({1})), journey=None)
    assert weighed(memory, Params()) == ()
    assert newly_chosen(memory) == 0


def test_a_new_exit_is_chosen_once_the_route_leads_over_it() -> None:
    shut = frozenset({1})
    assert newly_chosen(travelling(shut, (4,))) == 4
    assert newly_chosen(travelling(shut, (2, 3))) == 0
    assert newly_chosen(travelling(shut)) == 0
    assert newly_chosen(travelling(frozenset(), (4,))) == 0
