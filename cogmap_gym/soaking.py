"""Very many random steps of an environment, and what must never happen in them."""

from __future__ import annotations

import functools
import json
import pickle
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import shapely
from numpy.typing import NDArray

from cogmap_gym import ENV_IDS
from cogmap_gym.dynamics import LEVELS
from cogmap_gym.env import CogMapEnv
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import NO_SEGMENTS, point_segment_distances

CONTROLS = ("move", "velocity")
DEEPEST_M = 0.01
"""How far the robot or a box may be inside something [m]."""
COPIED_STEPS = 25
"""Steps for which a copy is driven beside the original."""
DECLARE = 0.02
"""Share of steps that declare."""
LONGEST_HOLD = 20
"""An action is kept for less than so many steps, so that the robot gets about."""


@dataclass(frozen=True, slots=True)
class Case:
    """Which environment is driven."""

    name: str
    """The id."""
    control: str
    """``"move"`` or ``"velocity"``."""
    map: str
    """The name of the plan."""
    dynamics: str
    """The level of what moves."""
    experiment: int | None
    """Of the thesis; None for other tasks."""

    def made(self, plan: FloorPlan) -> CogMapEnv:
        """The environment, not wrapped.

        Raises:
            ValueError: if there is none, for the task refuses the plan or the level.
        """
        task: dict[str, Any] = {} if self.experiment is None else {"experiment": self.experiment}
        env = gym.make(self.name, map=plan, control=self.control, dynamics=self.dynamics, **task)
        assert isinstance(env.unwrapped, CogMapEnv), "our ids make our environment"
        return env.unwrapped


def cases(plans: Mapping[str, FloorPlan]) -> list[Case]:
    """All that can be made of some plans by name; what is refused in words is left out."""
    possible = []
    for name, control, plan, level in product(ENV_IDS, CONTROLS, plans, LEVELS):
        for experiment in (1, 2, 3) if "Thesis" in name else (None,):
            case = Case(name, control, plan, level, experiment)
            try:
                case.made(plans[plan]).close()
            except ValueError:
                continue
            possible.append(case)
    return possible


def bits(outcome: tuple[Any, ...]) -> str:
    """Every bit of what ``step`` or ``reset`` gave."""
    return json.dumps(outcome, default=lambda x: x.tobytes().hex())


def actions(rng: np.random.Generator, count: int) -> Iterator[NDArray[np.float32]]:
    """Random actions (3,), some beyond the bounds, each kept for a while."""
    action, left = np.zeros(3), 0
    for _ in range(count):
        if not left:
            action, left = rng.uniform(-1.2, 1.2, 3), int(rng.integers(1, LONGEST_HOLD))
        left -= 1
        action[2] = 1.0 if rng.random() < DECLARE else -1.0
        yield action.astype(np.float32)


def faults(env: CogMapEnv, outcome: tuple[Any, ...], deepest: dict[str, float]) -> list[str]:
    """What is wrong after a step, in words.

    Args:
        env: the environment.
        outcome: what its step gave.
        deepest: how deep the robot was inside each kind of thing [m]; brought up to date.
    """
    observation, reward, *_, info = outcome
    numbers = (*observation.values(), *info.values(), reward)
    finite = (np.isfinite(n).all() for n in numbers if isinstance(n, float | np.ndarray))
    found = [] if all(finite) else ["something is not finite"]
    if not env.observation_space.contains(observation):
        found.append("outside the observation space")
    world, here = env.world, env.world.pose.position[None]
    if not shapely.intersects_xy(_building(env.plan), *here.T).all():
        found.append(f"outside the building at {here}")
    corners = np.concatenate((here, *world.box_outlines))
    if not shapely.intersects_xy(_building(env.plan), *corners.T).all():
        found.append("a box outside the building")
    moving = getattr(world.caster, "moving", NO_SEGMENTS)
    for kind, segments in (("walls", world.solid_segments), ("boxes, people", moving)):
        radius = env.robot.radius
        depth = radius - float(point_segment_distances(here, segments).min(initial=radius))
        deepest[kind] = max(deepest.get(kind, 0.0), depth)
        if depth > DEEPEST_M:
            found.append(f"{depth:.4f} m inside {kind} at {here}")
    return found


@functools.lru_cache(maxsize=4)  # a copy brings a plan of its own: all kept would look like a leak
def _building(plan: FloorPlan) -> shapely.Geometry:
    """The free space, and what a box may be inside a wall."""
    free = plan.free_space().buffer(DEEPEST_M)
    shapely.prepare(free)
    return free


def soak(env: CogMapEnv, seed: int, count: int, deepest: dict[str, float]) -> list[str]:
    """Drive an environment, and for a while a copy beside it; what was found wrong.

    Args:
        env: the environment.
        seed: of the first episode and of the actions.
        count: how many steps.
        deepest: as for ``faults``.
    """
    rng, found = np.random.default_rng(seed), []
    copied_at = int(rng.integers(max(count - COPIED_STEPS, 1)))
    twin: CogMapEnv | None = None
    env.reset(seed=seed)
    for number, action in enumerate(actions(rng, count)):
        if number == copied_at:
            twin = pickle.loads(pickle.dumps(env))  # noqa: S301 - our own
        outcome = env.step(action)
        told = faults(env, outcome, deepest)
        if twin is not None and bits(twin.step(action)) != bits(outcome):
            told, twin = [*told, f"the copy of step {copied_at} differs"], None
        if outcome[2] or outcome[3]:
            again = env.reset()
            if twin is not None and bits(twin.reset()) != bits(again):
                told, twin = [*told, f"the reset of the copy of step {copied_at} differs"], None
        found += [f"step {number}: {fault}" for fault in told]
        if twin is not None and number == copied_at + COPIED_STEPS:
            env, twin = twin, None  # what was restored goes on
    return found
