"""Moves by velocity steps, and actions by number."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import cogmap_gym
from agents.cogmap import CogMapAgent
from agents.rollout import run_episode
from cogmap_gym.env import STEPS_A_MOVE, CogMapEnv
from cogmap_gym.geometry import Pose
from cogmap_gym.wrappers import DiscreteControl, MoveControl
from tests.test_env import in_haste, walk  # noqa: F401 - a fixture

ROOM = {
    "name": "room",
    "walls": [[[0, 0], [20, 0], [20, 20], [0, 20], [0, 0]]],
    "furniture": [],
    "doors": {},
    "closed": [],
    "barriers": {},
    "rooms": {"R1": [[0, 0], [20, 0], [20, 20], [0, 20]]},
    "home": [10, 10, 0],
}


def moving(name: str = "CogMap/Explore-v0", **keywords: Any) -> gym.Env[Any, Any]:
    return MoveControl(gym.make(name, **{"map": ROOM, "control": "velocity", **keywords}))


def pose_of(reading: np.ndarray) -> Pose:
    return Pose(*map(float, reading))


@pytest.mark.parametrize("odometry", ["perfect", "medium", "severe"])
@pytest.mark.parametrize(("degrees", "metres"), [(30, 3.0), (-20, 0.7), (5, 0.0), (0, 1.0), (0, 0)])
def test_a_move_ends_where_the_measured_odometry_says_it_is_done(
    odometry: str, degrees: float, metres: float
) -> None:
    env = moving(odometry=odometry)
    robot = env.get_wrapper_attr("robot")
    env.reset(seed=1000)
    observation, *_ = env.step(robot.move(math.radians(degrees), metres))
    told = pose_of(observation["odometry"])
    turn = math.radians(degrees)
    rough = 0.0 if odometry == "perfect" else 1.0
    assert math.hypot(told.x, told.y) == pytest.approx(metres, abs=0.015 + 0.05 * rough)
    assert told.theta == pytest.approx(turn, abs=math.radians(0.6 + 1.5 * rough))
    assert env.observation_space.contains(observation)


def test_perfect_odometry_of_a_move_is_the_true_motion() -> None:
    env = moving(odometry="perfect")
    _, info = env.reset(seed=1000)
    rng = np.random.default_rng(3)
    for _ in range(15):
        before = pose_of(info["pose"])
        observation, _, _, _, info = env.step(rng.uniform(-1.0, 0.2, 3).astype(np.float32))
        moved = before.inverse() @ pose_of(info["pose"])
        if not observation["bump"]:
            told = pose_of(observation["odometry"])
            assert moved.distance(told) < 1e-4
            assert moved.theta == pytest.approx(told.theta, abs=1e-5)


def test_contact_ends_a_move_early() -> None:
    env = moving(odometry="perfect")
    env.reset(seed=1000, options={"home": [1.0, 10.0, 180.0]})
    observation, *_ = env.step(env.get_wrapper_attr("robot").move(0.0, 3.0))
    assert observation["bump"] == 1
    assert observation["odometry"][0] == pytest.approx(0.75, abs=0.02)


def test_a_mark_and_a_new_goal_end_a_move_where_they_are_given() -> None:
    """Nothing that a step of the velocity environment told is lost between two moves."""
    env = MoveControl(gym.make("CogMap/GoTo-v0", map="two_rooms", control="velocity"))
    robot, told = env.get_wrapper_attr("robot"), []
    inner, step = env.unwrapped, env.unwrapped.step

    def listen(action: Any) -> Any:
        outcome = step(action)
        told.append((int(outcome[0]["mark"]), int(outcome[0]["goal"])))
        return outcome

    inner.step = listen  # type: ignore[method-assign]
    observation, _ = env.reset(seed=1000)
    heard, goals = [], [int(observation["goal"])]
    for action in [robot.move(0.0, 3.0)] * 2 + [robot.move(0.4, 0.3)] * 60:
        told.clear()
        observation, _, terminated, truncated, _ = env.step(action)
        assert all(mark == 0 for mark, _ in told[:-1])
        assert all(goal == goals[-1] for _, goal in told[:-1])
        heard += [int(observation["mark"])] * bool(observation["mark"])
        goals.append(int(observation["goal"]))
        if observation["mark"]:
            mark = inner.task.marks[int(observation["mark"])]
            assert mark.distance(inner.world.pose) == 0.0
        if terminated or truncated:
            break
    assert heard


def test_rewards_are_summed_and_the_end_of_the_episode_ends_the_move() -> None:
    env = moving(max_moves=20)
    _, before = env.reset(seed=1000)
    robot = env.get_wrapper_attr("robot")
    _, reward, terminated, truncated, after = env.step(robot.move(0.0, 0.35))
    assert (terminated, truncated) == (False, False)
    seen, steps = after["coverage"] - before["coverage"], env.unwrapped._moves
    assert 5 <= steps <= 8
    assert reward == pytest.approx(seen - 0.01 * steps)
    *_, terminated, truncated, _ = env.step(robot.move(0.0, 3.0))
    assert (terminated, truncated) == (False, True)


def test_a_declaration_is_one_step() -> None:
    env = moving("CogMap/GoHome-v0", map="two_rooms")
    env.reset(seed=1000)
    before = env.unwrapped.world.pose
    observation, reward, *_ = env.step(env.get_wrapper_attr("robot").declare())
    assert env.unwrapped.world.pose == before
    assert (observation["odometry"] == 0.0).all()
    assert reward == pytest.approx(-0.01, abs=0.05)


def test_a_robot_that_makes_moves_comes_home_in_a_velocity_environment() -> None:
    env = MoveControl(gym.make("CogMap/GoHome-v0", map="office:1000", control="velocity"))
    episode = run_episode(env, CogMapAgent(), 1000)
    assert [phase["task"] for phase in episode.phases] == ["explore", "home"]
    assert episode.is_success


@pytest.mark.parametrize("name", cogmap_gym.ENV_IDS)
def test_every_task_keeps_the_laws_under_velocity_control(name: str) -> None:
    env, twin = (gym.make(name, map="thesis_office", control="velocity") for _ in range(2))
    assert walk(env, 1000) == walk(twin, 1000)


@pytest.mark.parametrize("name", cogmap_gym.ENV_IDS)
def test_budgets_count_velocity_steps_by_the_move(name: str) -> None:
    by_move, by_velocity = (
        gym.make(name, map="thesis_office", control=control) for control in ("move", "velocity")
    )
    assert by_velocity.unwrapped.max_moves == STEPS_A_MOVE * by_move.unwrapped.max_moves


def test_the_wrong_control_is_refused_in_words() -> None:
    with pytest.raises(ValueError, match="MoveControl: expected control 'velocity'"):
        MoveControl(CogMapEnv(map="two_rooms"))
    with pytest.raises(ValueError, match="put MoveControl beneath it"):
        DiscreteControl(CogMapEnv(map="two_rooms", control="velocity"))
    for keywords in ({"turn": 1.0}, {"forward": 0.0}, {"turn": math.nan}):
        with pytest.raises(ValueError, match=f"DiscreteControl: {next(iter(keywords))}"):
            DiscreteControl(CogMapEnv(map="two_rooms"), **keywords)


@pytest.mark.parametrize("control", ["move", "velocity"])
def test_four_numbers_turn_drive_and_declare_under_both_controls(control: str) -> None:
    env = gym.make("CogMap/GoHome-v0", map=ROOM, control=control, odometry="perfect")
    env = DiscreteControl(MoveControl(env) if control == "velocity" else env)
    env.reset(seed=1000)
    env.step(0)  # all is seen, and the goal changes
    readings = [env.step(action)[0]["odometry"] for action in (0, 1, 2, np.int64(3))]
    assert [float(r[2]) for r in readings[:2]] == pytest.approx([math.pi / 12, -math.pi / 12])
    assert readings[2][0] == pytest.approx(0.5, abs=0.011)
    assert (readings[3] == 0.0).all()
    with pytest.raises(ValueError, match="expected 0, 1, 2 or 3"):
        env.step(4)
