"""Generated offices: each is an office that a robot can live in."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from functools import cache
from itertools import combinations
from pathlib import Path

import gymnasium as gym
import networkx as nx
import numpy as np
import pytest
import shapely
from gymnasium.envs.registration import EnvSpec
from shapely.geometry import LineString, MultiLineString, Point, Polygon

from cogmap_gym import FloorPlan, generator
from cogmap_gym.geometry import Points, Pose, lengths
from cogmap_gym.observation import RobotSpec
from cogmap_gym.office_layout import DIFFICULTIES
from cogmap_gym.routes import Routes
from cogmap_gym.world import World

NAMES = [f"office:{seed}:{level}" for level in DIFFICULTIES for seed in range(1100, 1125)]
EACH = pytest.mark.parametrize("name", NAMES)
TOUCH = 1e-6
MARGIN = 0.30  # of a disc that gets everywhere: the robot's radius and 5 cm [m]


@cache
def plan(name: str) -> FloorPlan:
    return FloorPlan.load(name)


@cache
def polygons(name: str) -> dict[str, Polygon]:
    return {room: Polygon(points) for room, points in plan(name).rooms.items()}


@cache
def sides(name: str) -> dict[str, tuple[str, ...]]:
    """The rooms on the sides of each door."""
    near = {room: polygon.buffer(TOUCH) for room, polygon in polygons(name).items()}
    return {
        door: tuple(room for room, polygon in near.items() if polygon.covers(LineString(ends)))
        for door, ends in plan(name).doors.items()
    }


def opened(name: str, doors: set[str]) -> nx.Graph[str]:
    """The graph of the rooms by some of the doors."""
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(plan(name).rooms)
    graph.add_edges_from(pair for door, pair in sides(name).items() if door in doors)
    return graph


@EACH
def test_a_disc_gets_from_home_to_every_room_with_the_chords_shut(name: str) -> None:
    shut = MultiLineString([plan(name).doors[door] for door in plan(name).closed])
    roomy = plan(name).free_space().difference(shut.buffer(0.001)).buffer(-MARGIN)
    assert roomy.geom_type == "Polygon"
    assert roomy.covers(Point(plan(name).home.position))
    for polygon in polygons(name).values():
        assert polygon.intersection(roomy).area > 1.0


@EACH
def test_no_passage_is_between_0_5_and_0_7_m_wide(name: str) -> None:
    free = plan(name).free_space()
    tight, roomy = free.buffer(-0.25), free.buffer(-0.35)
    assert tight.geom_type == roomy.geom_type == "Polygon"
    assert len(tight.interiors) == len(roomy.interiors)
    lost = tight.buffer(0.25).difference(roomy.buffer(0.351))
    assert max(part.area for part in shapely.get_parts(lost)) < 0.05


@EACH
def test_rooms_fill_the_free_space_without_overlap(name: str) -> None:
    spaces = [plan(name).room_free_space(room) for room in plan(name).rooms]
    assert sum(space.area for space in spaces) == pytest.approx(plan(name).area)
    assert shapely.union_all(spaces).area == pytest.approx(plan(name).area)


@EACH
def test_each_door_is_between_two_rooms_and_0_8_to_1_0_m_wide_from_jamb_to_jamb(name: str) -> None:
    walls = MultiLineString(list(plan(name).wall_segments()))
    assert all(len(pair) == 2 for pair in sides(name).values())
    assert len(set(sides(name).values())) == len(sides(name))
    for ends in plan(name).doors.values():
        leaf = LineString(ends)
        assert 0.8 - TOUCH <= leaf.length <= 1.0 + TOUCH
        assert all(walls.distance(Point(end)) < TOUCH for end in ends)
        assert walls.distance(leaf.centroid) == pytest.approx(leaf.length / 2.0)


@EACH
def test_the_rooms_hang_together_in_loops_with_the_chords_shut(name: str) -> None:
    graph = opened(name, set(plan(name).doors) - set(plan(name).closed))
    assert nx.is_connected(graph)
    loops = graph.number_of_edges() - graph.number_of_nodes() + 1
    assert loops >= DIFFICULTIES[name.split(":")[2]].loops


@EACH
def test_an_office_has_the_rooms_corridors_and_chords_that_it_should(name: str) -> None:
    level = DIFFICULTIES[name.split(":")[2]]
    rooms = [room for room in plan(name).rooms if room[0] == "R"]
    corridors = [room for room in plan(name).rooms if room[0] == "C"]
    assert level.rooms[0] <= len(rooms) <= level.rooms[1]
    assert corridors
    assert 6 <= len(rooms) + len(corridors) == len(plan(name).rooms) <= 20
    assert level.chords[0] <= len(plan(name).closed) <= level.chords[1]
    assert set(plan(name).closed) == {door for door in plan(name).doors if door[0] == "S"}
    for corridor in corridors:
        inner = polygons(name)[corridor].buffer(-0.85)
        assert inner.area > 0.0
        assert polygons(name)[corridor].buffer(-1.21).area < 4.0  # but for niches and corners


@EACH
def test_home_has_room_and_lies_in_a_room(name: str) -> None:
    home = Point(plan(name).home.position)
    room = plan(name).room_at(home.x, home.y)
    assert room is not None
    assert room[0] == "R"
    assert home.distance(plan(name).free_space().boundary) >= 0.5


@EACH
def test_furniture_is_flush_or_free_and_keeps_away_from_doors(name: str) -> None:
    doors = MultiLineString(list(plan(name).door_segments()))
    walls = shapely.linestrings(plan(name).wall_segments())
    pieces = [Polygon(points) for points in plan(name).furniture]
    for piece in pieces:
        assert piece.distance(doors) >= 1.2 - 0.002
        room = next(r for r in polygons(name).values() if r.covers(piece.centroid))
        gaps = shapely.distance(piece, walls[shapely.covers(room.buffer(TOUCH), walls)])
        assert ((gaps < TOUCH) | (gaps > 0.8 - 0.002)).all()
    for room in polygons(name).values():
        inside = [piece for piece in pieces if room.covers(piece.centroid)]
        gaps = [piece.distance(other) for piece, other in combinations(inside, 2)]
        assert min(gaps, default=1.0) > 0.8 - 0.002


@EACH
def test_no_ray_leaves_an_office_whose_doors_are_open(name: str) -> None:
    walls = MultiLineString(list(plan(name).wall_segments()))
    angles = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False) + 1e-4
    for room in plan(name).rooms:
        start = np.array(plan(name).room_free_space(room).representative_point().coords[0])
        ends = start + 90.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)
        rays = shapely.linestrings(np.stack((np.broadcast_to(start, ends.shape), ends), axis=1))
        assert shapely.intersects(walls, rays).all()


@EACH
def test_walls_are_closed_rings_of_some_thickness(name: str) -> None:
    assert all((ring[0] == ring[-1]).all() for ring in plan(name).walls)
    assert lengths(plan(name).wall_segments()).min() > 0.04
    names = polygons(name)
    for first, second in combinations(names, 2):
        gap = names[first].distance(names[second])
        joined = any({first, second} == set(pair) for pair in sides(name).values())
        assert gap < TOUCH if joined else gap >= 0.1 / math.sqrt(2.0)


@pytest.mark.parametrize("name", NAMES[::6])
def test_opening_a_chord_makes_the_way_between_its_sides_shorter(name: str) -> None:
    world = World(plan(name), RobotSpec())
    routes = Routes(world)
    for door in plan(name).closed:
        near, far = beside(plan(name).doors[door])
        long = routes.distance(near, far)
        world.set_door(door, shut=False)
        short = routes.distance(near, far)
        world.set_door(door, shut=True)
        assert short < 2.0
        assert math.isfinite(long)
        assert long > short + 2.0


def beside(ends: Points) -> tuple[Pose, Pose]:
    """Poses 0.7 m before and behind a door."""
    through = 0.7 * np.array((-(ends[1] - ends[0])[1], (ends[1] - ends[0])[0]))
    through /= np.hypot(*(ends[1] - ends[0]))
    middle = ends.mean(axis=0)
    return Pose(*(middle - through).tolist(), 0.0), Pose(*(middle + through).tolist(), 0.0)


def test_the_same_name_gives_the_same_bits_in_another_process() -> None:
    names = [NAMES[0], NAMES[30], NAMES[60]]
    here = [json.dumps(generator.office(name)) for name in names]
    code = f"import json\nfrom cogmap_gym import generator\nfor n in {names}:"
    code += "\n    print(json.dumps(generator.office(n)))"
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert there.stdout.splitlines() == here


def test_other_seeds_and_levels_give_other_offices() -> None:
    plans = [json.dumps(plan(name).to_mapping()["walls"]) for name in NAMES]
    assert len(set(plans)) == len(NAMES)


def test_offices_lie_at_any_heading_and_far_from_the_origin() -> None:
    walls = [plan(name).wall_segments()[0] for name in NAMES]
    headings = [math.atan2(*(w[1] - w[0])[::-1]) % (math.pi / 2.0) for w in walls]
    assert np.histogram(headings, 4, (0.0, math.pi / 2.0))[0].min() > 5
    assert np.std([plan(name).home.position for name in NAMES], axis=0).min() > 10.0


def test_the_difficulty_is_medium_if_left_out() -> None:
    short, long = (generator.office(name) for name in ("office:1000", "office:1000:medium"))
    assert short | {"name": ""} == long | {"name": ""}


@pytest.mark.parametrize("name", NAMES[::25])
def test_an_office_survives_its_file_and_its_mapping(name: str, tmp_path: Path) -> None:
    plan(name).save(tmp_path / "office.yaml")
    again = FloorPlan.load(tmp_path / "office.yaml")
    assert again.to_mapping() == plan(name).to_mapping()
    mapping = json.loads(json.dumps(plan(name).to_mapping()))
    assert FloorPlan.load(mapping).to_mapping() == plan(name).to_mapping()


def test_an_environment_on_an_office_survives_json() -> None:
    env = gym.make("CogMap/Explore-v0", map=NAMES[0])
    assert env.spec is not None
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    first, second = (e.reset(seed=1)[0]["scan"] for e in (env, again))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    "name", ["office:", "office:-1", "office:1.5", "office:1:huge", "office:1234567", "office:1:"]
)
def test_a_wrong_name_is_refused_with_what_was_expected(name: str) -> None:
    with pytest.raises(ValueError, match="expected office:SEED or office:SEED:DIFFICULTY") as error:
        FloorPlan.load(name)
    assert repr(name) in str(error.value)


def test_the_seeds_for_tests_and_for_development_are_disjoint_and_usable() -> None:
    assert not set(generator.TEST_SEEDS) & set(generator.DEVELOPMENT_SEEDS)
    assert min(generator.DEVELOPMENT_SEEDS) >= 1000
    assert FloorPlan.load(f"office:{generator.DEVELOPMENT_SEEDS[-1]}").rooms
