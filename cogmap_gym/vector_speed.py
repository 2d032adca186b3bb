"""The speed of the vector environment beside that of a naive one, measured in one run."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterable
from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray

from cogmap_gym.env import CogMapEnv
from cogmap_gym.geometry import Pose, Segments
from cogmap_gym.observation import LaserSpec
from cogmap_gym.sites import Map
from cogmap_gym.vector import CogMapVectorEnv

ROBOTS = 64
"""Robots of the first rows."""
MANY_ROBOTS = 4096
"""Robots of the last row."""
NAIVE_STEPS = 40
"""Steps of the naive environment a round."""
ROBOT_STEPS = 12_800
"""Steps of all robots of a vector environment a round, about."""
WARM_UP = 100
"""Steps before the clock starts: the view from home has been seen."""


class NaiveLaser:
    """Asks pymunk for the nearest segment beam by beam, and adds NumPy noise."""

    def __init__(self, walls: Segments, spec: LaserSpec) -> None:
        """See ``walls`` (N, 2, 2) [m]."""
        self._space, self._spec = pymunk.Space(), spec
        for p, q in walls.tolist():
            self._space.add(pymunk.Segment(self._space.static_body, p, q, 0.0))

    def scan(self, pose: Pose, rng: np.random.Generator) -> NDArray[np.float32]:
        """One scan (beams,) [m]."""
        spec, every = self._spec, pymunk.ShapeFilter()
        reach, ranges = spec.range_max, np.full(spec.beams, spec.range_max)
        for i, angle in enumerate((pose.theta + spec.angles).tolist()):
            end = pose.x + reach * math.cos(angle), pose.y + reach * math.sin(angle)
            hit = self._space.segment_query_first((pose.x, pose.y), end, 0.0, every)
            if hit is not None:
                ranges[i] = reach * hit.alpha
        noisy = np.clip(ranges + rng.normal(0.0, spec.sd, spec.beams), 0.0, reach)
        return np.where(ranges < reach, noisy, reach).astype(np.float32)


class NaiveEnv(CogMapEnv):
    """The same task with a naive laser; all else is as in ``CogMapEnv``."""

    def reset(self, **keywords: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the laser sees the doors as they stand then."""
        self._scanner = NaiveLaser(self.world.solid_segments, self.laser)  # type: ignore[assignment]
        return super().reset(**keywords)


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
    naive = NaiveEnv(**keywords)  # type: ignore[arg-type]
    naive.reset(seed=seed)
    sizes = [(ROBOTS, 1), (ROBOTS, 2), (MANY_ROBOTS, 1)]
    envs = [CogMapVectorEnv(n, **keywords, threads=k) for n, k in sizes]  # type: ignore[arg-type]
    for env in envs:
        env.reset(seed=seed)
        _seconds(env, WARM_UP, seed)
    times = [
        [_naive_seconds(naive, seed), *(_seconds(env, ROBOT_STEPS, seed) for env in envs)]
        for _ in rounds
    ]
    rows: list[dict[str, object]] = []
    for k, (robots, threads) in enumerate([(1, 1), *sizes]):
        rows.append(
            {
                "environment": "vector" if k else "naive",
                "robots": robots,
                "threads": threads,
                "step_us": 1e6 * statistics.median(row[k] for row in times),
                "times_naive": statistics.median(row[0] / row[k] for row in times),
                "times_64_on_one_thread": statistics.median(row[1] / row[k] for row in times),
            }
        )
    return rows


def _actions(count: int, seed: int) -> NDArray[np.float32]:
    """Random walks that declare nothing, (16, count, 3)."""
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (16, count, 3))
    actions[:, :, 2] = -1.0
    return actions.astype(np.float32)


def _naive_seconds(env: NaiveEnv, seed: int) -> float:
    """Mean time of one step."""
    actions, begin = _actions(1, seed)[:, 0], time.perf_counter()
    for k in range(NAIVE_STEPS):
        _, _, terminated, truncated, _ = env.step(actions[k % len(actions)])
        if terminated or truncated:
            env.reset()
    return (time.perf_counter() - begin) / NAIVE_STEPS


def _seconds(env: CogMapVectorEnv, robot_steps: int, seed: int) -> float:
    """Mean time of one robot's step."""
    actions, count = _actions(env.num_envs, seed), max(robot_steps // env.num_envs, 4)
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
