"""What one step of the thesis robot costs, and how that grows with its map.

A real run is recorded step by step. For a larger map, copies of what the robot remembers at the
end of the run are laid beside the real one like further offices: surfaces, ASRs, exits and path,
each with names of their own. The robot then takes recorded steps again, with the small memory
and with the large one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from agents.cogmap.agent import CogMapAgent
from agents.cogmap.exits import NOWHERE, Exit
from agents.cogmap.memory import Memory
from agents.cogmap.mfis import MFIS
from agents.cogmap.places import Network
from agents.rollout import run_episode
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import Observation

Floats = NDArray[np.float64]

SMALL, LARGE, SPREAD = 100, 1_000, 0.25
"""Surfaces of the maps compared; a step counts for the small one within this share of it."""
_BETWEEN = 1.0
"""Free space between the copies of an office [m]. Ours: offices of one building."""
_IN_MFIS = ("surfaces", "anchor")
"""Fields of the MFIS that hold places in it."""
_STEPS = ("born", "seen", "sighted")
"""Fields of the MFIS that hold steps."""


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """One step of a run: what the robot remembered, what it saw, how long it took."""

    before: Memory
    observation: Observation
    seconds: float

    @property
    def surfaces(self) -> int:
        """How many surfaces the MFIS had before the step."""
        return len(self.before.mapping.mfis)


class _Recorder(CogMapAgent):
    """The robot, with a clock."""

    steps: list[Recorded]

    def act(self, observation: Observation) -> NDArray[np.float32]:
        before, begun = self.memory, time.perf_counter()
        action = super().act(observation)
        self.steps.append(Recorded(before, observation, time.perf_counter() - begun))
        return action


def step_costs(env: gym.Env[Any, Any], rounds: int, seed: int) -> list[dict[str, Any]]:
    """The cost of ``CogMapAgent.act`` in a run, and of some of its steps with ten times the map.

    Args:
        env: an environment that maps at least ``SMALL`` surfaces.
        rounds: how often the steps are taken again; small and large maps take turns.
        seed: of the environment.

    Returns:
        A row each: ``robot``, ``surfaces``, ``steps``, ``median_ms``, ``p95_ms``, and ``ratio``
        of the median to that with the small map, None for the whole run.
    """
    steps, agent = record(env, seed), CogMapAgent()
    chosen = [s for s in steps if abs(s.surfaces - SMALL) <= SPREAD * SMALL]
    real = [s.before for s in chosen]
    large = [enlarged(memory, steps[-1].before, LARGE) for memory in real]
    taken = [[seconds_a_step(chosen, m, agent) for m in (real, large)] for _ in range(rounds)]
    small_s, large_s = np.median(np.array(taken), axis=0)
    all_s = np.array([s.seconds for s in steps])
    return [
        _row("every step of the run", f"0 to {steps[-1].surfaces}", all_s, None),
        _row("its steps at about 100", f"{chosen[0].surfaces} to {chosen[-1].surfaces}",
             small_s, small_s),
        _row("the same, map enlarged", f"{LARGE}", large_s, small_s),
    ]  # fmt: skip


def _row(name: str, surfaces: str, seconds: Floats, small: Floats | None) -> dict[str, Any]:
    return {
        "robot": name,
        "surfaces": surfaces,
        "steps": len(seconds),
        "median_ms": 1e3 * float(np.median(seconds)),
        "p95_ms": 1e3 * float(np.quantile(seconds, 0.95)),
        "ratio": None if small is None else float(np.median(seconds) / np.median(small)),
    }


def record(env: gym.Env[Any, Any], seed: int) -> list[Recorded]:
    """Every step of one episode; a first one, not recorded, lets numba compile."""
    agent = _Recorder()
    for _ in range(2):
        agent.steps = []
        run_episode(env, agent, seed)
    return agent.steps


def seconds_a_step(steps: list[Recorded], memories: list[Memory], agent: CogMapAgent) -> Floats:
    """Time of each recorded step, (T,), taken again from these memories by a reset agent."""
    taken = []
    for step, memory in zip(steps, memories, strict=True):
        agent.memory, agent.edits = memory, []
        begun = time.perf_counter()
        agent.act(step.observation)
        taken.append(time.perf_counter() - begun)
    return np.array(taken)


def enlarged(memory: Memory, source: Memory, surfaces: int) -> Memory:
    """The memory with copies of all that ``source`` knows around it.

    Args:
        memory: where the robot is in the middle of a run; its own part stays as it is.
        source: the memory at the end of that run.
        surfaces: how many the MFIS shall have; the last copy has as many as are wanted.
    """
    size = np.ptp(source.mapping.mfis.surfaces.reshape(-1, 2), axis=0) + _BETWEEN
    for cell in _around():
        missing = surfaces - len(memory.mapping.mfis)
        if missing <= 0:
            break
        memory = _with_copy(memory, source, Pose(*(size * cell)), missing)
    return memory


def _around() -> Iterator[Floats]:
    """Cells of a grid about the middle one, the nearest first."""
    reach = range(-5, 6)
    cells = [(i, j) for i in reach for j in reach if (i, j) != (0, 0)]
    yield from np.array(sorted(cells, key=lambda c: (math.hypot(*c), c)), dtype=np.float64)


def _with_copy(memory: Memory, source: Memory, shift: Pose, most: int) -> Memory:
    """The memory with one copy of the other, no more than ``most`` surfaces of it, shifted."""
    old, known = memory.mapping.mfis, source.mapping.mfis
    surfaces, exits, places = old.last_id, len(memory.book), memory.network.last_id

    def named(place: int) -> int:
        return place + places if place > 0 else place

    asrs = [
        replace(
            asr,
            id=named(asr.id),
            boundary=shift.apply(asr.boundary),
            surfaces=asr.surfaces + surfaces,
            boundary_surfaces=asr.boundary_surfaces + surfaces,
            corners=shift.apply(asr.corners),
            large=shift.apply(asr.large),
        )
        for asr in source.network.asrs
    ]
    book = [_moved_exit(e, shift, exits, places) for e in source.book]
    tags = np.where(known.asr > 0, known.asr + places, known.asr)
    moved: dict[str, Any] = {name: shift.apply(getattr(known, name)) for name in _IN_MFIS}
    # The copies were mapped long before the run, and nothing of them is in view.
    earlier: dict[str, Any] = {
        name: getattr(known, name) - source.mapping.step - 1 for name in _STEPS
    }
    changes: dict[str, Any] = {"asr": tags, "entered": np.ones(len(known), np.bool_)}
    changes["ids"] = known.ids + surfaces
    copied = replace(known, **changes, **moved, **earlier)
    path = np.concatenate((source.path + np.array((shift.x, shift.y, 0.0)), memory.path))
    return replace(
        memory,
        mapping=replace(memory.mapping, mfis=_joined(old, copied, most)),
        book=(*memory.book, *book),
        network=Network((*memory.network.asrs, *asrs), places + source.network.last_id),
        departures=(*memory.departures, *((named(p), at) for p, at in source.departures)),
        path=path,
    )


def _moved_exit(e: Exit, shift: Pose, exits: int, places: int) -> Exit:
    left, right = (p + places if p != NOWHERE else p for p in (e.left, e.right))
    return replace(e, id=e.id + exits, line=shift.apply(e.line), left=left, right=right)


def _joined(first: MFIS, second: MFIS, most: int) -> MFIS:
    """Both maps as one, with the first ``most`` rows of the second."""
    return MFIS(
        *(
            np.concatenate((getattr(first, name), getattr(second, name)[:most]))
            for name in MFIS.__dataclass_fields__
        )
    )
