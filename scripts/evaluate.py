"""Robots against each other, on the same trials: a table of results and a page of figures.

Usage: python scripts/evaluate.py --agents cogmap,frontier_slam --tasks explore,home
           --maps thesis_office,office:0,office:1 --odometry medium --seeds 5 --out DIR [--resume]

Writes DIR/results.csv, a row a trial, DIR/report.html with its figures as PNG and PDF, and
DIR/leaderboard.md. Rows are written as they come: after Ctrl-C, or a kill, --resume does only what
is missing; it refuses to put rows of other code or parameters into the same table, unless --mix is
given. --baseline names the robot that the others are compared with on the same trials. --quick is a
small table in a few minutes. --ray ADDRESS runs the trials on a Ray cluster, --ray local on one
started here (the extra `cluster`). Choose parameters on seeds and offices from 1000 up.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from agents.provenance import check_rows
from agents.registry import AGENTS, is_available
from agents.sweep import COLUMNS, KEY, TASKS, Trial, check_trials, possible, trials_of
from agents.trial_row import Row
from agents.workers import run_here, run_on_ray
from cogmap_gym.dynamics import LEVELS
from cogmap_gym.result_file import ResultFile
from cogmap_gym.sweep_files import write_sweep

QUICK = (
    "random_walk,wall_follower,frontier_odometry,cogmap", "explore,home", "two_rooms,office:0",
    "low,high", "off,busy",
)  # fmt: skip
"""Robots, tasks, maps, levels of odometry and of dynamics of --quick."""


def wanted(
    agents: list[str],
    tasks: str,
    maps: str,
    odometry: str,
    seeds: int,
    dynamics: str,
    *,
    where_possible: bool,
) -> list[Trial]:
    """The trials asked for; what cannot be run is told at once."""
    if missing := [name for name in agents if not is_available(name)]:
        raise ValueError(f"agents: not installed: {missing}")
    asked = (words.split(",") for words in (tasks, maps, odometry))
    trials = trials_of(agents, *asked, range(seeds), dynamics.split(","))
    if where_possible:
        trials, reasons = possible(trials)
        print("".join(f"left out: {reason}\n" for reason in reasons), end="")
    check_trials(trials)
    return trials


def opened(out: Path, agents: list[str], *, resume: bool, mix: bool) -> ResultFile:
    """The file of results, new or to go on with."""
    path = out / "results.csv"
    if path.exists() and not resume:
        raise ValueError(f"{path} exists: --resume goes on with it")
    results = ResultFile(path, COLUMNS)
    if not mix:
        check_rows(path, results.rows(), agents)
    return results


def write_rows(rows: Iterable[Row], count: int, results: ResultFile) -> bool:
    """Append each row as it comes; False if Ctrl-C ended it."""
    bars = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress("trials", *bars) as progress:
        bar = progress.add_task("", total=count)
        try:
            for row in rows:
                results.add(row)
                progress.advance(bar)
        except KeyboardInterrupt:
            return False
    return True


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for results and report")],
    agents: Annotated[
        str, typer.Option(help="module:Class, or some of " + ",".join(AGENTS))
    ] = "cogmap",
    tasks: Annotated[str, typer.Option(help="some of " + ",".join(TASKS))] = "explore,home",
    maps: Annotated[str, typer.Option(help="plans, as in gym.make")] = "thesis_office",
    odometry: Annotated[str, typer.Option(help="some levels")] = "medium",
    dynamics: Annotated[str, typer.Option(help="some of " + ",".join(LEVELS))] = "off",
    seeds: Annotated[int, typer.Option(min=1, help="so many, from 0 up")] = 5,
    baseline: Annotated[str | None, typer.Option(help="by default the first robot")] = None,
    resume: Annotated[bool, typer.Option(help="do only what is missing")] = False,
    mix: Annotated[bool, typer.Option(help="with rows of other code or parameters")] = False,
    where_possible: Annotated[
        bool, typer.Option(help="leave a task out on maps that it cannot be set on")
    ] = False,
    quick: Annotated[bool, typer.Option(help="a small table in a few minutes")] = False,
    workers: Annotated[int, typer.Option(min=1, help="processes on this machine")] = 2,
    ray: Annotated[str | None, typer.Option(help="address of a Ray cluster, or local")] = None,
) -> None:
    """Run the trials, and write the table and the page."""
    if quick:
        (agents, tasks, maps, odometry, dynamics), seeds = QUICK, 1
    robots = agents.split(",")
    try:
        if baseline not in (None, *robots):
            raise ValueError(f"baseline: expected one of {robots}, got {baseline!r}")
        trials = wanted(
            robots, tasks, maps, odometry, seeds, dynamics, where_possible=where_possible
        )
        results = opened(out, robots, resume=resume, mix=mix)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    done = results.done(KEY)
    todo = [trial for trial in trials if trial.key not in done]
    rows = run_on_ray(todo, ray, workers) if ray else run_here(todo, workers)
    complete = write_rows(rows, len(todo), results)
    print(results.path, write_sweep(results.rows(), TASKS, baseline or robots[0], out), sep="\n")
    if not complete:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
