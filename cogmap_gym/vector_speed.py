"""The speed of the environments, one robot or many, beside a naive one's, measured in one run."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.env import CogMapEnv
from cogmap_gym.naive import NaiveEnv
from cogmap_gym.sites import Map
from cogmap_gym.vector import CogMapVectorEnv

ROBOTS = 64
"""Robots of the first rows."""
MANY_ROBOTS = 4096
"""Robots of the last row."""
NAIVE_STEPS, SINGLE_STEPS = 40, 400
"""Steps of the naive environment and of ours with one robot a round."""
ROBOT_STEPS = 12_800
"""Steps of all robots of a vector environment a round, about."""
WARM_UP = 1_000
"""Steps of each robot before the clock starts: while much is new, a step costs more, so that
fleets can be compared only where all robots have seen about as much."""


def vector_costs(
    map: Map,  # noqa: A002 - the environment's keyword
    task: str,
    control: str,
    rounds: Iterable[int],
    seed: int,
) -> list[dict[str, object]]:
    """Microseconds that a robot's step takes, and how many times faster than naively.

    Args:
        map: of the environments.
        task: of the environments.
        control: of the robots.
        rounds: in each, all take their turn, so that a slow spell meets all.
        seed: of the episodes and of the random walks.

    Returns:
        A row for each: robots, threads, microseconds (medians), and the median of the rounds'
        ratios to the naive environment and to 64 robots on one thread.
    """
    keywords = {"map": map, "task": task, "control": control}
    naive, single = NaiveEnv(**keywords), CogMapEnv(**keywords)  # type: ignore[arg-type]
    for alone in (naive, single):
        alone.reset(seed=seed)
    sizes = [(ROBOTS, 1), (ROBOTS, 2), (MANY_ROBOTS, 1)]
    envs = [CogMapVectorEnv(n, **keywords, threads=k) for n, k in sizes]  # type: ignore[arg-type]
    for env in envs:
        env.reset(seed=seed)
        _seconds(env, WARM_UP * env.num_envs, seed)
    times = [
        [
            alone_seconds(naive, NAIVE_STEPS, seed),
            alone_seconds(single, SINGLE_STEPS, seed),
            *(_seconds(env, ROBOT_STEPS, seed) for env in envs),
        ]
        for _ in rounds
    ]
    named = [("naive", 1, 1), ("single", 1, 1), *(("vector", *size) for size in sizes)]
    return [
        {
            "environment": name,
            "robots": robots,
            "threads": threads,
            "step_us": 1e6 * statistics.median(row[k] for row in times),
            "times_naive": statistics.median(row[0] / row[k] for row in times),
            "times_64_on_one_thread": statistics.median(row[2] / row[k] for row in times),
        }
        for k, (name, robots, threads) in enumerate(named)
    ]


def random_walks(count: int, seed: int) -> NDArray[np.float32]:
    """Random walks that declare nothing, (16, count, 3)."""
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (16, count, 3))
    actions[:, :, 2] = -1.0
    return actions.astype(np.float32)


def alone_seconds(env: CogMapEnv, steps: int, seed: int) -> float:
    """Mean time of one step of an environment of one robot that walks at random [s]."""
    actions, begin = random_walks(1, seed)[:, 0], time.perf_counter()
    for k in range(steps):
        _, _, terminated, truncated, _ = env.step(actions[k % len(actions)])
        if terminated or truncated:
            env.reset()
    return (time.perf_counter() - begin) / steps


def _seconds(env: CogMapVectorEnv, robot_steps: int, seed: int) -> float:
    """Mean time of one robot's step."""
    actions, count = random_walks(env.num_envs, seed), max(robot_steps // env.num_envs, 4)
    begin = time.perf_counter()
    for k in range(count):
        env.step(actions[k % len(actions)])
    return (time.perf_counter() - begin) / (count * env.num_envs)


def seconds_to_start(offices: Iterable[int]) -> float:
    """How long it takes to make an environment of generated offices, one for each robot [s]."""
    names = [f"office:{seed}" for seed in offices]
    begin = time.perf_counter()
    CogMapVectorEnv(len(names), map=names).close()
    return time.perf_counter() - begin
