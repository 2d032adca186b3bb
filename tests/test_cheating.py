"""No robot can cheat: while one acts, the world, the environment and info raise on every access.

The guard is on the classes, so that it does not matter how a robot came by an object: through the
stack, through the garbage collector, or because somebody gave it the environment.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401 - registers the environments
from agents.base import Agent
from agents.registry import AGENTS, is_available, make_agent, wrap
from agents.rollout import Episode, run_episode
from cogmap_gym.coverage import Coverage
from cogmap_gym.env import CogMapEnv
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec
from cogmap_gym.routes import Routes
from cogmap_gym.tasks import Task
from cogmap_gym.world import World

TRUTH = (CogMapEnv, World, Task, Coverage, Routes, FloorPlan, gym.Wrapper)
MOVES = 30
NAMES = [
    pytest.param(name, marks=pytest.mark.skipif(not is_available(name), reason="extra missing"))
    for name in AGENTS
]


class CheatError(Exception):
    """A robot laid hands on the truth."""


class Guard:
    """Whether a robot acts now."""

    robot_acts = False

    def check(self, what: str) -> None:
        if self.robot_acts:
            raise CheatError(what)


class PoisonedInfo(dict[str, Any]):
    """``info`` that raises on every access while a robot acts."""

    guard: Guard

    def __getattribute__(self, name: str) -> Any:
        type.__getattribute__(PoisonedInfo, "guard").check(f"info.{name}")
        return super().__getattribute__(name)

    def __getitem__(self, key: str) -> Any:
        self.guard.check(f"info[{key!r}]")
        return super().__getitem__(key)

    def __iter__(self) -> Iterator[str]:
        self.guard.check("iter(info)")
        return super().__iter__()


class Poisoned(gym.Wrapper[Any, Any, Any, Any]):
    """An environment whose ``info`` is poisoned."""

    def reset(self, **keywords: Any) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(**keywords)
        return observation, PoisonedInfo(info)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        *told, info = self.env.step(action)
        return (*told, PoisonedInfo(info))  # type: ignore[return-value]


class Guarded:
    """A robot under guard."""

    def __init__(self, agent: Agent, guard: Guard) -> None:
        self.agent, self.guard = agent, guard
        self.actions: list[NDArray[np.float32]] = []

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        self._guarded(self.agent.reset, robot, laser)

    def act(self, observation: Observation) -> NDArray[np.float32]:
        self.actions.append(self._guarded(self.agent.act, observation))
        return self.actions[-1]

    def sketch(self) -> Any:
        return self._guarded(self.agent.sketch)

    def _guarded(self, method: Any, *arguments: Any) -> Any:
        self.guard.robot_acts = True
        try:
            return method(*arguments)
        finally:
            self.guard.robot_acts = False


@pytest.fixture
def guard(monkeypatch: pytest.MonkeyPatch) -> Guard:
    """Puts a guard on every class that knows the truth."""
    guard = Guard()
    monkeypatch.setattr(PoisonedInfo, "guard", guard, raising=False)
    for kind in TRUTH:
        monkeypatch.setattr(kind, "__getattribute__", watched(kind, guard))
    return guard


def watched(kind: type, guard: Guard) -> Any:
    honest = kind.__getattribute__

    def look(self: Any, name: str) -> Any:
        guard.check(f"{kind.__name__}.{name}")
        return honest(self, name)

    return look


def made(name: str) -> gym.Env[Any, Any]:
    return wrap(name, gym.make("CogMap/GoHome-v0", map="two_rooms", max_moves=MOVES))


def played(env: gym.Env[Any, Any], agent: Agent, guard: Guard) -> tuple[Episode, list[Any]]:
    held = Guarded(agent, guard)
    return run_episode(Poisoned(env), held, 3), held.actions


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_acts_the_same_without_reach_of_the_truth(name: str, guard: Guard) -> None:
    episode, actions = played(made(name), make_agent(name, 3), guard)
    free = Guarded(make_agent(name, 3), Guard())
    assert run_episode(made(name), free, 3).steps == episode.steps > 0
    assert np.array_equal(actions, free.actions)


class Cheat:
    """A robot that helps itself to the truth as it can; each way is a class of its own."""

    env: Any = None

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        self.robot = robot

    def act(self, observation: Observation) -> NDArray[np.float32]:
        self.look()
        return self.robot.move(0.3, 0.5)

    def sketch(self) -> None:
        return None

    def look(self) -> None:
        raise NotImplementedError


class Given(Cheat):
    """Somebody gave it the environment."""

    def look(self) -> None:
        self.env.unwrapped  # noqa: B018 - that is the crime


class Hunter(Cheat):
    """It finds the world among all objects of the process."""

    def look(self) -> None:
        for thing in gc.get_objects():
            if type(thing) is World:
                thing.pose  # noqa: B018


class Searcher(Cheat):
    """It finds the environment among all objects, and asks for its task."""

    def look(self) -> None:
        for thing in gc.get_objects():
            if type(thing) is CogMapEnv:
                thing.task.goals  # noqa: B018


class Stack(Cheat):
    """It climbs the stack to whoever called it, and reads ``info`` there."""

    def look(self) -> None:
        frame: Any = sys._getframe()
        while frame is not None:
            if "info" in frame.f_locals:
                frame.f_locals["info"]["pose"]
            frame = frame.f_back


class Items(Cheat):
    """The same, by way of a method of ``info``."""

    def look(self) -> None:
        frame: Any = sys._getframe()
        while frame is not None:
            if "info" in frame.f_locals:
                list(frame.f_locals["info"].items())
            frame = frame.f_back


@pytest.mark.parametrize("kind", [Given, Hunter, Searcher, Stack, Items])
def test_a_robot_that_cheats_is_caught(kind: type[Cheat], guard: Guard) -> None:
    env, robot = made("cogmap"), kind()
    robot.env = env
    with pytest.raises(CheatError):
        played(env, robot, guard)


class Thief(Cheat):
    """A robot that keeps whatever it is given."""

    def __init__(self) -> None:
        self.given: list[Any] = []

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        super().reset(robot, laser)
        self.given += [robot, laser]

    def act(self, observation: Observation) -> NDArray[np.float32]:
        self.given.append(observation)
        return self.robot.move(0.3, 1.0)


def test_a_robot_is_given_observations_and_nothing_else() -> None:
    thief, env = Thief(), gym.make("CogMap/GoHome-v0", map="two_rooms", max_moves=5)
    run_episode(env, thief, 0)
    robot, laser, *seen = thief.given
    assert (type(robot), type(laser)) == (RobotSpec, LaserSpec)
    for observation in seen:
        assert set(observation) == {"scan", "odometry", "bump", "mark", "goal"}
        assert env.observation_space.contains(observation)
    arrays = [a for o in seen for a in o.values() if isinstance(a, np.ndarray)]
    assert arrays
    assert all(a.base is None for a in arrays), "no array is a window on the world's memory"
