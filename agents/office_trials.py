"""Episodes of the thesis robot in generated offices, recorded and scored."""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent
from agents.rollout import Episode, run_episode
from cogmap_gym.actions import DECLARED
from cogmap_gym.failure_figure import failure_figure
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.observation import LaserSpec, Observation
from cogmap_gym.office_record import Moment, OfficeRecord, Outcome
from cogmap_gym.office_scores import office_score
from cogmap_gym.plan_motion import drawn_motion, mirrored, moved
from cogmap_gym.saving import save_png
from cogmap_gym.tasks import HOME

TASKS: dict[str, tuple[str, dict[str, Any]]] = {
    "explore": ("CogMap/Explore-v0", {}),
    "home": ("CogMap/GoHome-v0", {}),
    "goto": ("CogMap/GoTo-v0", {}),
    "shortcut": ("CogMap/Shortcut-v0", {}),
    "noroute": ("CogMap/Shortcut-v0", {"unreachable": 1.0}),
}
"""The environment of each task, and its keywords."""
VARIANTS = ("plain", "moved", "symmetric", "mirrored")
"""The office as it is; turned and shifted; as it is, with a symmetric fan; mirrored, with it."""
SYMMETRIC = LaserSpec(first_angle=math.radians(-89.75))
"""The default laser with a fan that looks the same in a mirror."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What is run."""

    task: str
    """One of ``TASKS``."""
    office: int
    """Number of the office."""
    seed: int
    """Of the episode."""
    odometry: str
    """Name of a level."""
    difficulty: str
    """Of the office."""
    variant: str
    """One of ``VARIANTS``."""

    @property
    def name(self) -> str:
        """Of its picture."""
        plain = f"{self.task}_{self.office}_{self.seed}"
        return plain if self.variant == "plain" else f"{plain}_{self.variant}"

    def plan(self) -> FloorPlan:
        """The office."""
        plan = FloorPlan.load(f"office:{self.office}:{self.difficulty}")
        if self.variant == "moved":
            return moved(plan, drawn_motion(np.random.default_rng(self.office)))
        return mirrored(plan) if self.variant == "mirrored" else plan

    def env(self) -> gym.Env[Any, Any]:
        """The environment."""
        env_id, keywords = TASKS[self.task]
        laser = SYMMETRIC if self.variant in ("symmetric", "mirrored") else None
        return gym.make(env_id, map=self.plan(), odometry=self.odometry, laser=laser, **keywords)


class _TimedAgent(CogMapAgent):
    """The robot, with a clock of CPU time."""

    seconds = 0.0

    def act(self, observation: Observation) -> NDArray[np.float32]:
        begun = time.process_time()
        action = super().act(observation)
        self.seconds = time.process_time() - begun
        return action


class Recorder:
    """Keeps what was true and what was believed at each step."""

    def __init__(self) -> None:
        """With nothing recorded yet."""
        self.moments: list[Moment] = []

    def __call__(
        self,
        _step: int,
        observation: Observation,
        action: NDArray[np.float32],
        info: dict[str, Any],
        agent: Any,
    ) -> None:
        """Add a step."""
        memory = agent.memory
        stay, pose = memory.stay, memory.pose
        self.moments.append(
            Moment(
                phase=info["phase"],
                pose=info["pose"],
                coverage=info["coverage"],
                mark=int(observation["mark"]),
                declared=bool(action[2] > DECLARED),
                status=memory.status,
                seconds=agent.seconds,
                believed=np.array((pose.x, pose.y, pose.theta)),
                place=stay.place,
                known=stay.known,
                entry=stay.entry,
                came_from=stay.came_from,
                began=stay.began,
                places=len(memory.network.asrs),
            )
        )


def run_trial(trial: Trial, failures: Path | None = None, pictures: int = 0) -> dict[str, Any]:
    """One episode, scored; an episode that breaks down is a row too.

    Args:
        trial: what to run.
        failures: folder for a picture of a failed run.
        pictures: how many pictures the folder may hold.
    """
    agent, recorder = _TimedAgent(), Recorder()
    try:
        env = trial.env()
        episode = run_episode(env, agent, trial.seed, recorder)
    except Exception as error:  # noqa: BLE001 - a rate counts every run
        why = f"raised {error!r}"
        return {**asdict(trial), "success": False, "why": why, "raised": repr(error)}
    world: Any = env.unwrapped
    record = OfficeRecord(
        plan=world.plan,
        moments=recorder.moments,
        outcomes=_outcomes(episode, world.task.mark_rooms, recorder.moments),
        coverage=float(episode.info["coverage"]),
        boundaries={asr.id: asr.boundary for asr in agent.memory.network.asrs},
    )
    row = {**asdict(trial), **office_score(record, exploring=trial.task == "explore")}
    if failures is not None and not row["success"]:
        failures.mkdir(parents=True, exist_ok=True)
        if len(list(failures.glob("*.png"))) < pictures:
            title = f"{trial.name}: {row['why']}"
            figure = _figure(record, agent, world.task.marks, title)
            save_png(figure, failures / f"{trial.name}.png")
    return row


def _outcomes(episode: Episode, rooms: Any, moments: list[Moment]) -> list[Outcome]:
    """How the phases with a goal came out."""
    info, given = episode.info, {moment.mark for moment in moments}
    begun = {moment.phase for moment in moments}
    found = []
    for phase, result in enumerate(episode.phases):
        if result["task"] == "explore":
            continue
        mark = HOME if result["task"] == "home" else int(result["task"].partition(":")[2])
        was_given = mark in given and phase in begun
        found.append(
            Outcome(
                phase=phase,
                mark=mark,
                room=rooms.get(mark, "home"),
                success=result["success"],
                reachable=not was_given or result["oracle_length"] >= 0.0,
                distance=float(info["final_distance"][mark]) if was_given else -1.0,
                spl=float(info["spl"][mark]),
                spl_learning=float(info["spl_learning"][mark]),
            )
        )
    return found


def _figure(record: OfficeRecord, agent: CogMapAgent, marks: Any, title: str) -> Figure:
    """The truth beside the belief."""
    missed = next((o for o in record.outcomes if not o.success and o.distance >= 0.0), None)
    mark, phase = (0, -1) if missed is None else (missed.mark, missed.phase)
    way = record.poses[[k for k, m in enumerate(record.moments) if m.phase == phase], :2]
    return failure_figure(
        record.plan, record.poses, agent.sketch(), agent.memory.path[:, :2], marks, title, mark, way
    )
