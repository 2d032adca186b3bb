"""What became of the trials that a robot failed: each is run again, its failure is classed, drawn.

A trial is a pure function of its row, so that a table of results is enough to look closer.
"""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from agents.registry import make_agent, wrap
from agents.rollout import Episode, run_episode
from agents.sweep import Trial, made_env
from cogmap_gym.actions import DECLARED
from cogmap_gym.failure_figure import failure_figure
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import Observation
from cogmap_gym.saving import save_png
from cogmap_gym.tasks import ARRIVED_M

CAUSES = {
    "raised": "the robot raised an error",
    "unseen": "it did not see 95 % within the budget",
    "not given": "it had not stood well inside the room in which the mark is given",
    "lost": "it declared where it believed to be at the mark, and was not",
    "gave up": "it declared far from the mark by its own belief: it saw no way",
    "out of time": "its moves were used up",
}
"""Why a trial fails."""
THERE_M = 2.0 * ARRIVED_M
"""Who declares within this distance of where it believes the mark to be thinks it is there [m].
Ours."""


@dataclass(frozen=True, slots=True)
class Miss:
    """One goal that was missed, or the exploration (mark 0)."""

    trial: Trial
    mark: int
    phase: int
    cause: str
    """One of ``CAUSES``."""
    told: str
    """More of it, in words."""


@dataclass(slots=True)
class Trace:
    """Keeps what was true, and what the robot believed, at each step."""

    world: Any
    """The truth."""
    poses: list[Any] = field(default_factory=list)
    believed: list[tuple[float, float]] = field(default_factory=list)
    phases: list[int] = field(default_factory=list)
    declared: dict[int, float | None] = field(default_factory=dict)
    """By phase: how far from the goal the robot believed to be when it declared [m]."""
    shut: dict[int, frozenset[str]] = field(default_factory=dict)
    """By phase: the doors that were shut in the end."""

    def __call__(
        self, _: int, observation: Observation, action: Any, info: dict[str, Any], agent: Any
    ) -> None:
        """Add a step."""
        self.poses.append(info["pose"])
        self.phases.append(info["phase"])
        self.shut[info["phase"]] = frozenset(self.world.shut_doors)
        if isinstance(pose := getattr(agent, "pose", None), Pose):
            self.believed.append((pose.x, pose.y))
        goal = int(observation["goal"])
        if goal and action[2] > DECLARED:
            self.declared.setdefault(info["phase"], _believed_distance(agent, goal))


def examine(trial: Trial, folder: Path | None = None) -> list[Miss]:
    """Run a trial again; answer what it missed, and draw it if there is a folder.

    Args:
        trial: what to run.
        folder: for a picture named after the trial, where it missed anything.
    """
    agent, env = make_agent(trial.agent, trial.seed), made_env(trial)
    world: Any = env.unwrapped
    trace = Trace(world.world)
    try:
        episode = run_episode(wrap(trial.agent, env), agent, trial.seed, trace)
    except Exception:  # noqa: BLE001 - what raises is one of the causes
        return [Miss(trial, 0, 0, "raised", traceback.format_exc().splitlines()[-1])]
    misses = _misses(trial, episode, trace, world)
    if folder is not None and misses:
        folder.mkdir(parents=True, exist_ok=True)
        save_png(_figure(misses, agent, trace, world), folder / f"{_name(trial)}.png")
    return misses


def _figure(misses: Sequence[Miss], agent: Any, trace: Trace, world: Any) -> Figure:
    """The truth beside the belief, with the way to the first goal missed."""
    poses, believed = np.array(trace.poses), np.reshape(trace.believed, (-1, 2))
    first = next((miss for miss in misses if miss.mark), misses[0])
    way = poses[np.array(trace.phases) == first.phase, :2] if first.mark else None
    lines = (_name(first.trial), *(f"{_goal(miss)}: {miss.told}" for miss in misses))
    return failure_figure(
        world.plan, poses, agent.sketch(), believed, world.task.marks, "; ".join(lines),
        first.mark, way, trace.shut.get(first.phase, ()),
    )  # fmt: skip


def _misses(trial: Trial, episode: Episode, trace: Trace, world: Any) -> list[Miss]:
    """What was missed, in order."""
    found, goals = [], iter(world.task.goals)
    for number, phase in enumerate(episode.phases):
        mark = 0 if phase["task"] == "explore" else next(goals)
        if mark and not phase["success"]:
            off = float(episode.info["final_distance"][mark])
            if phase["moves"]:
                cause, told = _cause(number, phase["moves"], off, trace)
            else:
                room = world.task.mark_rooms[mark]
                cause, told = "not given", f"had not stood well inside {room}"
            found.append(Miss(trial, mark, number, cause, told))
    if trial.task == "explore" and not episode.is_success:
        found.append(Miss(trial, 0, 0, "unseen", f"saw {episode.info['coverage']:.1%}"))
    return found


def _cause(phase: int, moves: int, off: float, trace: Trace) -> tuple[str, str]:
    """Why a goal was missed that the robot went for, and more of it in words."""
    if phase not in trace.declared:
        return "out of time", f"{off:.1f} m off after {moves} moves"
    believed = trace.declared[phase]
    where = "" if believed is None else f", {believed:.1f} m by its belief"
    cause = "lost" if believed is not None and believed <= THERE_M else "gave up"
    return cause, f"declared {off:.1f} m off{where}, after {moves} moves"


def _believed_distance(agent: Any, mark: int) -> float | None:
    """How far from a mark the robot believes to be [m]; None if it does not tell."""
    sketch = agent.sketch() or {}
    points = {int(m["id"]): m["point"] for m in sketch.get("marks") or ()}
    if mark not in points or not sketch.get("pose"):
        return None
    return float(np.hypot(*(np.array(points[mark])[:2] - np.array(sketch["pose"])[:2])))


def _goal(miss: Miss) -> str:
    return f"mark {miss.mark}" if miss.mark else "exploring"


def _name(trial: Trial) -> str:
    told = "_".join((trial.agent, trial.task, trial.map, trial.odometry, str(trial.seed)))
    return "".join(c if c.isalnum() or c == "_" else "-" for c in told)
