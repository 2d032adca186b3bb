"""The card of a set of weights: how they came about, and how they do on the test offices."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from agents.base import Agent
from agents.ppo.agent import LearnedAgent
from agents.provenance import commit
from agents.random_walk import RandomWalkAgent
from agents.rollout import run_episode
from cogmap_gym import FloorPlan
from cogmap_gym.metrics import wilson
from cogmap_gym.saving import write_whole
from cogmap_gym.statistics import bootstrap, interquartile_mean, interquartile_mean_of
from cogmap_gym.trial_scores import curve_area, distance_area

OFFICES = range(10)
"""The test offices of the comparison."""
METRES_PER_AREA = 0.5
"""Metres of way for each square metre of free space, over which coverage is compared [1/m]. Ours:
about what the frontier robot needs to see 95 %."""
POINTS = 40
"""Of the curve that a card keeps [-]."""
SCORES = {"area": "share seen, mean over the budget of moves",
          "distance_area": "share seen, mean over 0.5 m of way for each m2",
          "coverage": "share seen at the end"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Result:
    """How one robot did in one episode of ``Explore`` and one of ``GoHome``."""

    robot: str
    office: int
    seed: int
    area: float
    distance_area: float
    coverage: float
    came_home: bool


def compare(
    name: str, path: Path, seeds: int, offices: Sequence[int] = OFFICES
) -> Iterator[Result]:
    """A learned robot beside the random walk, on the same episodes.

    Args:
        name: of the learned robot.
        path: of its weights.
        seeds: how many an office.
        offices: their numbers.
    """
    robots: dict[str, Callable[[int], Agent]] = {
        name: partial(LearnedAgent, path),
        "random_walk": RandomWalkAgent,
    }
    for office in offices:
        plan = FloorPlan.load(f"office:{office}")
        for robot, make in robots.items():
            for seed in range(seeds):
                yield Result(robot, office, seed, *run(make(seed), plan, seed))


def run(agent: Agent, plan: FloorPlan, seed: int) -> tuple[float, float, float, bool]:
    """One episode of each task; medium odometry. What a ``Result`` ends with."""
    env = gym.make("CogMap/Explore-v0", map=plan)
    seen, driven = [], []

    def watch(_step: int, _seen: Any, _action: Any, info: dict[str, Any], _agent: Agent) -> None:
        seen.append(info["coverage"])
        driven.append(info["path_length"])

    episode = run_episode(env, agent, seed, watch)
    shares = np.array([*seen, episode.info["coverage"]])
    way = np.array([*driven, episode.info["path_length"]])
    home = run_episode(gym.make("CogMap/GoHome-v0", map=plan), agent, seed)
    area = curve_area(shares, env.unwrapped.max_moves)  # type: ignore[attr-defined]
    by_distance = distance_area(shares, way, METRES_PER_AREA * plan.area)
    return area, by_distance, float(shares[-1]), home.is_success


def summary(results: Sequence[Result]) -> dict[str, dict[str, Any]]:
    """By robot: the interquartile mean and its interval of each score, and the rate of GoHome."""
    told: dict[str, dict[str, Any]] = {}
    for robot in dict.fromkeys(one.robot for one in results):
        own = [one for one in results if one.robot == robot]
        told[robot] = {"episodes": len(own)}
        for score in SCORES:
            strata = [
                np.array([getattr(one, score) for one in own if one.office == office])
                for office in sorted({one.office for one in own})
            ]
            low, high = bootstrap(strata, interquartile_mean_of, np.random.default_rng(0))
            told[robot][score] = [interquartile_mean(np.concatenate(strata)), low, high]
        met = sum(one.came_home for one in own)
        told[robot]["came_home"] = [met / len(own), *wilson(met, len(own))]
    return told


def write_card(
    path: Path,
    args: Mapping[str, Any],
    config: Mapping[str, Any],
    curve: Sequence[Mapping[str, float]],
    results: Sequence[Result],
) -> tuple[Path, Path]:
    """Write the card of weights beside them, to be read by programs and by people.

    Args:
        path: of the weights.
        args: what they were trained with.
        config: what they perceive, how they move, and the network.
        curve: of training.
        results: of the comparison; none if it was left out.
    """
    every = max(len(curve) // POINTS, 1)
    card = {
        "commit": commit(),
        "args": dict(args),
        "config": dict(config),
        "curve": [*curve[:-1:every], *curve[-1:]],
        "test": summary(results),
    }
    written = write_whole(path.with_suffix(".json"), f"{json.dumps(card, indent=1)}\n".encode())
    return written, write_whole(path.with_suffix(".md"), "\n".join(_page(path.stem, card)).encode())


def _page(name: str, card: Mapping[str, Any]) -> Iterator[str]:
    """The card as Markdown."""
    args, last = card["args"], card["curve"][-1] if card["curve"] else {}
    yield f"# {name}\n"
    yield (
        f"Trained by `scripts/train_ppo.py` at commit {card['commit'] or 'unknown'}: "
        f"{int(last.get('steps', 0)):,} moves in {last.get('minutes', 0.0):.0f} minutes, "
        f"{args['explorers'] + args['homers']} robots in offices from {args['first_office']} up, "
        f"{args['odometry']} odometry, seed {args['seed']}. All arguments, sizes and the whole "
        f"curve stand in `{name}.json`.\n"
    )
    if card["test"]:
        yield "Offices 0 to 9, medium odometry; in brackets the 95 % interval.\n"
        yield f"| | {' | '.join(card['test'])} |"
        yield f"|---|{'---|' * len(card['test'])}"
        for score, told in {**SCORES, "came_home": "came home when called"}.items():
            cells = (_told(robot[score]) for robot in card["test"].values())
            yield f"| {told} | {' | '.join(cells)} |"
        yield ""
    keys = [key for key in last if key not in ("steps", "minutes")]
    yield f"| moves | minutes | {' | '.join(keys)} |"
    yield f"|---|---|{'---|' * len(keys)}"
    for point in card["curve"][:: max(len(card["curve"]) // 10, 1)]:
        cells = (f"{point[key]:.2f}" if key in point else "" for key in keys)
        yield f"| {int(point['steps']):,} | {point['minutes']:.1f} | {' | '.join(cells)} |"
    yield ""


def _told(value: Sequence[float]) -> str:
    middle, low, high = value
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"
