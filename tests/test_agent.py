"""The thesis robot as a whole: protocol, laws, garbage, and what it cannot do without."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401  registers the environments
from agents.base import Agent
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.params import Frame, Params
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec
from tests.rooms import l_room
from tests.simulated import SYMMETRIC, scan, solid

KEYS = {
    *("surfaces", "exits", "asrs", "links", "here"),
    *("pose", "home", "marks", "route", "status"),
}
BLIND = replace(Params(), frame=Frame(kind="odometry"))
GARBAGE = [math.nan, 0.0, -1.0, math.inf, -math.inf, 32.0, 1e6]
ROOM = solid(l_room())
Change = Callable[[Observation], Observation]


def observation(
    ranges: NDArray[Any], odometry: tuple[float, ...] = (0.0, 0.0, 0.0), **keys: int
) -> Observation:
    return {
        "scan": np.asarray(ranges, dtype=np.float32),
        "odometry": np.array(odometry, dtype=np.float32),
        "bump": 0,
        "mark": 0,
        "goal": 0,
        **keys,
    }


def newborn(laser: LaserSpec = SYMMETRIC, params: Params | None = None) -> CogMapAgent:
    agent = CogMapAgent(params)
    agent.reset(RobotSpec(), laser)
    return agent


def played(agent: CogMapAgent, steps: int, seed: int = 0, map_name: str = "two_rooms") -> list[Any]:
    """Actions of an agent in the environment."""
    env = gym.make("CogMap/Explore-v0", map=map_name)
    seen, _ = env.reset(seed=seed)
    agent.reset(env.unwrapped.robot, env.unwrapped.laser)  # type: ignore[attr-defined]
    actions = []
    for _ in range(steps):
        actions.append(agent.act(copy.deepcopy(seen)))
        seen, _, terminated, truncated, _ = env.step(actions[-1])
        if terminated or truncated:
            break
    env.close()
    return actions


def sound(action: NDArray[np.float32]) -> bool:
    return bool(action.dtype == np.float32 and RobotSpec().action_space.contains(action))


def test_it_follows_the_agent_protocol() -> None:
    assert isinstance(CogMapAgent(), Agent)


def test_before_and_after_reset_its_sketch_is_that_of_a_newborn() -> None:
    agent = CogMapAgent()
    newly = agent.sketch()
    assert set(newly) == KEYS
    assert newly["surfaces"] == newly["exits"] == newly["asrs"] == newly["links"] == []
    assert newly["home"] is None
    played(agent, 5)
    agent.reset(RobotSpec(), LaserSpec())
    assert agent.sketch() == newly
    assert agent.edit_log == ()


def test_its_sketch_is_plain_json_with_one_id_a_thing() -> None:
    agent = CogMapAgent()
    played(agent, 60)
    sketch = agent.sketch()
    assert set(sketch) == KEYS
    assert json.loads(json.dumps(sketch, allow_nan=False)) == sketch
    for things in ("surfaces", "exits", "asrs", "marks"):
        ids = [thing["id"] for thing in sketch[things]]
        assert len(ids) == len(set(ids))
    exits = {e["id"] for e in sketch["exits"]}
    assert all(set(a["exits"]) <= exits for a in sketch["asrs"])
    assert all(number in exits for _, number, _ in sketch["links"])
    assert len(sketch["surfaces"]) >= 5
    assert sketch["home"] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_its_life_is_the_same_every_time() -> None:
    agent = CogMapAgent()
    first, sketch = played(agent, 40), agent.sketch()
    again = played(agent, 40)
    assert [a.tolist() for a in first] == [a.tolist() for a in again]
    assert agent.sketch() == sketch
    assert [a.tolist() for a in played(CogMapAgent(), 40)] == [a.tolist() for a in first]


def test_two_robots_share_no_memory() -> None:
    alone = newborn()
    for step in range(6):
        alone.act(observation(scan(ROOM, Pose(1.5, 1.5, 0.2 * step)), (0.0, 0.0, 0.2)))
    one, other = newborn(), newborn()
    for step in range(6):
        one.act(observation(scan(ROOM, Pose(1.5, 1.5, 0.2 * step)), (0.0, 0.0, 0.2)))
        other.act(observation(scan(ROOM, Pose(6.0, 2.0, 3.0)), (0.3, 0.0, -0.1)))
    assert one.sketch() == alone.sketch()
    assert other.sketch() != alone.sketch()
    assert len(one.edit_log) == len(alone.edit_log)


def test_it_does_not_write_into_its_observations() -> None:
    agent, seen = newborn(), observation(scan(ROOM, Pose(1.5, 1.5, 0.2)), mark=1)
    before = copy.deepcopy(seen)
    agent.act(seen)
    assert all(np.array_equal(seen[key], before[key]) for key in before)
    action = agent.act(seen)
    action[:] = 7.0
    assert sound(agent.act(seen))


def test_it_remembers_the_last_spot_of_each_mark() -> None:
    agent, ranges = newborn(), scan(ROOM, Pose(1.5, 1.5, 0.2))
    agent.act(observation(ranges, mark=1))
    agent.act(observation(scan(ROOM, Pose(1.8, 1.5, 0.2)), (0.3, 0.0, 0.0), mark=2))
    marks = {mark["id"]: mark["point"] for mark in agent.sketch()["marks"]}
    assert marks[1] == pytest.approx([0.0, 0.0])
    assert marks[2] == pytest.approx([0.3, 0.0], abs=0.1)
    agent.act(observation(ranges, (-0.3, 0.0, 0.0), mark=2))
    again = {mark["id"]: mark["point"] for mark in agent.sketch()["marks"]}
    assert again[2] == pytest.approx([0.0, 0.0], abs=0.1), "a life after the first gives them anew"


def test_at_home_it_declares_when_told_to_go_home() -> None:
    agent, ranges = newborn(), scan(ROOM, Pose(1.5, 1.5, 0.2))
    agent.act(observation(ranges, mark=1))
    assert agent.act(observation(ranges, goal=1))[2] > 0.5
    assert agent.act(observation(ranges, goal=0))[2] <= 0.5


@pytest.mark.parametrize("params", [Params(), BLIND], ids=["default", "odometry"])
@pytest.mark.parametrize("value", GARBAGE, ids=str)
def test_scans_without_evidence_neither_crash_it_nor_invent_surfaces(
    value: float, params: Params
) -> None:
    agent = newborn(params=params)
    for goal in (0, 0, 1, 1, 2):
        assert sound(agent.act(observation(np.full(361, value), (0.1, 0.0, 0.05), goal=goal)))
    assert agent.sketch()["surfaces"] == []
    assert agent.edit_log == ()


@pytest.mark.parametrize("value", GARBAGE, ids=str)
def test_scans_without_evidence_in_the_middle_of_its_life_do_no_harm(value: float) -> None:
    agent = newborn()
    for step in range(4):
        ranges = scan(ROOM, Pose(1.5, 1.5, 0.2 * step))
        agent.act(observation(ranges, (0.0, 0.0, 0.2 * (step > 0)), mark=1))
    before = agent.sketch()["surfaces"]
    for goal in (0, 1, 0):
        assert sound(agent.act(observation(np.full(361, value), goal=goal)))
    assert agent.sketch()["surfaces"] == before
    agent.act(observation(scan(ROOM, Pose(1.5, 1.5, 0.6))))
    assert agent.sketch()["pose"] == pytest.approx([0.0, 0.0, 0.6], abs=0.05)


@pytest.mark.parametrize("beams", [1, 2, 3, 5])
def test_a_laser_of_few_beams_does_not_crash_it(beams: int) -> None:
    agent = newborn(LaserSpec(first_angle=0.0, beams=beams))
    for value in (2.0, math.nan, 32.0, 0.0, 1.0):
        assert sound(agent.act(observation(np.full(beams, value), (0.2, 0.0, 0.1), mark=1)))
    assert agent.sketch()["surfaces"] == []


def test_one_beam_of_many_invents_no_surface() -> None:
    agent, ranges = newborn(), np.full(361, 32.0)
    ranges[180] = 2.0
    for _ in range(3):
        assert sound(agent.act(observation(ranges)))
    assert agent.sketch()["surfaces"] == []


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_readings_do_not_crash_it(seed: int) -> None:
    rng, agent = np.random.default_rng(seed), newborn()
    for step in range(8):
        ranges = rng.uniform(0.0, rng.choice([1.0, 6.0, 40.0]), 361)
        ranges[rng.random(361) < 0.2] = rng.choice([np.nan, np.inf, -np.inf, 0.0, -1.0, 32.0])
        move = tuple(rng.normal(0.0, (1.0, 0.3, 0.5)))
        seen = observation(ranges, move, mark=int(step == 0), goal=int(rng.integers(0, 3)))
        assert sound(agent.act(seen))
    json.dumps(agent.sketch(), allow_nan=False)


@dataclass(frozen=True)
class Lap:
    """The first lap of experiment 1, and some views into the second."""

    done: bool
    """Whether the lap was completed."""
    closed: bool
    """Whether the robot then knew itself in the place where it began."""
    pose_error: float
    """Distance between where it believed to be and where it was at the end [m]."""
    off_walls: float
    """Share of the ends of its surfaces farther than 0.5 m from any wall."""


def lap(params: Params, seed: int, level: str, change: Change = lambda seen: seen) -> Lap:
    env = gym.make("CogMap/Thesis-v0", experiment=1, odometry=level)
    seen, info = env.reset(seed=seed)
    home, agent = Pose(*info["pose"]), CogMapAgent(params)
    plan = env.unwrapped.plan  # type: ignore[attr-defined]
    agent.reset(env.unwrapped.robot, env.unwrapped.laser)  # type: ignore[attr-defined]
    first, after, moves, closed = info["phase"], 0, 0, False
    while after < 12 and moves < 260:
        seen, _, terminated, truncated, info = env.step(agent.act(change(copy.deepcopy(seen))))
        moves, after = moves + 1, after + (info["phase"] != first)
        closed |= after > 0 and agent.memory.stay.place == 1
        if terminated or truncated:
            break
    agent.act(change(copy.deepcopy(seen)))  # it has yet to see where the last move led
    believed, true = home @ agent.memory.pose, Pose(*info["pose"])
    walls = np.concatenate((plan.walls_and_furniture(), plan.door_segments()))
    ends = home.apply(agent.memory.mapping.mfis.surfaces).reshape(-1, 2)
    off = point_segment_distances(ends, walls).min(axis=1)
    env.close()
    return Lap(after > 0, closed, believed.distance(true), float(np.mean(off > 0.5)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1000, 1001])
def test_the_loop_closes_with_landmarks_and_does_not_without(seed: int) -> None:
    seeing, blind = lap(Params(), seed, "high"), lap(BLIND, seed, "high")
    assert seeing.done
    assert seeing.closed
    assert seeing.pose_error < 1.0
    assert not blind.closed
    assert blind.pose_error > 5 * seeing.pose_error


@pytest.mark.slow
def test_scrambled_odometry_ruins_the_map() -> None:
    rng = np.random.default_rng(5)

    def scrambled(seen: Observation) -> Observation:
        reading = rng.normal(0.0, (1.5, 0.1, 0.5)).astype(np.float32)
        return {**seen, "odometry": reading}

    good, ruined = lap(Params(), 1000, "medium"), lap(Params(), 1000, "medium", scrambled)
    assert good.off_walls < 0.1
    assert ruined.off_walls > 0.4
    assert ruined.pose_error > 10 * good.pose_error
    assert not ruined.closed
