"""Gymnasium's and Stable-Baselines3's checkers find no fault, and the vector wrappers work."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from cogmap_gym import ENV_IDS
from cogmap_gym.env import CogMapEnv
from cogmap_gym.soaking import CONTROLS
from tests.test_env import digest, in_haste  # noqa: F401 - a fixture
from tests.test_wrappers import WRAPPED

MODES = (None, *CogMapEnv.metadata["render_modes"])
Check = Callable[[gym.Env[Any, Any]], None]


def gymnasium_checks(env: gym.Env[Any, Any]) -> None:
    check_env(env)


def stable_baselines_checks(env: gym.Env[Any, Any]) -> None:
    checker = pytest.importorskip(
        "stable_baselines3.common.env_checker", reason="needs Stable-Baselines3, the extra 'rl'"
    )
    checker.check_env(env, warn=True)


CHECKS = pytest.mark.parametrize("check", [gymnasium_checks, stable_baselines_checks])


@CHECKS
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("name", ENV_IDS)
def test_every_id_control_and_render_mode_is_without_a_fault(
    name: str, control: str, mode: str | None, check: Check
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check(gym.make(name, control=control, render_mode=mode).unwrapped)


@CHECKS
@pytest.mark.parametrize("wrapper", WRAPPED)
@pytest.mark.parametrize("mode", MODES)
def test_every_wrapper_is_without_a_fault_but_that_it_is_one(
    mode: str | None, wrapper: str, check: Check
) -> None:
    """The ids take turns."""
    control, wrap = WRAPPED[wrapper]
    turn = list(WRAPPED).index(wrapper) + MODES.index(mode)
    name = ENV_IDS[turn % len(ENV_IDS)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        check(wrap(gym.make(name, control=control, render_mode=mode)))


def vector_walk(mode: str, name: str, **keywords: Any) -> list[str]:
    envs = gym.make_vec(name, num_envs=2, vectorization_mode=mode, max_moves=6, **keywords)
    try:
        envs.action_space.seed(3)
        outcomes: list[Any] = [envs.reset(seed=1000)]
        outcomes += [envs.step(envs.action_space.sample()) for _ in range(9)]
    finally:
        envs.close()
    assert np.any(outcomes[6][3]), "an episode was cut, and another begun"
    return [digest(outcome) for outcome in outcomes]


@pytest.mark.parametrize(("name", "control"), list(itertools.product(ENV_IDS, CONTROLS)))
def test_the_sync_and_async_vector_wrappers_give_the_same_bits(name: str, control: str) -> None:
    assert vector_walk("sync", name, control=control) == vector_walk("async", name, control=control)


def test_the_vector_wrappers_take_wrapped_and_living_worlds() -> None:
    wrap = WRAPPED["all over velocity"][1]
    keywords = {"control": "velocity", "map": "two_rooms", "dynamics": "busy", "wrappers": [wrap]}
    runs = [vector_walk(mode, "CogMap/GoTo-v0", **keywords) for mode in ("sync", "async")]
    assert runs[0] == runs[1]


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_a_robot_of_a_vector_wrapper_does_what_it_does_alone(mode: str) -> None:
    envs = gym.make_vec("CogMap/GoHome-v0", num_envs=2, vectorization_mode=mode, map="two_rooms")
    alone = [gym.make("CogMap/GoHome-v0", map="two_rooms") for _ in range(2)]
    observation, _ = envs.reset(seed=1000)
    own = [env.reset(seed=1000 + k)[0] for k, env in enumerate(alone)]
    for _ in range(5):
        for k in range(2):
            assert all((observation[key][k] == own[k][key]).all() for key in own[k])
        action = np.array(((0.2, -0.4, -1.0), (-0.3, 0.1, -1.0)), dtype=np.float32)
        observation = envs.step(action)[0]
        own = [env.step(a)[0] for env, a in zip(alone, action, strict=True)]
    envs.close()
