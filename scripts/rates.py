"""How often the robot does what issues 2 and 3 ask: runs many episodes, and makes the tables.

Usage: python scripts/rates.py --experiment 3 --odometry medium --seeds 0:50 --out DIR

Writes DIR/runs.jsonl, a row a run, DIR/rates.md, and a picture of each failed run under
DIR/failures. Runs that stand in DIR/runs.jsonl are not done again.
Choose parameters on seeds >= 1000; seeds 0:50 are for the report.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import track

from agents.cogmap.params import Params
from agents.trials import Trial, read_rows, run_missing, seeds_of
from cogmap_gym.saving import write_whole
from cogmap_gym.score_table import rates_table


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for rows and table")],
    experiment: Annotated[int, typer.Option(min=1, max=3)] = 1,
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    seeds: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "1000:1010",
    literal: Annotated[bool, typer.Option(help="the text of the thesis as written")] = False,
    failures: Annotated[int, typer.Option(min=0, help="most pictures of failed runs")] = 20,
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run the experiment on these seeds, and write the table of all rows in the folder."""
    path, pictures = out / "runs.jsonl", out / "failures" if failures else None
    params, label = Params.literal() if literal else Params(), {"literal": literal}
    rest = params, label, pictures, failures
    try:
        trials = [Trial(experiment, odometry, seed, *rest) for seed in seeds_of(seeds)]
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    out.mkdir(parents=True, exist_ok=True)
    complete = run_missing(trials, workers, path, lambda rows, n: track(rows, "episodes", n))
    table = rates_table(read_rows(path))
    write_whole(out / "rates.md", table.encode())
    print(f"{table}\n{path}\n{out / 'rates.md'}")
    if not complete:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
