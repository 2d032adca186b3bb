"""Run an experiment of the thesis and show what came of it, in numbers and pictures.

Usage: python scripts/experiment.py N --seed S --out DIR [--odometry LEVEL] [--literal]
Writes DIR/result.json and pictures, each as soon as there is something to write.
"""

from __future__ import annotations

import dataclasses
import json
import signal
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import numpy as np
import typer
from matplotlib.figure import Figure
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

import cogmap_gym  # noqa: F401 - registers the environments
import cogmap_gym.experiment_figures as fig
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.params import Params
from agents.rollout import run_episode
from cogmap_gym.geometry import Pose
from cogmap_gym.saving import save_png, write_whole
from cogmap_gym.thesis_tasks import PHASES


class Report:
    """Follows an episode and writes down what there is to report, as it comes.

    Landmarks are those of step ``chosen``, or else of the first after the loop was closed.
    """

    def __init__(
        self, env: Any, agent: CogMapAgent, head: dict[str, Any], out: Path, chosen: int | None
    ) -> None:
        self.env, self.agent, self.head, self.out, self.chosen = env, agent, head, out, chosen
        columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
        self.progress = Progress(*columns)
        self.bar = self.progress.add_task("setting up")
        self.phases: list[dict[str, Any]] = []
        self.pictures: dict[str, Path] = {}
        self.true_path: list[Any] = []
        self.last, self.begun, self.interrupted = agent.memory, 0, False

    def on_step(self, step: int, seen: Any, _action: Any, info: dict[str, Any], _: Any) -> None:
        """Called after each decision of the robot."""
        if self.interrupted:
            raise KeyboardInterrupt
        self.true_path.append(info["pose"][:2])
        self.end_phases()
        now, plan, k = self.agent.memory, PHASES[self.head["experiment"]], info["phase"]
        said = f"phase {k + 1} of {len(plan)}: {plan[k].task}, step {step}"
        self.progress.update(self.bar, description=said)
        for asr in now.network.asrs:
            old = self.last.network.asr(asr.id)
            if old is None or (asr.closed and not old.closed):
                path, own = now.path[self.last.stay.began :, :2], set(asr.surfaces.tolist())
                shape = asr.id, own, asr.corners, asr.large, path
                self.save(f"asr{asr.id}", fig.asr_figure(self.agent.sketch(), *shape))
        if self.chosen is None and now.stay.known and not self.last.stay.known:
            self.chosen = step + 1
        elif self.chosen == step:
            self.save("landmarks", fig.landmarks_figure(self.views(seen["odometry"])))
        self.last = now

    def views(self, odometry: Any) -> fig.TwoViews:
        """The last view, this one, and its landmarks, in the robot's present frame."""
        last, now = self.last.mapping, self.agent.memory.mapping
        before = Pose(*map(float, odometry)).inverse().apply(last.view.surfaces)
        rows, seen = np.unique(now.pairs[:, 1]), now.view.surfaces
        landmarks = now.mfis_from_robot.inverse().apply(now.mfis.surfaces[rows])
        return fig.TwoViews(now.step, before, last.ids, seen, now.ids, landmarks, rows + 1)

    def end_phases(self) -> None:
        """Report the phases that are over and not yet reported."""
        path = self.agent.memory.path[:, :2]
        for result in self.env.task.results[len(self.phases) :]:
            sketch, row = self.agent.sketch(), dataclasses.asdict(result)
            counts = {"asrs": len(sketch["asrs"]), "exits": len(sketch["exits"])}
            self.phases.append(row | counts | {"links": sketch["links"]})
            self.write()
            ended = len(self.phases), self.phases[-1], sketch, path[self.begun :]
            for item in fig.phase_figures(*ended).items():
                self.save(*item)
            self.begun = len(path) - 1

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

    def interrupt(self, *_: Any) -> None:
        """Ctrl-C ends the run after this step; a second one ends all at once."""
        if self.interrupted:
            raise KeyboardInterrupt
        self.interrupted = True

    def save(self, name: str, figure: Figure) -> None:
        """Write a picture."""
        self.pictures[name] = save_png(figure, self.out / f"{name}.png")


def main(
    experiment: Annotated[int, typer.Argument(min=1, max=len(PHASES), help="which one")],
    out: Annotated[Path, typer.Option(file_okay=False, help="folder to write to")],
    seed: Annotated[int, typer.Option(min=0, help="of the noise")] = 0,
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high or severe")] = "medium",
    map_: Annotated[str, typer.Option("--map", help="plan, by name or path")] = "thesis_office",
    step: Annotated[int | None, typer.Option(min=1, help="whose landmarks to draw")] = None,
    literal: Annotated[bool, typer.Option("--literal", help="the text as written")] = False,
) -> None:
    """Run an experiment of the thesis; Ctrl-C leaves what was done so far."""
    try:
        params = Params.literal() if literal else Params()
        env = gym.make("CogMap/Thesis-v0", experiment=experiment, odometry=odometry, map=map_)
    except (AttributeError, ValueError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    agent = CogMapAgent(params)
    out.mkdir(parents=True, exist_ok=True)
    report = Report(env.unwrapped, agent, {"experiment": experiment, "seed": seed}, out, step)
    signal.signal(signal.SIGINT, report.interrupt)
    with report.progress:
        try:
            run_episode(env, agent, seed, report.on_step)
        except KeyboardInterrupt:
            report.progress.print("interrupted: what was done so far is kept")
        report.finish()
    print(*(out / "result.json", *report.pictures.values()), sep="\n")
    if report.interrupted:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
