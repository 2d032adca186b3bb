"""How the robot does in offices never seen before: runs many episodes, and makes the tables.

Usage: python scripts/office_rates.py --tasks explore,home,goto,shortcut,noroute
           --offices 1000:1004 --seeds 0:5 --odometry medium --out DIR

Writes DIR/runs.jsonl, a row a run, DIR/offices.md, and pictures of failed runs under
DIR/failures. Runs that stand there are not done again. Choose parameters on offices >= 1000;
offices 0:1000 are for the report. --moved runs each office turned and shifted, too; --mirrored
runs each as it is and in a mirror, with a laser whose fan is symmetric.
"""

from __future__ import annotations

import json
import multiprocessing
import signal
from dataclasses import asdict
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.progress import track

from agents.office_trials import TASKS, Trial, run_trial
from cogmap_gym import FloorPlan, OdometrySpec
from cogmap_gym.office_table import offices_table


def read_rows(path: Path) -> list[dict[str, Any]]:
    """The rows written so far; a last line that was cut short does not count."""
    text = path.read_text() if path.exists() else ""
    return [json.loads(line) for line in text.splitlines() if line.endswith("}")]


def run_all(trials: list[Trial], workers: int, out: Path, pictures: int) -> bool:
    """Run the trials and append a row of each as it comes in; False if Ctrl-C ended it."""
    ignore = (signal.SIGINT, signal.SIG_IGN)  # this process takes Ctrl-C and stops the workers
    run = partial(run_trial, failures=out / "failures", pictures=pictures)
    with multiprocessing.get_context("spawn").Pool(workers, signal.signal, ignore) as pool:
        try:
            for row in track(pool.imap_unordered(run, trials), "episodes", total=len(trials)):
                with (out / "runs.jsonl").open("a") as file:
                    file.write(f"\n{json.dumps(row)}")
        except KeyboardInterrupt:
            return False
    return True


def numbers(text: str, option: str) -> range:
    """The numbers that FIRST:LAST stands for."""
    first, _, last = text.partition(":")
    if not (first.isdigit() and last.isdigit()):
        raise typer.BadParameter(f"{option}: expected FIRST:LAST, got {text!r}")
    return range(int(first), int(last))


def wanted(
    tasks: str, offices: str, seeds: str, kinds: tuple[str, str], variants: list[str]
) -> list[Trial]:
    """All trials asked for, in order."""
    names = tasks.split(",")
    if unknown := set(names) - set(TASKS):
        raise typer.BadParameter(f"tasks: expected some of {list(TASKS)}, got {sorted(unknown)}")
    try:
        OdometrySpec.of(kinds[0])
        FloorPlan.load(f"office:1000:{kinds[1]}")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    every = product(numbers(offices, "offices"), numbers(seeds, "seeds"), names, variants)
    return [Trial(task, office, seed, *kinds, variant) for office, seed, task, variant in every]


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for rows, table, pictures")],
    tasks: Annotated[str, typer.Option(help="some of " + ",".join(TASKS))] = "explore,home",
    offices: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "1000:1004",
    seeds: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "0:5",
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    difficulty: Annotated[str, typer.Option(help="easy, medium, hard")] = "medium",
    moved: Annotated[bool, typer.Option(help="each office turned and shifted, too")] = False,
    mirrored: Annotated[bool, typer.Option(help="a symmetric fan, plain and mirrored")] = False,
    pictures: Annotated[int, typer.Option(min=0, help="most pictures of failed runs")] = 20,
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run the tasks in these offices, and write the table of all rows in the folder."""
    variants = ["plain", "moved"] if moved else [] if mirrored else ["plain"]
    variants += ["symmetric", "mirrored"] if mirrored else []
    trials = wanted(tasks, offices, seeds, (odometry, difficulty), variants)
    out.mkdir(parents=True, exist_ok=True)
    done = {tuple(row[key] for key in Trial.__slots__) for row in read_rows(out / "runs.jsonl")}
    todo = [trial for trial in trials if tuple(asdict(trial).values()) not in done]
    complete = run_all(todo, workers, out, pictures)
    table = offices_table(read_rows(out / "runs.jsonl"), np.random.default_rng(0))
    (out / "offices.md").write_text(table)
    print(f"{table}\n{out / 'runs.jsonl'}\n{out / 'offices.md'}")
    if not complete:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
