"""What each repair is worth: the thesis's text, each repair added, each taken out again.

Usage: python scripts/ablation.py --seeds 1000:1005 --odometry medium --out DIR

Writes DIR/runs.jsonl, a row a run, DIR/ablation.md and DIR/ablation.png, over all three
experiments. Runs that stand in DIR/runs.jsonl with the same parameters are not done again.
Choose parameters on seeds >= 1000; seeds 0:50 are for the report.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import track

from agents.ablation import Variant, ladder, left_out
from agents.trials import Trial, read_rows, run_missing, seeds_of
from cogmap_gym.ablation_report import ablation_figure, ablation_table
from cogmap_gym.saving import save_png, write_whole
from cogmap_gym.thesis_tasks import EXPERIMENTS

SECTIONS = {
    "Each repair added to those above it": ladder(),
    "The default with one repair taken out": left_out(),
}


def trials_of(
    variants: Iterable[Variant], experiments: Iterable[int], odometry: str, seeds: range
) -> list[Trial]:
    """Every parameter set once in every experiment on every seed, seed by seed."""
    distinct = {variant.key: variant.params for variant in variants}
    return [
        Trial(experiment, odometry, seed, params, {"params": key})
        for seed in seeds
        for key, params in distinct.items()
        for experiment in experiments
    ]


def report(out: Path, odometry: str) -> None:
    """Write the table and the figure of all rows at this level in the folder; print both paths."""
    rows = [row for row in read_rows(out / "runs.jsonl") if row["odometry"] == odometry]
    named = {title: [(v.name, v.key) for v in some] for title, some in SECTIONS.items()}
    table = ablation_table(rows, named)
    write_whole(out / "ablation.md", table.encode())
    title = f"Runs of experiments 1 to 3 that came out well, {odometry} odometry"
    save_png(ablation_figure(rows, named, title), out / "ablation.png")
    print(table, *(out / name for name in ("runs.jsonl", "ablation.md", "ablation.png")), sep="\n")


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for rows, table, figure")],
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    seeds: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "1000:1005",
    experiment: Annotated[
        list[int] | None, typer.Option(min=1, max=3, help="one alone; may be repeated")
    ] = None,
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run all parameter sets on these seeds; Ctrl-C leaves the table of what was done."""
    variants = [variant for some in SECTIONS.values() for variant in some]
    try:
        trials = trials_of(variants, experiment or EXPERIMENTS, odometry, seeds_of(seeds))
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    out.mkdir(parents=True, exist_ok=True)
    path = out / "runs.jsonl"
    complete = run_missing(trials, workers, path, lambda rows, n: track(rows, "episodes", n))
    report(out, odometry)
    if not complete:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
