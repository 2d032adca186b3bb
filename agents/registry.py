"""Every robot by its name: how it is made, and what it needs of the environment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium as gym

from agents.base import Agent
from agents.cogmap import CogMapAgent, Params
from agents.frontier import FrontierAgent
from agents.frontier.matching import ScanMatching
from agents.frontier.positions import DeadReckoning, TruePosition
from agents.frontier.slam import PoseGraphSLAM
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


AGENTS: dict[str, Entry] = {
    "random_walk": Entry(RandomWalkAgent),
    "wall_follower": Entry(lambda _: WallFollowerAgent()),
    "frontier_odometry": Entry(lambda _: FrontierAgent(DeadReckoning())),
    "frontier_scan_matching": Entry(lambda _: FrontierAgent(ScanMatching())),
    "frontier_slam": Entry(lambda _: FrontierAgent(PoseGraphSLAM())),
    "frontier_oracle": Entry(lambda _: FrontierAgent(TruePosition()), knows_pose=True),
    "cogmap": Entry(lambda _: CogMapAgent()),
    "cogmap_literal": Entry(lambda _: CogMapAgent(Params.literal())),
}
"""The robots, the simplest first."""


def make_agent(name: str, seed: int = 0) -> Agent:
    """A new robot of this name.

    Args:
        name: one of ``AGENTS``.
        seed: of the chance of a robot that draws numbers; the others take no notice.

    Raises:
        ValueError: there is none of that name.
    """
    return _entry(name).make(seed)


def wrap(name: str, env: gym.Env[Any, Any]) -> gym.Env[Any, Any]:
    """The environment as this robot needs it: oracles get the true pose, others what there is.

    Raises:
        ValueError: there is no robot of that name.
    """
    return TruePose(env) if _entry(name).knows_pose else env


def _entry(name: str) -> Entry:
    if name not in AGENTS:
        raise ValueError(f"agent: expected one of {sorted(AGENTS)}, got {name!r}")
    return AGENTS[name]
