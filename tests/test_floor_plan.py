"""Floor plans: what they hold and what they answer."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, cross, lengths
from tests import rooms

BUILT = (
    rooms.square_room,
    rooms.corridor,
    rooms.room_with_pillar,
    rooms.l_room,
    rooms.thin_rooms,
    rooms.ring_of_four,
)


def thin() -> dict[str, Any]:
    return rooms.thin_rooms().to_mapping()


@pytest.mark.parametrize("build", BUILT)
def test_a_plan_survives_mapping_json_and_pickle(build: Any) -> None:
    plan = build()
    mapping = plan.to_mapping()
    through_json = FloorPlan.from_mapping(json.loads(json.dumps(mapping)))
    for twin in (through_json, pickle.loads(pickle.dumps(plan)), copy.deepcopy(plan)):
        assert twin.to_mapping() == mapping
        assert twin.home == plan.home
        assert np.array_equal(twin.walls_and_furniture(), plan.walls_and_furniture())


def test_load_takes_a_plan_a_mapping_a_name_and_a_path(tmp_path: Path) -> None:
    plan = rooms.thin_rooms()
    assert FloorPlan.load(plan) is plan
    assert FloorPlan.load(plan.to_mapping()).to_mapping() == plan.to_mapping()
    plan.save(tmp_path / "mine.yaml")
    assert FloorPlan.load(str(tmp_path / "mine.yaml")).name == "thin_rooms"
    assert FloorPlan.load("two_rooms").name == "two_rooms"


@pytest.mark.parametrize("degrees", [0, 30, 90, -90, 180, 12.345, 270, -180, 540, 1e4])
def test_home_is_in_degrees_in_a_file_and_in_radians_in_a_plan(degrees: float) -> None:
    plan = FloorPlan.from_mapping(thin() | {"home": [2, 2.5, degrees]})
    written = plan.to_mapping()["home"][2]
    assert -180.0 < written <= 180.0
    assert (written - degrees) % 360.0 == 0.0
    assert math.isclose(plan.home.theta, math.radians(written))


def test_arrays_of_a_plan_cannot_be_changed() -> None:
    plan = rooms.thin_rooms()
    with pytest.raises(ValueError, match="read-only"):
        plan.walls[0][0, 0] = 9.0
    with pytest.raises(TypeError):
        plan.doors["E2"] = plan.walls[0]  # type: ignore[index]


def test_segments_are_the_edges_in_the_order_of_the_file() -> None:
    plan = rooms.room_with_pillar()
    assert plan.wall_segments().shape == (8, 2, 2)
    assert plan.furniture_segments().shape == (4, 2, 2)
    assert plan.walls_and_furniture().shape == (12, 2, 2)
    assert plan.door_segments().shape == plan.barrier_segments().shape == (0, 2, 2)
    four = rooms.ring_of_four()
    assert four.door_names == ("E1", "E2", "E3", "E4")
    assert np.array_equal(four.door_segments()[2], four.doors["E3"])


@pytest.mark.parametrize("turned", [False, True])
def test_furniture_has_free_space_on_the_left_however_it_is_drawn(turned: bool) -> None:
    ring = [[1.0, 3.0], [2.0, 3.0], [2.0, 4.0], [1.0, 4.0]]
    mapping = thin() | {"furniture": [ring[::-1] if turned else ring]}
    edges = FloorPlan.from_mapping(mapping).furniture_segments()
    to_middle = np.array((1.5, 3.5)) - edges[:, 0]
    assert (cross(edges[:, 1] - edges[:, 0], to_middle) < 0.0).all()
    assert np.allclose(lengths(edges), 1.0)


def test_free_space_is_what_the_walls_enclose_less_furniture_and_pillars() -> None:
    assert rooms.square_room(6.0).area == pytest.approx(36.0)
    assert rooms.room_with_pillar().area == pytest.approx(36.0 - 1.0 - 1.0)
    assert rooms.l_room().area == pytest.approx(48.0)
    assert rooms.ring_of_four().area == pytest.approx(100.0 - 4.0, abs=0.1)


def test_free_space_goes_through_doors_and_not_through_thin_walls() -> None:
    plan = FloorPlan.from_mapping(thin() | {"closed": ["E1"]})
    free = plan.free_space()
    assert free.covers(Point(4.0, 2.5))
    assert not free.covers(Point(4.0, 1.0))
    assert free.covers(Point(7.0, 1.0))
    assert free.buffer(-0.6).geom_type == "MultiPolygon"


def test_free_space_leaves_out_what_cannot_be_reached() -> None:
    sealed = thin() | {"doors": {}, "barriers": {}}
    sealed["walls"] = [sealed["walls"][0], [[4, 0], [4, 5]]]
    assert FloorPlan.from_mapping(sealed).area == pytest.approx(20.0)


def test_the_free_space_of_a_room_is_its_polygon_less_furniture() -> None:
    plan = FloorPlan.load("two_rooms")
    room = Polygon(plan.rooms["R1"])
    assert plan.room_free_space("R1").area == pytest.approx(room.area - 0.5)
    with pytest.raises(ValueError, match=r"rooms: .*R9"):
        plan.room_free_space("R9")


def test_room_at_names_the_room_of_a_point() -> None:
    plan = rooms.thin_rooms()
    assert plan.room_at(1.0, 1.0) == "R1"
    assert plan.room_at(7.0, 1.0) == "R2"
    assert plan.room_at(4.0, 2.5) == "R1"
    assert plan.room_at(9.0, 1.0) is None
    assert rooms.plan(walls=[[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]).room_at(1, 1) is None


def test_bounds_are_those_of_the_walls() -> None:
    assert rooms.thin_rooms().bounds == (0.0, 0.0, 8.0, 5.0)


def test_a_pickled_plan_keeps_every_bit_of_its_home() -> None:
    plan = FloorPlan.load("two_rooms")
    for theta in np.random.default_rng(0).uniform(-np.pi, np.pi, 20).tolist():
        turned = dataclasses.replace(plan, home=Pose(2.0, 2.5, theta))
        assert pickle.loads(pickle.dumps(turned)).home == turned.home
        again = FloorPlan.from_mapping(turned.to_mapping())
        assert again.home.theta == pytest.approx(theta, abs=1e-13)
        assert again.to_mapping() == turned.to_mapping()


def test_a_plan_that_is_built_directly_is_checked_too() -> None:
    wall = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]])
    plan = FloorPlan("bare", (wall,), (), {}, (), {}, {}, Pose(1.0, 1.0, 0.5))
    assert plan.area == pytest.approx(81.0)
    with pytest.raises(ValueError, match="home"):
        FloorPlan("bare", (wall,), (), {}, (), {}, {}, Pose(0.1, 1.0, 0.5))
