"""The network of ASRs and the routes over it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.cogmap.asr import ASR
from agents.cogmap.exits import NOWHERE, Book, Exit
from agents.cogmap.places import Network, exits_of, linked, links, route
from cogmap_gym.geometry import Points

NO_IDS: frozenset[int] = frozenset()


def door(number: int, at: tuple[float, float], left: int, right: int, crossed: int = 1) -> Exit:
    line = np.array(at) + np.array([[0.0, -0.5], [0.0, 0.5]])
    return Exit(number, line, left, right, 2, crossed)


def ring(count: int = 6) -> Book:
    """Doors of a ring of places 1..count; door k between place k and the next, on a circle."""
    turns = 2 * np.pi * (np.arange(count) + 0.5) / count
    return tuple(
        door(k + 1, (10 * np.cos(t), 10 * np.sin(t)), k + 1, (k + 1) % count + 1)
        for k, t in enumerate(turns)
    )


def middle(place: int, count: int = 6) -> Points:
    turn = 2 * np.pi * (place - 1) / count
    return 10 * np.array((np.cos(turn), np.sin(turn)))


def way(book: Book, start: int, goal: int, hidden: frozenset[int] = NO_IDS) -> list[int] | None:
    found = route(book, middle(start), start, middle(goal), goal, hidden)
    return None if found is None else list(found.exits)


def asr(number: int, closed: bool = True, size: float = 1.0) -> ASR:
    square = size * np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    ids, points = np.arange(2), np.zeros((0, 2))
    boundary = square if closed else points
    return ASR(number, boundary, ids, ids, points, np.zeros((0, 2, 2)))


def test_in_its_own_place_no_exit_is_on_the_way() -> None:
    assert way(ring(), 3, 3) == []


def test_the_shorter_way_round_the_ring_is_taken() -> None:
    assert way(ring(), 1, 3) == [1, 2]
    assert way(ring(), 3, 1) == [2, 1]
    assert way(ring(), 1, 5) == [6, 5]


def test_round_a_hidden_exit_the_way_leads_over_the_others() -> None:
    assert way(ring(), 1, 3, frozenset({1})) == [6, 5, 4, 3]
    assert way(ring(), 1, 3, frozenset({1, 6})) is None
    assert way(ring(), 1, 3, frozenset({1, 3})) is None


def test_a_chord_is_a_short_cut_once_it_was_crossed() -> None:
    crossed = (*ring(), door(7, (0, 0), 1, 4))
    assert way(crossed, 1, 4) == [7]
    assert way((*ring(), door(7, (0, 0), 1, 4, crossed=-1)), 1, 4) in ([1, 2, 3], [6, 5, 4])


def test_to_a_place_of_no_link_there_is_no_way() -> None:
    assert way(ring(), 1, 9) is None
    assert way((), 1, 2) is None
    assert way((), 1, 1) == []


def test_an_exit_from_a_place_to_itself_is_no_link() -> None:
    loop = (*ring(), door(7, (8, 0), 1, 1))
    assert way(loop, 1, 3) == [1, 2]
    assert all(number != 7 for _, number, _ in links(loop))
    assert [e.id for e in exits_of(loop, 1)] == [1, 6]


@given(st.integers(0, 999))
def test_a_route_starts_here_ends_there_and_is_no_longer_than_any_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    book = tuple(
        door(k + 1, tuple(rng.uniform(-9, 9, 2)), *rng.choice(np.arange(1, 6), 2, replace=False))
        for k in range(8)
    )
    start, goal = rng.uniform(-9, 9, (2, 2))
    found = route(book, start, 1, goal, 4, NO_IDS)
    graph = nx.MultiGraph([(e.left, e.right, e.id) for e in book])
    if found is None:
        assert not (graph.has_node(1) and graph.has_node(4) and nx.has_path(graph, 1, 4))
        return
    place = 1
    for number in found.exits:
        place = book[number - 1].beyond(place)
    assert place == 4

    def length(numbers: Sequence[int]) -> float:
        spots = [start, *(book[n - 1].middle for n in numbers), goal]
        return sum(float(np.hypot(*(b - a))) for a, b in itertools.pairwise(spots))

    others = [
        [book_id for _, _, book_id in edges] for edges in nx.all_simple_edge_paths(graph, 1, 4)
    ]
    assert found.length == pytest.approx(length(found.exits))
    assert found.length <= min(map(length, others)) + 1e-9


def test_linked_are_the_places_on_this_side_of_what_is_hidden() -> None:
    assert linked(ring(), 1, NO_IDS) == {1, 2, 3, 4, 5, 6}
    assert linked(ring(), 1, frozenset({1, 3})) == {1, 4, 5, 6}
    assert linked(ring()[::-1], 2, frozenset({1, 3})) == {2, 3}
    assert linked(ring(), 9, NO_IDS) == {9}
    assert linked((), 1, NO_IDS) == {1}
    assert linked((door(1, (0, 0), 1, 2, crossed=-1),), 1, NO_IDS) == {1}


def test_links_are_the_crossed_exits_with_a_place_on_both_sides() -> None:
    book = (door(1, (0, 0), 2, 1), door(2, (5, 0), 2, 3, crossed=-1), door(3, (9, 0), 2, NOWHERE))
    assert links(book) == [(1, 1, 2)]


def test_the_network_keeps_one_asr_a_place_in_order() -> None:
    network = Network().with_asr(asr(2)).with_asr(asr(1)).with_asr(asr(2, size=3.0))
    assert [a.id for a in network.asrs] == [1, 2]
    found = network.asr(2)
    assert found is not None
    assert found.boundary.max() == pytest.approx(3.0)
    assert network.asr(7) is None


def test_an_open_boundary_replaces_no_closed_one() -> None:
    network = Network().with_asr(asr(1, closed=True))
    assert network.with_asr(asr(1, closed=False, size=9.0)) is network
    opened = Network().with_asr(asr(1, closed=False)).with_asr(asr(1, closed=True, size=9.0))
    kept = opened.asr(1)
    assert kept is not None
    assert kept.closed


def test_a_network_is_not_changed_by_what_is_added() -> None:
    empty = Network((), 3)
    assert empty.with_asr(asr(1)).last_id == 3
    assert empty.asrs == ()
    assert replace(empty, last_id=4).last_id == 4
