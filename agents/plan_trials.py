"""Out and home on any floor plan: how much the robot sees, and whether it returns.

It explores until 95 % has been seen or the budget of ``Explore`` is used up; then it is called
home, with the budget of a way home.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from matplotlib.figure import Figure

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent
from cogmap_gym.actions import DECLARED
from cogmap_gym.courses import home_moves
from cogmap_gym.experiment_figures import overview_figure
from cogmap_gym.observation import Observation
from cogmap_gym.saving import save_png
from cogmap_gym.tasks import ARRIVED_M, HOME

ENOUGH = 0.7
"""Share of the reachable area that must be seen [1]."""


@dataclass(frozen=True, slots=True)
class PlanTrial:
    """What is run."""

    plan: str
    """Keyword ``map`` of the environment; a mapping as JSON."""
    seed: int
    """Of the episode."""
    odometry: str
    """Name of a level."""

    @property
    def map(self) -> str | Mapping[str, Any]:
        """The keyword itself."""
        return dict(json.loads(self.plan)) if self.plan.startswith("{") else self.plan


def run_plan_trial(trial: PlanTrial, failures: Path | None = None) -> dict[str, Any]:
    """One episode, scored; one that breaks down is a row, too.

    Args:
        trial: what to run.
        failures: folder for a picture of a failed run.
    """
    row: dict[str, Any] = {"plan": trial.plan, "seed": trial.seed, "odometry": trial.odometry}
    try:
        # Past the end of the task the world goes on; only the checks of gym.make are in the way.
        env: Any = gym.make("CogMap/Explore-v0", map=trial.map, odometry=trial.odometry).unwrapped
        agent = CogMapAgent()
        row |= _out_and_home(env, agent, trial.seed)
    except Exception as error:  # noqa: BLE001 - a rate counts every run
        return {**row, "size": 0.0, "success": False, "why": f"raised {error!r}"}
    if failures is not None and not row["success"]:
        failures.mkdir(parents=True, exist_ok=True)
        name = "".join(c if c.isalnum() else "_" for c in env.plan.name)
        save_png(_figure(env, agent, row), failures / f"{name}_{trial.seed}.png")
    return row


def _out_and_home(env: Any, agent: CogMapAgent, seed: int) -> dict[str, Any]:
    """Drive the robot; answer what came of it."""
    observation, info = env.reset(seed=seed)
    agent.reset(env.robot, env.laser)
    moves, over = 0, False
    while not over:
        observation, _, terminated, truncated, info = env.step(agent.act(observation))
        moves, over = moves + 1, terminated or truncated
    seen, home, back, declared = info["coverage"], env.task.marks[HOME], 0, False
    while not declared and back < home_moves(env.plan):
        action = agent.act(_called(observation))
        declared, back = bool(action[2] > DECLARED), back + 1
        if not declared:
            observation, _, _, _, info = env.step(action)
    off = float(np.hypot(info["pose"][0] - home.x, info["pose"][1] - home.y))
    left, low, right, high = env.plan.bounds
    why = [f"saw {seen:.0%}"] if seen < ENOUGH else []
    if not declared:
        why.append(f"not home in {back} moves, {off:.1f} m away")
    elif off > ARRIVED_M:
        gave_in = agent.memory.status.startswith("no route")
        why.append(f"{'gave in' if gave_in else 'declared'} {off:.1f} m from home")
    return {
        "size": max(right - left, high - low),
        "area": float(env.plan.area),
        "coverage": seen,
        "moves": moves,
        "moves_home": back,
        "home": declared and off <= ARRIVED_M,
        "places": len(agent.memory.network.asrs),
        "success": not why,
        "why": "; ".join(why),
    }


def _called(observation: Observation) -> Observation:
    """The observation of a robot that is called home."""
    return {**observation, "goal": np.int64(HOME)}


def _figure(env: Any, agent: CogMapAgent, row: Mapping[str, Any]) -> Figure:
    """The truth beside the belief."""
    scene = env.scene()
    title = f"{env.plan.name}, seed {row['seed']}: {row['why']}"
    path = np.asarray(scene.path)
    return overview_figure(
        env.plan, path, agent.sketch(), agent.memory.path[:, :2], scene.plan_from_sketch, title
    )
