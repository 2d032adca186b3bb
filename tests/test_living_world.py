"""A living office: pushed boxes, doors on a schedule, people; the laser sees what bodies meet."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from shapely.geometry import Polygon

from cogmap_gym.boxes import Box, edges
from cogmap_gym.dynamics import LEVELS
from cogmap_gym.env import CogMapEnv
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.life import Life
from cogmap_gym.living_world import LivingWorld
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.people import KEEP_OFF_M, RADIUS_M, Person, Surroundings, outlines, walk
from cogmap_gym.raycast import RayCaster
from tests.test_env import digest, in_haste  # noqa: F401 - a fixture

BOTH = ["move", "velocity"]
LIVING = sorted(set(LEVELS) - {"off"})
HALL = {
    "name": "hall",
    "walls": [[[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]],
    "furniture": [],
    "doors": {},
    "closed": [],
    "barriers": {},
    "rooms": {"R1": [[0, 0], [10, 0], [10, 10], [0, 10]]},
    "home": [2, 5, 0],
}
SQUARE = 0.25 * np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))


def hall(*boxes: Pose, people: tuple[Person, ...] = (), level: str = "people") -> LivingWorld:
    world = LivingWorld(FloorPlan.load(HALL), RobotSpec(), LEVELS[level])
    world.begin(np.random.default_rng(5))
    world._set_life(Life(tuple(Box(SQUARE, pose) for pose in boxes), people, "", 20.0))
    world._show()
    return world


def made(level: str, control: str = "move", **keywords: Any) -> CogMapEnv:
    return CogMapEnv("explore", "office:1001", control=control, dynamics=level, **keywords)


def wander(env: CogMapEnv, count: int, seed: int = 0) -> list[tuple[Any, ...]]:
    """Drive on, and turn at contact."""
    rng, steps, bump = np.random.default_rng(seed), [], False
    for _ in range(count):
        turn = rng.uniform(0.3, 0.5) if bump else rng.uniform(-0.2, 0.2)
        if env.robot.control == "move":
            action = env.robot.move(turn, 0.0 if bump else rng.uniform(0.0, 2.0))
        else:
            action = env.robot.velocity(0.0 if bump else 0.7, 10.0 * turn)
        steps.append(env.step(action))
        bump = bool(steps[-1][0]["bump"])
    return steps


def test_a_box_is_pushed_ahead_of_the_robot() -> None:
    world = hall(Pose(4.0, 5.1, 0.3))
    motion = world.move(0.0, 3.0)
    assert not motion.bump
    assert motion.driven == pytest.approx(3.0, abs=0.2)
    (outline,) = world.box_outlines
    assert outline[:, 0].mean() > 4.6
    assert point_segment_distances(world.pose.position[None], edges([outline])).min() > 0.24
    assert Polygon(outline).area == pytest.approx(0.25)


def test_a_box_at_the_wall_stops_the_robot() -> None:
    world = hall(Pose(9.7, 5.0, 0.0))
    motions = [world.move(0.0, 3.0) for _ in range(4)]
    assert motions[-1].bump
    assert world.pose.x == pytest.approx(10.0 - 0.5 - 0.25, abs=0.02)
    (outline,) = world.box_outlines
    assert outline[:, 0].max() < 10.01


@pytest.mark.parametrize("seed", [1060, 1075, 1078])
def test_a_robot_that_keeps_on_pushing_squeezes_nothing(seed: int) -> None:
    """Into the corner, slanting: without a limit it came 5 cm into the box."""
    rng = np.random.default_rng(seed)
    (x, y), theta, ahead = rng.uniform(9.3, 9.65, 2), rng.uniform(-3.0, 3.0), rng.uniform(0.2, 1.3)
    world, deepest = hall(Pose(x, y, theta)), 0.0
    world.place(Pose(x - 0.9 * math.cos(ahead), y - 0.9 * math.sin(ahead), ahead))
    for turn in rng.choice((0.0, 0.0, 0.1, -0.1), 40).tolist():
        world.move(turn, 0.5)
        gaps = point_segment_distances(world.pose.position[None], edges(world.box_outlines))
        deepest = max(deepest, 0.25 - gaps.min(), world.box_outlines[0].max() - 10.0)
    assert 0.0 < deepest < 0.005


def test_somebody_whom_the_robot_touches_turns_no_corner_on_it() -> None:
    """An edge is nearer to the middle than a corner: 0.48 m is contact, or 2 cm too near."""
    robot, nothing = np.zeros((1, 2)), np.zeros((0, 2, 2))
    for towards, start in itertools.product(np.arange(0.0, math.tau, 0.1), np.arange(8) + 0.5):
        at = 0.483 * math.cos(start * math.tau / 8), 0.483 * math.sin(start * math.tau / 8)
        goal = at[0] + 3.0 * math.cos(towards), at[1] + 3.0 * math.sin(towards)
        person = Person(at, (goal,))
        for _ in range(5):
            about = Surroundings((0.0, 0.0), 0.25, np.array((person.at,)), nothing, nothing)
            person = walk(person, 0, 0.1, about, lambda start: ())
            assert point_segment_distances(robot, edges(outlines([person]))).min() > 0.249


def test_a_box_that_is_not_touched_stays_to_the_bit() -> None:
    world = hall(Pose(5.0, 8.0, 0.7))
    before = world._life.boxes
    for _ in range(5):
        world.move(0.3, 0.7)
    assert world._life.boxes[0] is before[0]


def test_a_person_is_no_box_and_ends_the_motion() -> None:
    """Somebody who waits: there is no way for them, for the robot is all about."""
    world = hall(people=(Person((4.0, 5.0)),))
    world._new_way = lambda start: ()  # type: ignore[method-assign]
    motion = world.move(0.0, 3.0)
    assert motion.bump
    assert world._life.people[0].at == (4.0, 5.0)
    gap = point_segment_distances(world.pose.position[None], edges(world.people_outlines)).min()
    assert gap == pytest.approx(0.25, abs=0.01)


def test_people_walk_straight_at_the_robot_and_stop_or_go_round() -> None:
    person = Person((8.0, 5.0), ((1.0, 5.0),))
    world = hall(people=(person,))
    nearest, off = math.inf, RADIUS_M + world.robot.radius
    for _ in range(40):
        world.move(0.0, 0.0)
        nearest = min(nearest, math.dist(world._life.people[0].at, (2.0, 5.0)))
    assert off + KEEP_OFF_M - 1e-9 <= nearest < off + KEEP_OFF_M + 0.2


@pytest.mark.parametrize(("level", "control"), list(zip(LIVING, BOTH * 2, strict=True)))
def test_nothing_is_inside_a_wall_and_nobody_runs_into_the_robot(level: str, control: str) -> None:
    env = made(level, control)
    env.reset(seed=1000)
    world, free = env.world, env.plan.free_space().buffer(0.02)
    for _ in range(3):
        before = world.pose
        for *_, info in wander(env, 10):
            assert np.isfinite(info["pose"]).all()
        here = world.pose.position[None]
        assert point_segment_distances(here, world.solid_segments).min() > 0.24
        assert before != world.pose
        if len(world.caster.moving):
            assert point_segment_distances(here, world.caster.moving).min() > 0.24
        assert all(free.contains(Polygon(outline)) for outline in world.box_outlines)
    kinds = bool(world.box_outlines), bool(world.people_outlines)
    assert kinds == (level in ("furniture", "busy"), level in ("people", "busy"))


@pytest.mark.parametrize("mount", [0.0, 2.5])
@pytest.mark.parametrize("beams", [360, 719])
def test_the_laser_sees_exactly_what_the_body_meets(beams: int, mount: float) -> None:
    env = made("busy")
    laser = LaserSpec(-math.pi / 2, math.radians(0.5), beams, mount=(0.0, 0.0, mount))
    env.reset(seed=1001)
    rng, world = np.random.default_rng(2), env.world
    assert isinstance(world, LivingWorld)
    everything = np.concatenate((world.solid_segments, world.caster.moving))
    seen = 0
    for x, y in world._spots.points[rng.permutation(len(world._spots.points))[:40]].tolist():
        pose = Pose(x, y, rng.uniform(-3.0, 3.0)) @ laser.robot_from_laser
        ranges = world.caster.ranges(pose, laser)
        assert ranges == pytest.approx(RayCaster(everything).ranges(pose, laser), abs=1e-9)
        seen += int((ranges < RayCaster(world.solid_segments).ranges(pose, laser) - 0.01).sum())
    assert seen > 100


@pytest.mark.parametrize("level", ["busy"])
def test_the_same_seed_gives_the_same_bits_and_resets_differ(level: str) -> None:
    env, twin = made(level), made(level)
    runs = []
    for one in (env, twin):
        first = digest(one.reset(seed=1002))
        runs.append([first, *(digest(step) for step in wander(one, 10)), digest(one.reset())])
    assert runs[0] == runs[1]
    assert runs[0][0] != runs[0][-1]


def test_the_same_seed_gives_the_same_bits_in_another_process() -> None:
    script = (
        "from tests.test_living_world import *\n"
        "env = made('busy'); env.reset(seed=1004)\n"
        "print([digest(step) for step in wander(env, 12)])\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=Path(__file__).resolve().parents[1],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    env = made("busy")
    env.reset(seed=1004)
    assert run.stdout.strip() == str([digest(step) for step in wander(env, 12)])


@pytest.mark.parametrize("level", ["busy"])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda e: pickle.loads(pickle.dumps(e))])
def test_a_copy_goes_on_with_the_same_bits(copied: Any, level: str) -> None:
    env = made(level)
    env.reset(seed=1003)
    wander(env, 10)
    twin = copied(env)
    assert list(map(digest, wander(env, 10, 1))) == list(map(digest, wander(twin, 10, 1)))


@pytest.mark.parametrize("level", ["busy"])
def test_a_state_that_is_restored_goes_on_with_the_same_bits(level: str) -> None:
    env = made(level)
    env.reset(seed=1003)
    wander(env, 10)
    world, state = env.world, env.world.state()
    moves = list(itertools.product((0.3, -0.2, 0.1), (0.0, 1.0, 2.5)))
    runs = []
    for _ in range(2):
        world.set_state(state)
        motions = [world.move(turn, forward) for turn, forward in moves]
        runs.append(([m.path.tobytes() for m in motions], repr(world.caster.moving.tobytes())))
    assert runs[0] == runs[1]


def test_doors_shut_one_at_a_time_and_cut_nothing_off() -> None:
    env = CogMapEnv("explore", "thesis_office", dynamics="doors")
    env.reset(seed=1000)
    world, closed, history = env.world, set(env.plan.closed), []
    for _ in range(300):
        world.move(0.5, 0.0)
        extra = world.shut_doors - closed
        assert len(extra) <= 1
        history.append("".join(extra))
    assert len(set(history)) > 2
    assert "" in history


def test_checkers_find_no_fault() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for control in BOTH:
            check_env(
                gym.make(
                    "CogMap/GoTo-v0", map="two_rooms", control=control, dynamics="busy"
                ).unwrapped
            )


@pytest.mark.parametrize("mode", ["human", "rgb_array"])
def test_what_moves_is_drawn(mode: str) -> None:
    env = made("busy", render_mode=mode)
    env.reset(seed=1000)
    scene = env.scene()
    assert len(scene.boxes) > 3
    assert len(scene.people) > 1
    env.render()
    env.close()


def test_a_level_that_would_spoil_a_task_or_is_unknown_is_refused() -> None:
    with pytest.raises(ValueError, match="dynamics: expected one of"):
        CogMapEnv("explore", "two_rooms", dynamics="wild")
    with pytest.raises(ValueError, match="shuts doors itself"):
        CogMapEnv("thesis", "thesis_office", experiment=1, dynamics="busy")
    assert CogMapEnv("thesis", "thesis_office", experiment=1, dynamics="people").reset(seed=1000)
