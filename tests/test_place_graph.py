"""Believed networks against a hall with three rooms, by hand."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np
import pytest

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.place_graph import edit_distance, network_scores, true_network

ROOMS = {"west": (-4.0, 0.0), "hall": (0.0, 0.0), "east": (4.0, 0.0), "north": (0.0, 4.0)}
NUMBER = {"hall": 1, "west": 2, "north": 3, "east": 4}
DOORS = {
    "W": [[-2.0, -0.5], [-2.0, 0.5]],
    "N": [[-0.5, 2.0], [0.5, 2.0]],
    "E": [[2.0, -0.5], [2.0, 0.5]],
}
EXITS = {"W": 21, "N": 22, "E": 23}
TOUR = ("hall", "west", "hall", "north", "hall", "east")


def square(x: float, y: float) -> list[list[float]]:
    return [[x - 2, y - 2], [x + 2, y - 2], [x + 2, y + 2], [x - 2, y + 2]]


def hall() -> FloorPlan:
    walls = [
        [[-2, -0.5], [-2, -2], [2, -2], [2, -0.5]],
        [[2, 0.5], [2, 2], [0.5, 2]],
        [[-0.5, 2], [-2, 2], [-2, 0.5]],
        [[-2, -2], [-6, -2], [-6, 2], [-2, 2]],
        [[2, -2], [6, -2], [6, 2], [2, 2]],
        [[-2, 2], [-2, 6], [2, 6], [2, 2]],
    ]
    return FloorPlan.from_mapping(
        {
            "name": "hall",
            "walls": walls,
            "furniture": [],
            "doors": DOORS,
            "closed": [],
            "barriers": {},
            "rooms": {name: square(*at) for name, at in ROOMS.items()},
            "home": [0.0, 0.0, 0.0],
        }
    )


def walked(rooms: tuple[str, ...]) -> np.ndarray[Any, Any]:
    """A path by the middles of rooms, 0.25 m a step."""
    corners = np.array([ROOMS[name] for name in rooms])
    pieces = [a + np.linspace(0, 1, 17)[:, None] * (b - a) for a, b in pairwise(corners)]
    points = np.concatenate(pieces)
    return np.column_stack((points, np.zeros(len(points))))


def sketch(**changed: Any) -> dict[str, Any]:
    """What a robot believes that has it all right."""
    asrs = [
        {
            "id": NUMBER[name],
            "boundary": square(*at),
            "exits": list(EXITS.values()) if name == "hall" else [],
        }
        for name, at in ROOMS.items()
    ]
    exits = [{"id": EXITS[door], "p": line[0], "q": line[1]} for door, line in DOORS.items()]
    links = [[1, 21, 2], [1, 22, 3], [4, 23, 1]]
    return {"asrs": asrs, "exits": exits, "links": links, **changed}


def scores(told: dict[str, Any], rooms: tuple[str, ...] = TOUR) -> dict[str, float | None]:
    plan, path = hall(), walked(rooms)
    true = [plan.room_at(x, y) or "" for x, y in path[:, :2]]
    return network_scores(told, [NUMBER[room] for room in true], true, plan, path)


def test_the_truth_is_what_was_gone_through() -> None:
    graph = true_network(hall(), walked(("hall", "west")))
    assert set(graph) == {"hall", "west"}
    assert graph.edges["hall", "west"]["door"] == "W"


def test_a_robot_that_has_it_all_right() -> None:
    assert scores(sketch()) == {
        "rooms_found": 1.0,
        "link_precision": 1.0,
        "link_recall": 1.0,
        "edit_distance": 0.0,
        "exit_order": 1.0,
    }


def test_a_link_too_many_and_one_missing() -> None:
    told = scores(sketch(links=[[1, 21, 2], [1, 22, 3], [2, 24, 3]]))
    assert told["link_precision"] == pytest.approx(2 / 3)
    assert told["link_recall"] == pytest.approx(2 / 3)
    assert told["edit_distance"] == 2.0
    assert told["exit_order"] is None, "two exits are always in order"


def test_a_mirrored_hall_has_its_exits_out_of_order() -> None:
    mirrored = sketch()
    for asr in mirrored["asrs"]:
        asr["boundary"] = [[-x, y] for x, y in asr["boundary"]]
    for leave in mirrored["exits"]:
        leave["p"], leave["q"] = ([-x, y] for x, y in (leave["p"], leave["q"]))
    assert scores(mirrored)["exit_order"] == 0.0


def test_a_turned_hall_has_them_in_order() -> None:
    turned = sketch()
    for asr in turned["asrs"]:
        asr["boundary"] = [[-y, x] for x, y in asr["boundary"]]
    for leave in turned["exits"]:
        leave["p"], leave["q"] = ([-y, x] for x, y in (leave["p"], leave["q"]))
    assert scores(turned)["exit_order"] == 1.0


def test_a_room_that_is_two_places_is_not_found() -> None:
    plan, path = hall(), walked(TOUR)
    true = [plan.room_at(x, y) or "" for x, y in path[:, :2]]
    places = [NUMBER[room] for room in true]
    places[-4:] = [5] * 4
    doubled = sketch()
    doubled["asrs"].append({"id": 5, "boundary": [], "exits": []})
    told = network_scores(doubled, places, true, plan, path)
    assert told["rooms_found"] == 0.75
    assert told["edit_distance"] == 1.0


def test_a_robot_without_places_has_no_scores() -> None:
    assert set(scores(sketch(asrs=[])).values()) == {None}


def test_the_edit_distance_counts_places_links_and_wrong_rooms() -> None:
    one, other = nx.path_graph(3), nx.path_graph(2)
    for graph in (one, other):
        nx.set_node_attributes(graph, {k: f"room {k}" for k in graph}, "room")
    assert edit_distance(one, other) == 2.0
    nx.set_node_attributes(other, {1: "elsewhere"}, "room")
    assert edit_distance(other, nx.induced_subgraph(one, [0, 1])) == 1.0
