"""Every robot by its name: how it is made, and what it needs of the environment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium as gym

from agents.base import Agent
from agents.cogmap import CogMapAgent, Params
from agents.frontier import FrontierAgent
from agents.frontier.matching import ScanMatching
from agents.frontier.positions import DeadReckoning, TruePosition
from agents.random_walk import RandomWalkAgent
from agents.wall_follower import WallFollowerAgent
from cogmap_gym.wrappers import TruePose


@dataclass(frozen=True, slots=True)
class Entry:
    """A robot that can be asked for by name."""

    make: Callable[[int], Agent]
    """Makes one that has not lived yet; the seed is for robots that draw numbers."""
    knows_pose: bool = False
    """Whether it is an oracle: its observations have the true ``pose``."""
    needs: str = ""
    """The module without which it cannot be made, and ..."""
    extra: str = ""
    """... the extra of this package that brings it."""


def _slam_agent(_: int) -> Agent:
    """The frontier robot with SLAM; its module needs gtsam at once."""
    from agents.frontier.slam import PoseGraphSLAM

    return FrontierAgent(PoseGraphSLAM())


def _learned(name: str) -> Callable[[int], Agent]:
    """A robot with the weights of this name; its modules need torch at once."""

    def make(seed: int) -> Agent:
        from agents.ppo.agent import LearnedAgent
        from agents.ppo.loading import path_of

        return LearnedAgent(path_of(name), seed)

    return make


AGENTS: dict[str, Entry] = {
    "random_walk": Entry(RandomWalkAgent),
    "wall_follower": Entry(lambda _: WallFollowerAgent()),
    "frontier_odometry": Entry(lambda _: FrontierAgent(DeadReckoning())),
    "frontier_scan_matching": Entry(lambda _: FrontierAgent(ScanMatching())),
    "frontier_slam": Entry(_slam_agent, needs="gtsam", extra="slam"),
    "frontier_oracle": Entry(lambda _: FrontierAgent(TruePosition()), knows_pose=True),
    "ppo": Entry(_learned("ppo"), needs="sb3_contrib", extra="rl"),
    "recurrent_ppo": Entry(_learned("recurrent_ppo"), needs="sb3_contrib", extra="rl"),
    "cogmap": Entry(lambda _: CogMapAgent()),
    "cogmap_literal": Entry(lambda _: CogMapAgent(Params.literal())),
}
"""The robots, the simplest first."""


def make_agent(name: str, seed: int = 0) -> Agent:
    """A new robot of this name.

    Args:
        name: one of ``AGENTS``, or ``module:Class`` for a robot of one's own.
        seed: of the chance of a robot that draws numbers; the others take no notice.

    Raises:
        ValueError: there is none of that name.
        ModuleNotFoundError: it needs an extra that is not installed.
    """
    entry = _entry(name)
    if not is_available(name):
        what = f"pip install 'cogmap-gym[{entry.extra}]'"
        raise ModuleNotFoundError(f"{name}: needs {entry.needs}: {what}", name=entry.needs)
    return entry.make(seed)


def is_available(name: str) -> bool:
    """Whether all that this robot needs is installed.

    Raises:
        ValueError: there is no robot of that name.
    """
    needs = _entry(name).needs
    return not needs or find_spec(needs) is not None


def wrap(name: str, env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    """The environment as this robot needs it: oracles get the true pose, others what there is.

    Raises:
        ValueError: there is no robot of that name.
    """
    return TruePose(env) if _entry(name).knows_pose else env


def _entry(name: str) -> Entry:
    """The entry of a name; ``module:Class`` names a robot of the user's own."""
    if name in AGENTS:
        return AGENTS[name]
    module, _, kind = name.partition(":")
    try:
        made = getattr(import_module(module), kind) if module and kind else None
    except (ImportError, AttributeError) as error:
        raise ValueError(f"agent: cannot import {name!r}: {error}") from error
    if not callable(made):
        raise ValueError(f"agent: expected one of {sorted(AGENTS)} or module:Class, got {name!r}")
    return Entry(lambda _: made())
