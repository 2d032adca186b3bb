"""What an experiment leaves behind: numbers and pictures, each as soon as it can be made."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from agents.cogmap.agent import CogMapAgent
from agents.cogmap.options import NEW, newly_chosen, weighed
from cogmap_gym import experiment_figures as fig
from cogmap_gym import journey_figures as journey
from cogmap_gym.env import CogMapEnv
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.saving import save_png, write_whole


class Report:
    """Follows an episode of the thesis robot and writes down what there is to report.

    Args:
        env: runs an experiment of the thesis.
        agent: the robot in it.
        head: what ``result.json`` begins with, ``experiment`` and ``seed`` among it.
        out: folder to write to.
        chosen: at which step to draw the landmarks; None: the first after the loop was closed.
    """

    def __init__(
        self, env: CogMapEnv, agent: CogMapAgent, head: dict[str, Any], out: Path,
        chosen: int | None = None,
    ) -> None:  # fmt: skip
        """Nothing has happened yet."""
        self.env, self.agent, self.head, self.out, self.chosen = env, agent, head, out, chosen
        self.phases: list[dict[str, Any]] = []
        self.pictures: dict[str, Path] = {}
        self.true_path: list[Points] = []
        self.last, self.begun, self.interrupted = agent.memory, 0, False
        self._begin_phase()

    def _begin_phase(self) -> None:
        self.goal, self.planned = 0, journey.NO_POINTS
        self.new_exits: list[int] = []
        self._solids: dict[str, tuple[float, Points]] = {}

    @property
    def solids(self) -> fig.Solids:
        """What stood in the way to the goal, (2, 2) each, laid where the robot was nearest."""
        return {name: line for name, (_, line) in self._solids.items()} if self.goal else {}

    def on_step(self, step: int, observation: Any, info: dict[str, Any]) -> None:
        """Called after each decision of the robot, with the truth at that moment."""
        self.true_path.append(info["pose"][:2])
        self.end_phases()
        self._follow_asrs()
        self._follow_goal(int(observation["goal"]), Pose(*map(float, info["pose"])))
        now = self.agent.memory
        if self.chosen is None and now.stay.known and not self.last.stay.known:
            self.chosen = step + 1
        elif self.chosen == step:
            self.save("landmarks", fig.landmarks_figure(self._views(observation["odometry"])))
        self.last = now

    def _follow_asrs(self) -> None:
        """Draw each ASR that was cut, or whose boundary closed, in this step."""
        now = self.agent.memory
        for asr in now.network.asrs:
            old = self.last.network.asr(asr.id)
            if old is None or (asr.closed and not old.closed):
                path, own = now.path[self.last.stay.began :, :2], set(asr.surfaces.tolist())
                shape = asr.id, own, asr.corners, asr.large, path
                self.save(f"asr{asr.id}", fig.asr_figure(self.agent.sketch(), *shape))

    def _follow_goal(self, goal: int, plan_from_robot: Pose) -> None:
        """Note what is planned and what stands in the way; draw the choice of a new exit."""
        self.goal, memory = goal, self.agent.memory
        world = self.env.world
        shut = world.present_barriers | (world.shut_doors - set(self.env.plan.closed))
        mfis_from_plan = memory.pose @ plan_from_robot.inverse()
        for name in sorted(shut):
            line = world.segment(name)[0]
            gap = float(np.hypot(*(line.mean(axis=0) - plan_from_robot.position)))
            if name not in self._solids or gap < self._solids[name][0]:
                self._solids[name] = gap, mfis_from_plan.apply(line)
        if goal and not len(self.planned):
            known = [way.points for way in weighed(memory, self.agent.params) if way.kind != NEW]
            self.planned = known[0] if known else journey.NO_POINTS
        new = newly_chosen(memory) if goal else 0
        if new and new not in self.new_exits:
            self.new_exits.append(new)
            self._save_choice(new)

    def _save_choice(self, new: int) -> None:
        number = len(self.phases) + 1
        options = [
            journey.Option(way.kind, way.exits, way.points, way.length)
            for way in weighed(self.agent.memory, self.agent.params)
        ]
        title = f"Phase {number}, to mark {self.goal}: choosing exit {new}"
        told = self.agent.sketch(), options, new, title, self.goal, self.solids
        name = f"phase{number}_choice{len(self.new_exits)}"
        self.save(name, journey.options_figure(*told))

    def _views(self, odometry: NDArray[np.float32]) -> fig.TwoViews:
        """The last view, this one, and its landmarks, in the robot's present frame."""
        last, now = self.last.mapping, self.agent.memory.mapping
        before = Pose(*map(float, odometry)).inverse().apply(last.view.surfaces)
        rows, seen = np.unique(now.pairs[:, 1]), now.view.surfaces
        landmarks = now.mfis_from_robot.inverse().apply(now.mfis.surfaces[rows])
        ids = now.mfis.ids[rows].tolist()
        return fig.TwoViews(
            now.step, before, last.ids.tolist(), seen, now.ids.tolist(), landmarks, ids
        )

    def end_phases(self) -> None:
        """Report the phases that are over and not yet reported."""
        path = self.agent.memory.path[:, :2]
        for result in self.env.task.results[len(self.phases) :]:
            sketch, row = self.agent.sketch(), dataclasses.asdict(result)
            counts = {"asrs": len(sketch["asrs"]), "exits": len(sketch["exits"])}
            self.phases.append(row | counts | {"links": sketch["links"]})
            self.write()
            ended = len(self.phases), self.phases[-1], sketch, path[self.begun :]
            way = self.goal, self.planned, self.solids
            for name, figure in journey.phase_figures(*ended, *way).items():
                self.save(name, figure)
            self.begun = len(path) - 1
            self._begin_phase()

    def finish(self) -> None:
        """Write what is known at the end, or when interrupted."""
        self.end_phases()
        self.write()
        if self.true_path:
            truth, home = np.array(self.true_path), self.env.task.marks[1]
            title = "Experiment {experiment}, seed {seed}".format(**self.head)
            belief = self.agent.sketch(), self.agent.memory.path[:, :2], home, title
            figure = fig.overview_figure(self.env.plan, truth, *belief, self.env.world.shut_doors)
            self.save("overview", figure)

    def write(self) -> None:
        """Write ``result.json``."""
        note = {"interrupted": True} if self.interrupted else {}
        text = json.dumps({**self.head, "phases": self.phases, **note}, indent=1)
        write_whole(self.out / "result.json", text.encode())

    def save(self, name: str, figure: Figure) -> None:
        """Write a picture."""
        self.pictures[name] = save_png(figure, self.out / f"{name}.png")
