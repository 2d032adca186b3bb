"""The oracle's ways: worked cases, laws, and a driver that follows them through every task."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from cogmap_gym import FloorPlan, RobotSpec
from cogmap_gym.blocks import Block, doors_on
from cogmap_gym.chords import chords, rooms_to_visit
from cogmap_gym.events import Event, EventQueue
from cogmap_gym.geometry import Points, Pose, point_segment_distances
from cogmap_gym.learning_walk import learning_length
from cogmap_gym.routes import Routes
from cogmap_gym.world import World
from tests.oracle_driver import Driver, middle
from tests.rooms import plan, ring_of_four, room_with_pillar

OFFICE = FloorPlan.load("thesis_office")
CLOCKWISE = ("ASR2", "ASR3", "ASR4", "ASR5", "ASR6", "ASR1")
RADIUS = RobotSpec().radius
PLACES = {room: middle(OFFICE, room) for room in OFFICE.rooms}


def routed(of: FloorPlan) -> tuple[World, Routes]:
    world = World(of, RobotSpec())
    return world, Routes(world)


def moved(points: Points, motion: Pose) -> list[Any]:
    return motion.apply(np.asarray(points)).tolist()


def slit(width: float) -> FloorPlan:
    """Two rooms that a gap of a given width joins."""
    return plan(
        walls=[
            [[0, 0], [8, 0], [8, 5], [0, 5], [0, 0]],
            [[4, 0], [4, 2]],
            [[4, 2 + width], [4, 5]],
        ]
    )


def test_a_way_round_a_corner_is_two_tangents_and_an_arc() -> None:
    _, routes = routed(slit(1.5))
    aside, up = 2.0, 1.0
    to_corner = math.hypot(aside, up)
    tangent = math.sqrt(to_corner**2 - RADIUS**2)
    arc = 2.0 * (math.pi - math.atan2(aside, up) - math.acos(RADIUS / to_corner))
    expected = 2.0 * tangent + RADIUS * arc
    found = routes.distance(Pose(2.0, 1.0), Pose(6.0, 1.0))
    assert expected <= found <= expected + 0.01


@pytest.mark.parametrize(("width", "open_"), [(0.45, False), (0.49, False), (0.52, True)])
def test_a_gap_narrower_than_the_body_is_no_way(width: float, open_: bool) -> None:
    _, routes = routed(slit(width))
    assert math.isfinite(routes.distance(Pose(2.0, 2.5), Pose(6.0, 2.5))) == open_


def test_a_straight_way_is_the_straight_distance() -> None:
    _, routes = routed(room_with_pillar())
    assert routes.distance(Pose(1.0, 1.0), Pose(5.0, 1.0)) == pytest.approx(4.0)
    assert routes.distance(Pose(1.0, 1.0), Pose(1.0, 1.0)) == 0.0


def test_ways_keep_the_radius_clear_and_are_as_long_as_told() -> None:
    world, routes = routed(OFFICE)
    for room in CLOCKWISE[:-1]:
        way = routes.way(OFFICE.home, PLACES[room])
        assert way is not None
        pieces = np.hypot(*np.diff(way, axis=0).T)
        assert pieces.sum() == pytest.approx(routes.distance(OFFICE.home, PLACES[room]))
        along = np.concatenate(((0.0,), np.cumsum(pieces)))
        at = np.arange(0.0, along[-1], 0.05)
        points = np.stack([np.interp(at, along, way[:, k]) for k in (0, 1)], axis=1)
        gaps = point_segment_distances(points, world.solid_segments).min(axis=1)
        assert gaps.min() >= RADIUS - 2e-6


def test_distances_are_a_metric() -> None:
    _, routes = routed(OFFICE)
    places = [OFFICE.home, *(PLACES[room] for room in CLOCKWISE[:-1])]
    table = np.array([[routes.distance(a, b) for b in places] for a in places])
    assert np.allclose(table, table.T, atol=1e-6)
    assert (table[:, None] <= table[:, :, None] + table[None] + 1e-6).all()


def test_distances_do_not_depend_on_where_the_origin_is() -> None:
    motion, old = Pose(-31.7, 12.9, 0.83), OFFICE.to_mapping()
    lines = {key: [moved(line, motion) for line in old[key]] for key in ("walls", "furniture")}
    named = {
        key: {name: moved(points, motion) for name, points in old[key].items()}
        for key in ("doors", "barriers", "rooms")
    }
    home = motion @ OFFICE.home
    turned = FloorPlan.from_mapping(
        {**old, **lines, **named, "home": [home.x, home.y, math.degrees(home.theta)]}
    )
    _, routes = routed(OFFICE)
    _, turned_routes = routed(turned)
    for room in ("ASR2", "ASR3", "ASR5"):
        length = routes.distance(OFFICE.home, PLACES[room])
        there = turned_routes.distance(turned.home, motion @ PLACES[room])
        assert there == pytest.approx(length, abs=1e-4)


def test_ways_follow_the_doors_as_they_stand_or_might_stand() -> None:
    world, routes = routed(ring_of_four())
    there = Pose(7.0, 2.0)
    assert [c.door for c in doors_on(world, routes.way(world.pose, there))] == ["E4"]
    shut = frozenset({"E4"})
    assert [c.door for c in doors_on(world, routes.way(world.pose, there, shut))] == [
        "E1",
        "E2",
        "E3",
    ]
    world.set_door("E4", True)
    assert routes.distance(world.pose, there) == routes.distance(world.pose, there, shut)
    assert math.isinf(routes.distance(world.pose, there, shut | {"E2"}))
    assert routes.way(world.pose, there, shut | {"E2"}) is None


def learned(world: World, routes: Routes, goal: Pose, *events: Event) -> float:
    queue = EventQueue(world)
    queue.expect(events)
    return learning_length(world, routes, queue, goal, 32.0)


def test_who_learns_of_a_block_on_seeing_it_walks_to_where_it_is_seen() -> None:
    world, routes = routed(ring_of_four())
    goal, known = Pose(7.0, 9.0), world.state()
    straight, round_ = (
        routes.distance(world.pose, goal, frozenset(shut)) for shut in ((), ("E2",))
    )
    length = learned(world, routes, goal, Event("shut", "E2"))
    assert straight < round_ < length < 3.0 * round_
    assert learned(world, routes, goal) == pytest.approx(straight)
    assert world.state() == known


def test_a_block_in_sight_from_the_start_costs_nothing() -> None:
    world, routes = routed(ring_of_four())
    goal = Pose(7.0, 2.0)
    length = learned(world, routes, goal, Event("shut", "E4"))
    assert length == pytest.approx(routes.distance(world.pose, goal, frozenset({"E4"})))
    assert math.isinf(learned(world, routes, goal, Event("shut", "E4"), Event("shut", "E1")))


def test_doors_of_a_hidden_corridor_are_one_chord() -> None:
    assert chords(OFFICE) == (("E7", "E8"), ("E9", "E10"))
    assert set(rooms_to_visit(OFFICE, RADIUS, 1.0)) == set(CLOCKWISE) - {"ASR1"}


@pytest.mark.parametrize("pick", [0.0, 0.3, 0.6, 0.99])
@pytest.mark.parametrize("room", CLOCKWISE[:-1])
def test_a_block_shuts_a_door_of_the_known_way_and_leaves_a_way(room: str, pick: float) -> None:
    world, routes = routed(OFFICE)
    way = doors_on(world, routes.way(world.pose, PLACES[room]))
    events, closing = Block(pick, entered=True).arrange(world, routes, PLACES[room])
    shut = [event for event in events if event.kind == "shut"]
    assert [(e.name, e.room) for e in shut] in [[(c.door, c.room)] for c in way]
    assert {e.name for e in events if e.kind == "open"} <= {"E7", "E8", "E9", "E10"}
    assert closing == (Event("open", shut[0].name),)
    for event in events:
        event.fire(world)
    assert math.isfinite(routes.distance(world.pose, PLACES[room]))


def test_a_goal_that_is_cut_off_has_no_way_and_gets_its_doors_back() -> None:
    world, routes = routed(OFFICE)
    block = Block(0.5, entered=True, cut_off=True)
    events, closing = block.arrange(world, routes, PLACES["ASR4"])
    assert {e.name for e in events} == {"E3", "E4"} == {e.name for e in closing}
    assert block.arrange(world, routes, PLACES["ASR1"]) == ((), ())


def test_a_driver_makes_experiment_3_by_the_doors_of_the_thesis() -> None:
    driver = Driver(gym.make("CogMap/Thesis-v0", experiment=3), 0)

    def lap(rooms: tuple[str, ...]) -> list[str]:
        first, phase = len(driver.doors), len(driver.task.results)
        for room in rooms:
            driver.go(PLACES[room], lambda: len(driver.task.results) > phase)
        return driver.doors[first:]

    assert lap(CLOCKWISE) == ["E1", "E2", "E3", "E4", "E5", "E6"]
    assert driver.reach_goal() == []
    assert lap((*CLOCKWISE[-2::-1], "ASR1")) == ["E6", "E5", "E4", "E3", "E2", "E1"]
    for mark, room in ((2, "ASR5"), (3, "ASR3"), (4, "ASR2")):
        at = driver.task.marks[mark].position
        assert OFFICE.room_at(*at) == room
        assert point_segment_distances(at[None], OFFICE.door_segments()).min() >= 1.0
    assert driver.reach_goal() == ["E6", "E5"]
    assert driver.reach_goal() == ["E7", "E8"]
    assert driver.reach_goal() == ["E2", "E9", "E10", "E6"]
    assert driver.reach_goal() == ["E6", "E10", "E9"]
    assert driver.task.succeeded
    assert driver.env.world.shut_doors == {"E1"}
    assert not driver.env.world.present_barriers
    assert driver.events == [
        *("shut E6", "open E6", "shut E1", "open E1", "place B5", "open E7", "open E8"),
        *("remove B5", "open E9", "open E10", "shut E1"),
    ]
    goals = slice(1, 5)
    for key in ("spl", "spl_learning"):
        assert (driver.info[key][goals] > 0.98).all()
    assert (driver.info["learning_length"] >= driver.info["oracle_length"] - 0.01)[goals].all()


def test_the_way_to_e4_is_blocked_before_the_robot_can_come_near_it() -> None:
    driver = Driver(gym.make("CogMap/Thesis-v0", experiment=3), 0)
    for rooms in (CLOCKWISE, (*CLOCKWISE[-2::-1], "ASR1")):
        phase = len(driver.task.results)
        for room in rooms:
            driver.go(PLACES[room], lambda: len(driver.task.results) > phase)  # noqa: B023
        if driver.task.goal == 1:
            driver.reach_goal()
    driver.go(Pose(25.0, 1.1))
    driver.step(driver.env.robot.declare())
    assert driver.task.results[-1].success
    assert driver.env.world.present_barriers == {"B5"}
    assert driver.reach_goal() == ["E7", "E8"]


def explored(name: str, of: str, **keywords: Any) -> Driver:
    """A driver that has just explored."""
    driver = Driver(gym.make(name, map=of, **keywords), 0)
    driver.explore(rooms_to_visit(driver.env.plan, RADIUS, 1.0))
    return driver


MAPS = ("thesis_office", "office:1001", "office:1003", "office:1006")


@pytest.mark.parametrize("of", MAPS)
@pytest.mark.parametrize("name", ["CogMap/GoTo-v0", "CogMap/Shortcut-v0"])
def test_a_driver_reaches_every_mark_wherever_doors_shut_and_open(name: str, of: str) -> None:
    driver = explored(name, of)
    asked = []
    while not driver.over:
        asked.append(driver.task.goal)
        driver.reach_goal()
        assert driver.task.results[-1].success
    assert driver.info["is_success"]
    assert 3 <= len(asked) == len(set(asked)) <= 5
    assert (driver.info["oracle_length"][asked] > 0.3).all()
    assert (driver.info["learning_length"][asked] >= driver.info["oracle_length"][asked]).all()
    assert bool(driver.events) == (name == "CogMap/Shortcut-v0")


def test_in_the_thesis_office_every_goal_has_a_door_shut_on_its_way() -> None:
    driver = explored("CogMap/Shortcut-v0", "thesis_office")
    while not driver.over:
        events = driver.task.phase.events
        assert [event.kind for event in events].count("shut") == 1
        driver.reach_goal()
    assert {event for event in driver.events if event.startswith("open")} >= {
        *("open E7", "open E8", "open E9", "open E10")
    }


def test_no_route_is_the_right_answer_where_a_goal_was_cut_off() -> None:
    driver = explored("CogMap/Shortcut-v0", "thesis_office", unreachable=1.0)
    cut_off = []
    while not driver.over:
        goal, here = driver.task.goal, driver.env.world.pose
        if math.isinf(driver.routes.distance(here, driver.task.marks[goal])):
            cut_off.append(goal)
        else:
            assert OFFICE.room_at(here.x, here.y) == driver.task._mark_rooms[goal]
        driver.reach_goal()
        assert driver.task.results[-1].success
    assert len(cut_off) >= 2
    assert (driver.info["spl"][cut_off] == -1.0).all()
    assert (driver.info["learning_length"][cut_off] == -1.0).all()


def test_goals_are_drawn_by_the_seed_alone() -> None:
    drawn = set()
    for seed in range(5):
        env = gym.make("CogMap/Shortcut-v0", map="thesis_office").unwrapped
        env.reset(seed=seed)
        first = env.task._phases
        env.reset(seed=seed)
        assert env.task._phases == first
        drawn.add(first)
    assert len(drawn) == 5
