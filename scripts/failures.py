"""Why a robot failed trials of a sweep: each failed one is run again, classed by cause, and drawn.

Usage: python scripts/failures.py SWEEP/results.csv --agent cogmap --out DIR [--odometry medium]

Writes DIR/failures.md, counts by task and cause and a line a failure, and of each failed trial a
picture, the truth beside what the robot believed. Goals that a trial met are not told.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from joblib import Parallel, delayed
from rich.progress import track

from agents.failures import CAUSES, Miss, examine
from agents.sweep import COLUMNS, Trial
from cogmap_gym.saving import write_whole


def failed_trials(path: Path, agent: str, odometry: str) -> list[Trial]:
    """The trials of a table that this robot failed, at these levels of odometry, all if empty.

    Raises:
        ValueError: the table does not know the robot, or is none.
    """
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    if missing := set(COLUMNS) - set(rows[0] if rows else ()):
        raise ValueError(f"{path}: expected a table of evaluate.py; it lacks {sorted(missing)}")
    robots = {row["agent"] for row in rows}
    if agent not in robots:
        raise ValueError(f"{path}: agent: expected one of {sorted(robots)}, got {agent!r}")
    levels = odometry.split(",")
    return [
        Trial(agent, row["task"], row["map"], row["odometry"], int(row["seed"]), row["dynamics"])
        for row in rows
        if (row["agent"], row["success"]) == (agent, "0")
        and (not odometry or row["odometry"] in levels)
    ]


def table(misses: Sequence[Miss]) -> str:
    """Counts by task, level and cause as Markdown, then each failure."""
    counts = Counter((m.trial.odometry, m.trial.task, m.cause) for m in misses)
    lines = ["| odometry | task | cause | missed |", "|---|---|---|---|"]
    lines += [f"| {' | '.join(key)} | {count} |" for key, count in sorted(counts.items())]
    lines += ["", *(f"- {cause}: {told}" for cause, told in CAUSES.items()), ""]
    lines += [
        f"- {m.trial.odometry}, {m.trial.task}, {m.trial.map}, seed {m.trial.seed}, "
        f"{f'mark {m.mark}' if m.mark else 'exploring'}: {m.cause}, {m.told}"
        for m in sorted(misses, key=lambda m: (m.trial.key, m.mark))
    ]
    return "\n".join(lines) + "\n"


def main(
    results: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="of a sweep")],
    agent: Annotated[str, typer.Option(help="a robot of the table")],
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for table and pictures")],
    odometry: Annotated[str, typer.Option(help="some levels; all by default")] = "",
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run the failed trials again."""
    try:
        trials = failed_trials(results, agent, odometry)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    run = delayed(partial(examine, folder=out))
    jobs = Parallel(n_jobs=workers, return_as="generator_unordered")(run(t) for t in trials)
    out.mkdir(parents=True, exist_ok=True)
    path, misses = write_whole(out / "failures.md", table(()).encode()), []
    for found in track(jobs, "trials", total=len(trials)):  # After Ctrl-C, what was done stands.
        misses += found
        write_whole(path, table(misses).encode())
    print(table(misses), path, sep="\n")


if __name__ == "__main__":
    typer.run(main)
