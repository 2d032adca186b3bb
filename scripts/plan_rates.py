"""How the robot does on floor plans of your own: out within the budget, then home.

Usage: python scripts/plan_rates.py PLAN [PLAN ...] --seeds 0:10 --out DIR

A plan is what ``gym.make`` takes as ``map``; a mapping is given as JSON, such as
'{"image": "plan.png", "metres_per_pixel": 0.05}'. A run comes out well if the robot has seen 70 %
of the area that can be reached, and then ends within 1 m of home. Writes DIR/runs.jsonl, a row a
run, DIR/plans.md, and pictures of failed runs under DIR/failures. Runs that stand there are not
done again.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Annotated, Any

import typer
from joblib import Parallel, delayed
from rich.progress import track

from agents.plan_trials import PlanTrial, run_plan_trial
from agents.trials import read_rows, seeds_of
from cogmap_gym import FloorPlan, OdometrySpec
from cogmap_gym.table_lines import HEAD, rate_line, value_line

LARGE_M = 60.0
"""Plans longer than this are told apart [m]."""


def table(rows: Sequence[dict[str, Any]]) -> str:
    """All rates as a Markdown table, and the failures."""
    rows = sorted(rows, key=lambda row: (row["plan"], row["seed"]))
    small = [row for row in rows if row["size"] <= LARGE_M]
    large = [row for row in rows if row["size"] > LARGE_M]
    lines = [HEAD]
    for text, some, asked in (("up to", small, ">= 80%"), ("over", large, "")):
        if some:
            good = sum(row["success"] for row in some)
            lines.append(rate_line(f"plans {text} 60 m: out and home", good, len(some), asked))
    for plan, group in groupby(rows, key=lambda row: row["plan"]):
        runs = list(group)
        name, seen = Path(plan).name, sorted(row.get("coverage", 0.0) for row in runs)
        good, home = sum(r["success"] for r in runs), sum(r.get("home", False) for r in runs)
        lines.append(rate_line(f"{name} ({runs[0]['size']:.0f} m): out and home", good, len(runs)))
        lines.append(rate_line(f"{name}: home", home, len(runs)))
        lines.append(value_line(f"{name}: seen, median", f"{seen[len(seen) // 2]:.1%}"))
    failed = [f"- {Path(r['plan']).name}, seed {r['seed']}: {r['why']}" for r in rows if r["why"]]
    return "".join(lines) + "\nFailures by run:\n\n" + "\n".join(failed or ["- none"]) + "\n"


def main(
    plans: Annotated[list[str], typer.Argument(help="plans in any format, or office:SEED")],
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for rows, table, pictures")],
    seeds: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "0:10",
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run the robot on these plans, and write the table of all rows in the folder."""
    try:
        OdometrySpec.of(odometry)
        trials = [PlanTrial(plan, k, odometry) for plan in plans for k in seeds_of(seeds)]
        for trial in trials[:: max(len(trials) // len(plans), 1)]:
            FloorPlan.load(trial.map)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    out.mkdir(parents=True, exist_ok=True)
    path = out / "runs.jsonl"
    done = {(row["plan"], row["seed"], row["odometry"]) for row in read_rows(path)}
    todo = [t for t in trials if (t.plan, t.seed, t.odometry) not in done]
    run = delayed(partial(run_plan_trial, failures=out / "failures"))
    jobs = Parallel(n_jobs=workers, return_as="generator_unordered")(run(t) for t in todo)
    for row in track(jobs, "episodes", total=len(todo)):
        with path.open("a") as file:
            file.write(f"\n{json.dumps(row)}")
    told = table(read_rows(path))
    (out / "plans.md").write_text(told)
    print(f"{told}\n{path}\n{out / 'plans.md'}")


if __name__ == "__main__":
    typer.run(main)
