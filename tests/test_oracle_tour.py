"""The oracle's tour sees what it must, and is not longer than a way that a person finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.oracle_tour import _length, _shortened, oracle_tour, tour_length


def plan(walls: list[Any], home: list[float]) -> FloorPlan:
    empty: dict[str, Any] = {"furniture": [], "doors": {}, "closed": [], "barriers": {}}
    rooms = {"R": walls[0][:-1]}
    return FloorPlan.from_mapping(
        {"name": "p", "walls": walls, "home": home, "rooms": rooms, **empty}
    )


def test_what_is_all_seen_from_home_needs_no_tour() -> None:
    square = plan([[[0, 0], [6, 0], [6, 6], [0, 6], [0, 0]]], [1.0, 1.0, 0.0])
    assert tour_length(square) == 0.0


def test_in_an_angle_one_goes_until_one_sees_round_the_corner() -> None:
    angle = [[0, 0], [12, 0], [12, 12], [10, 12], [10, 2], [0, 2], [0, 0]]
    found = tour_length(plan([angle], [1.0, 1.0, 0.0]))
    assert 7.0 < found < 10.5, "the leg is seen from its mouth, 9 m away at its nearest"


def test_two_rooms_are_seen_with_a_step_through_the_door() -> None:
    way = oracle_tour(FloorPlan.load("two_rooms"))
    home = FloorPlan.load("two_rooms").home.position
    assert np.allclose(way[0], home)
    assert 0.0 < tour_length(FloorPlan.load("two_rooms")) < 8.0


def test_a_tour_that_crosses_itself_is_undone() -> None:
    points = np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)])
    lengths = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    order = _shortened(lengths, [0, 2, 1, 3])
    assert order == [0, 1, 2, 3]
    assert _length(lengths, order) == pytest.approx(3.0)
