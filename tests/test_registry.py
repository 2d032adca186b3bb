"""Every robot by name: the protocol, garbage, and that a life begins anew with each reset."""

from __future__ import annotations

import copy
import json
import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401 - registers the environments
from agents.base import Agent
from agents.registry import AGENTS, Entry, is_available, make_agent, wrap
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.wrappers import TruePose

NAMES = [
    pytest.param(
        name, marks=pytest.mark.skipif(not is_available(name), reason=f"needs {entry.needs}")
    )
    for name, entry in AGENTS.items()
]
GARBAGE = (math.nan, 0.0, -1.0, math.inf, -math.inf, 32.0, 1e6)
KEYS = {
    *("surfaces", "exits", "asrs", "links", "here"),
    *("pose", "home", "marks", "route", "status"),
}


def played(name: str, agent: Agent, steps: int) -> list[NDArray[np.float32]]:
    """Actions in the first steps of an episode."""
    env = wrap(name, gym.make("CogMap/GoHome-v0", map="two_rooms"))
    observation, _ = env.reset(seed=3)
    agent.reset(env.get_wrapper_attr("robot"), env.get_wrapper_attr("laser"))
    actions = []
    for _ in range(steps):
        actions.append(agent.act(copy.deepcopy(observation)))
        observation, _, terminated, truncated, _ = env.step(actions[-1])
        if terminated or truncated:
            break
    env.close()
    return actions


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_by_name_follows_the_protocol(name: str) -> None:
    agent = make_agent(name)
    assert isinstance(agent, Agent)
    played(name, agent, 5)
    sketch = agent.sketch()
    assert sketch is not None
    assert set(sketch) >= KEYS
    assert json.loads(json.dumps(sketch, allow_nan=False)) == sketch


@pytest.mark.parametrize("name", NAMES)
def test_a_reset_begins_the_same_life_anew(name: str) -> None:
    agent = make_agent(name)
    first, again = played(name, agent, 30), played(name, agent, 30)
    assert np.array_equal(first, again)
    assert np.array_equal(first, played(name, make_agent(name), 30))


@pytest.mark.parametrize("name", NAMES)
def test_garbage_in_the_scan_is_no_reason_to_raise(name: str) -> None:
    agent, rng, space = make_agent(name), np.random.default_rng(0), RobotSpec().action_space
    agent.reset(RobotSpec(), LaserSpec())
    for step in range(40):
        scan = rng.choice(GARBAGE, 360) if step % 2 else np.full(360, GARBAGE[step // 2 % 7])
        observation: dict[str, Any] = {
            "scan": scan.astype(np.float32),
            "odometry": rng.normal(0.0, 0.2, 3).astype(np.float32),
            "bump": step % 3 == 0,
            "mark": int(step == 0),
            "goal": int(step > 20),
            "pose": rng.normal(0.0, 1.0, 3).astype(np.float32),
        }
        action = agent.act(observation)
        assert action.dtype == np.float32
        assert space.contains(action)


def test_only_oracles_are_told_the_true_pose() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms")
    for name, entry in AGENTS.items():
        assert isinstance(wrap(name, env), TruePose) == entry.knows_pose == ("oracle" in name)


@pytest.mark.parametrize("ask", [make_agent, lambda name: wrap(name, gym.Env())])
def test_an_unknown_robot_is_named(ask: Any) -> None:
    with pytest.raises(ValueError, match=r"agent: expected one of .*'nobody'"):
        ask("nobody")


def test_a_robot_whose_extra_is_missing_says_which(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(AGENTS, "lame", Entry(AGENTS["cogmap"].make, needs="no_such", extra="legs"))
    assert not is_available("lame")
    with pytest.raises(ModuleNotFoundError, match=r"lame: needs no_such: .*\[legs\]"):
        make_agent("lame")
