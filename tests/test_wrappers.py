"""What a robot is told through the wrappers, and that all of them rebuild from the spec."""

from __future__ import annotations

import itertools
import math
import pickle
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from cogmap_gym.env import CogMapEnv
from cogmap_gym.geometry import Pose
from cogmap_gym.wrappers import (
    DiscreteControl,
    EgocentricGrid,
    GoalVector,
    MoveControl,
    ScanSectors,
    StackedScans,
    TruePose,
)
from tests.test_env import digest, in_haste  # noqa: F401 - a fixture

HALL = {
    "name": "hall",
    "walls": [[[0, 0], [60, 0], [60, 60], [0, 60], [0, 0]]],
    "furniture": [],
    "doors": {},
    "closed": [],
    "barriers": {},
    "rooms": {"R1": [[0, 0], [60, 0], [60, 60], [0, 60]]},
    "home": [30, 30, 0],
}
Wrap = Callable[[gym.Env[Any, Any]], gym.Env[Any, Any]]


def everything(env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    env = EgocentricGrid(GoalVector(DiscreteControl(env)), 40)
    return StackedScans(ScanSectors(env, 30), 3)


WRAPPED: dict[str, tuple[str, Wrap]] = {
    "sectors": ("move", lambda env: ScanSectors(env, 25)),
    "stacked": ("velocity", lambda env: StackedScans(env, 3)),
    "goal": ("move", GoalVector),
    "grid": ("velocity", lambda env: EgocentricGrid(env, 36, 0.25)),
    "true pose": ("move", TruePose),
    "moves": ("velocity", MoveControl),
    "numbers": ("move", lambda env: DiscreteControl(env, turn=0.5)),
    "all over moves": ("move", everything),
    "all over velocity": ("velocity", lambda env: everything(MoveControl(env))),
}
EACH = pytest.mark.parametrize(("control", "wrap"), WRAPPED.values(), ids=WRAPPED)


def made(control: str, wrap: Wrap, name: str = "CogMap/GoTo-v0") -> gym.Env[Any, Any]:
    return wrap(gym.make(name, map="two_rooms", control=control))


def walk(env: gym.Env[Any, Any], count: int = 12) -> list[str]:
    env.action_space.seed(4)
    steps = [digest(env.reset(seed=1003))]
    steps += [digest(env.step(env.action_space.sample())) for _ in range(count)]
    return [*steps, digest(env.reset(seed=1003))]


@EACH
def test_the_spec_rebuilds_the_wrappers_from_json_and_the_same_bits(
    control: str, wrap: Wrap
) -> None:
    env = made(control, wrap)
    twin = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert str(twin) == str(env)
    assert twin.observation_space == env.observation_space
    assert twin.action_space == env.action_space
    assert walk(gym.make(env.spec)) == walk(twin) == walk(env)


@EACH
def test_an_episode_begins_anew_and_a_wrapped_world_can_be_pickled(
    control: str, wrap: Wrap
) -> None:
    env = made(control, wrap)
    steps = walk(env)
    assert steps[0] == steps[-1]
    twin = pickle.loads(pickle.dumps(env))
    action = env.action_space.sample()
    assert digest(env.step(action)) == digest(twin.step(action))


@EACH
def test_what_was_handed_out_stays_as_it_was(control: str, wrap: Wrap) -> None:
    env = made(control, wrap)
    kept = [env.reset(seed=1000)[0]]
    texts = [digest((kept[0],))]
    for _ in range(5):
        kept.append(env.step(env.action_space.sample())[0])
        texts.append(digest((kept[-1],)))
    assert [digest((observation,)) for observation in kept] == texts


def test_a_sector_tells_its_nearest_return() -> None:
    bare, env = (made("move", wrap) for wrap in (lambda env: env, lambda env: ScanSectors(env, 7)))
    scan, sectors = (e.reset(seed=1000)[0]["scan"] for e in (bare, env))
    edges = [k * 360 // 7 for k in range(8)]
    expected = [scan[a:b].min() for a, b in itertools.pairwise(edges)]
    assert sectors.tolist() == expected
    for wrong in (0, 361, 2.0, True):
        with pytest.raises(ValueError, match="sectors: expected an int"):
            ScanSectors(bare, wrong)


def test_scans_are_stacked_with_the_newest_last_and_the_first_repeated() -> None:
    bare, env = (made("move", wrap) for wrap in (lambda env: env, lambda env: StackedScans(env, 3)))
    action = bare.unwrapped.robot.move(0.4, 0.3)
    scans = [bare.reset(seed=1000)[0]["scan"], *(bare.step(action)[0]["scan"] for _ in range(3))]
    stacks = [env.reset(seed=1000)[0]["scan"], *(env.step(action)[0]["scan"] for _ in range(3))]
    for stack, rows in zip(stacks, ([0, 0, 0], [0, 0, 1], [0, 1, 2], [1, 2, 3]), strict=True):
        assert (stack == np.concatenate([scans[row] for row in rows])).all()
    with pytest.raises(ValueError, match="count: expected an int"):
        StackedScans(bare, 0)


@pytest.mark.parametrize(("odometry", "off"), [("perfect", 0.01), ("severe", 5.0)])
def test_the_goal_vector_is_true_up_to_the_drift_of_the_odometry(odometry: str, off: float) -> None:
    env = GoalVector(CogMapEnv("home", HALL, odometry=odometry))
    observation, _ = env.reset(seed=1000)
    assert (observation["goal_vector"] == 0.0).all()
    rng, errors = np.random.default_rng(1), []
    for _ in range(50):
        action = env.unwrapped.robot.move(rng.uniform(-0.5, 0.5), rng.uniform(0.0, 1.0))
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
        if observation["goal"] == 1:
            here = Pose(*info["pose"].tolist())
            truth = here.inverse().apply(env.unwrapped.plan.home.position)
            errors.append(np.abs(observation["goal_vector"] - truth).max())
    assert len(errors) > 5
    assert max(errors) < off
    assert (max(errors) > 0.05) == (odometry == "severe")


def standing(options: dict[str, Any], size: float = 0.1) -> tuple[Any, np.ndarray]:
    env = EgocentricGrid(CogMapEnv("explore", "two_rooms", odometry="perfect"), 80, size)
    observation, _ = env.reset(seed=1000, options=options)
    return env, observation["grid"][0]


def test_the_grid_shows_walls_ahead_above_and_on_the_left_at_the_left() -> None:
    """Home at (1, 2.5) in a room of 4 x 5 m, looking along x: the door leaves a gap ahead."""
    _, grid = standing({"home": [1.0, 2.0, 0.0]})
    assert grid[39, 40] == grid[20, 40] == 255
    assert 0 in grid[8:12, 45]  # the wall at x = 4, 3 m ahead, half a metre right
    assert 0 in grid[39, 58:62]  # the wall at y = 0, 2 m to the right
    assert (grid[60:] == 127).all()  # nothing was seen behind


def test_the_grid_remembers_what_it_saw_and_turns_with_the_robot() -> None:
    env, before = standing({"home": [1.0, 2.0, 0.0]})
    for _ in range(3):
        observation = env.step(env.unwrapped.robot.move(math.pi / 6, 0.0))[0]
    after = observation["grid"][0]
    clear = (before == 255) & (np.rot90(after) != 127)
    assert clear.sum() > 500
    assert (np.rot90(after)[clear] == 255).mean() > 0.95


def test_the_grid_forgets_what_lies_far_away_and_never_fails() -> None:
    env = EgocentricGrid(CogMapEnv("explore", "thesis_office"), 36, 0.1)
    env.reset(seed=1000)
    for _ in range(40):
        observation = env.step(env.unwrapped.robot.move(0.1, 1.5))[0]
        assert env.observation_space.contains(observation)
    assert observation["grid"][0, 17, 18] == 255


def test_a_grid_wants_all_beams_and_sensible_cells() -> None:
    env = CogMapEnv("explore", "two_rooms")
    with pytest.raises(ValueError, match="360 beams"):
        EgocentricGrid(ScanSectors(env))
    for keywords in ({"cells": 1}, {"cells": 2.5}, {"cell_size": 0.0}, {"cell_size": math.inf}):
        with pytest.raises(ValueError, match=f"EgocentricGrid: {next(iter(keywords))}"):
            EgocentricGrid(env, **keywords)
