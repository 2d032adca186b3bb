"""Run an experiment of the thesis and show what came of it, in numbers, pictures and a film.

Usage: python scripts/experiment.py N --seed S --out DIR [--odometry LEVEL] [--literal]
           [--film PHASES]

Writes DIR/result.json and pictures, each as soon as there is something to write, and with
--film the phases named, as in "5,7", to DIR/film.mp4: the truth beside what the robot believes.
"""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import typer
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.params import Params
from agents.report import Report
from agents.rollout import run_episode
from cogmap_gym.filming import Film
from cogmap_gym.thesis_tasks import PHASES


class Watch:
    """Shows the progress, reports and films, until Ctrl-C."""

    def __init__(self, report: Report) -> None:
        self.report, self.plan = report, PHASES[report.head["experiment"]]
        columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
        self.progress = Progress(*columns)
        self.bar = self.progress.add_task("setting up")

    def on_step(self, step: int, seen: Any, _action: Any, info: dict[str, Any], agent: Any) -> None:
        """Called after each decision of the robot."""
        if self.report.interrupted:
            raise KeyboardInterrupt
        self.report.on_step(step, seen, info)
        self.report.env.set_sketch(agent.sketch())
        k = info["phase"]
        said = f"phase {k + 1} of {len(self.plan)}: {self.plan[k].task}, step {step}"
        self.progress.update(self.bar, description=said)

    def interrupt(self, *_: Any) -> None:
        """Ctrl-C ends the run after this step; a second one ends all at once."""
        if self.report.interrupted:
            raise KeyboardInterrupt
        self.report.interrupted = True


def phases_named(text: str, experiment: int) -> list[int]:
    """The numbers of phases in a text like "5,7".

    Raises:
        ValueError: they are no phases of the experiment.
    """
    count = len(PHASES[experiment])
    numbers = [int(part) if part.strip().isdecimal() else 0 for part in text.split(",")]
    if not all(1 <= number <= count for number in numbers):
        raise ValueError(f"--film: expected phases of 1 to {count}, as in '1,2', got {text!r}")
    return numbers


def main(
    experiment: Annotated[int, typer.Argument(min=1, max=len(PHASES), help="which one")],
    out: Annotated[Path, typer.Option(file_okay=False, help="folder to write to")],
    seed: Annotated[int, typer.Option(min=0, help="of the noise")] = 0,
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high or severe")] = "medium",
    map_: Annotated[str, typer.Option("--map", help="plan, by name or path")] = "thesis_office",
    step: Annotated[int | None, typer.Option(min=1, help="whose landmarks to draw")] = None,
    literal: Annotated[bool, typer.Option("--literal", help="the text as written")] = False,
    film: Annotated[str | None, typer.Option(help="phases to film, as in 5,7")] = None,
) -> None:
    """Run an experiment of the thesis; Ctrl-C leaves what was done so far."""
    try:
        params = Params.literal() if literal else Params()
        filmed = [] if film is None else phases_named(film, experiment)
        env = gym.make(
            "CogMap/Thesis-v0", experiment=experiment, odometry=odometry, map=map_,
            render_mode="rgb_array" if filmed else None,
        )  # fmt: skip
        recorder = Film(env, out, filmed) if filmed else None
    except (AttributeError, ValueError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    agent = CogMapAgent(params)
    out.mkdir(parents=True, exist_ok=True)
    head = {"experiment": experiment, "seed": seed}
    report = Report(env.unwrapped, agent, head, out, step)
    watch = Watch(report)
    signal.signal(signal.SIGINT, watch.interrupt)
    with watch.progress:
        try:
            run_episode(recorder or env, agent, seed, watch.on_step)
        except KeyboardInterrupt:
            watch.progress.print("interrupted: what was done so far is kept")
        watch.progress.update(watch.bar, description="writing what is left")
        report.finish()
        if recorder is not None:
            recorder.close()
    written = [out / "result.json", *report.pictures.values()]
    if recorder is not None and recorder.path.exists():
        written.append(recorder.path)
    print(*written, sep="\n")
    if report.interrupted:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
