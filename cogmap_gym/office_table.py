"""Tables of issue 3 from the rows of many episodes in offices."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from cogmap_gym.office_comparison import comparisons
from cogmap_gym.reentries import MISSED, NEW, REENTRIES, SPLIT, WRONG
from cogmap_gym.table_lines import HEAD, mean_line, rate_line, value_line

Row = Mapping[str, Any]
"""What ``cogmap_gym.office_scores.office_score`` returns, with task, office, seed, odometry,
difficulty and variant."""

_BROKEN = {"success": False, "kind": "raised", "given": False}
"""The goals of a run that broke down count as one that was missed."""


def offices_table(rows: Iterable[Row], rng: np.random.Generator) -> str:
    """Markdown tables of all rows: a section for each variant, level and difficulty.

    Args:
        rows: a row an episode.
        rng: draws offices again for the intervals of means.
    """
    ordered = sorted(rows, key=lambda row: (*_group(row), row["task"], row["office"], row["seed"]))
    groups = [(key, list(group)) for key, group in groupby(ordered, _group)]
    return "\n".join([*(_section(k, g, rng) for k, g in groups), *comparisons(ordered)])


def _group(row: Row) -> tuple[bool, str, str, str]:
    """The plain offices come first."""
    variant = row["variant"]
    return variant != "plain", variant, row["odometry"], row["difficulty"]


def _section(key: tuple[bool, str, str, str], rows: Sequence[Row], rng: np.random.Generator) -> str:
    _, variant, odometry, difficulty = key
    offices = len({row["office"] for row in rows})
    title = (
        f"## {difficulty} offices, {odometry} odometry, {variant}: {len(rows)} runs in {offices}"
    )
    by_task = {task: list(group) for task, group in groupby(rows, lambda row: row["task"])}
    scored = [row for row in rows if "raised" not in row]
    lines = [
        *_explore(by_task.get("explore", ())),
        *_successes("home: within 1.0 m of home", by_task.get("home", ()), ">= 92%"),
        *_goals("goto", by_task.get("goto", ()), ">= 88%"),
        *_goals("shortcut", by_task.get("shortcut", ()), ">= 80%"),
        *_paths(by_task.get("shortcut", ()), rng),
        *_no_route(scored),
        *_merges(scored),
        *_boundaries(scored),
        *_crossings(scored),
        *_cost(scored),
    ]
    return f"{title}\n\n{HEAD}{''.join(lines)}\n{_failures(rows)}\n{_faults(scored)}"


def _successes(text: str, rows: Sequence[Row], asked: str) -> list[str]:
    return [rate_line(text, sum(row["success"] for row in rows), len(rows), asked)] if rows else []


def _explore(rows: Sequence[Row]) -> list[str]:
    lines = _successes("explore: 95 % of the free area seen in time", rows, ">= 90%")
    for share in ("80%", "90%", "95%") if rows else ():
        taken = [row.get(f"moves_{share}") for row in rows]
        reached = [moves for moves in taken if moves is not None]
        seen = f"{np.median(reached):.0f} ({len(reached)} of {len(taken)} runs)" if reached else "-"
        lines.append(value_line(f"explore: moves to {share}, median of runs that got there", seen))
    return lines


def _goals(task: str, rows: Sequence[Row], asked: str) -> list[str]:
    if not rows:
        return []
    goals = _goals_of(rows)
    lines = [rate_line(f"{task}: goals met", sum(g["success"] for g in goals), len(goals), asked)]
    kinds = Counter(goal["kind"] for goal in goals if goal["kind"])
    return lines + [
        rate_line(f"{task}: failed, {kind}", count, len(goals))
        for kind, count in kinds.most_common()
    ]


def _goals_of(rows: Iterable[Row]) -> list[Mapping[str, Any]]:
    return [goal for row in rows for goal in row.get("goals", (_BROKEN,))]


def _paths(rows: Sequence[Row], rng: np.random.Generator) -> list[str]:
    by_office: dict[int, list[float]] = {}
    for row in rows:
        shares = [goal["spl_learning"] for goal in row.get("goals", ()) if goal["success"]]
        by_office.setdefault(row["office"], []).extend(s for s in shares if s >= 0.0)
    text = "shortcut: mean SPL of goals met, against the learning walk"
    return [mean_line(text, list(by_office.values()), ">= 0.70", rng)] if rows else []


def _no_route(rows: Sequence[Row]) -> list[str]:
    asked = [goal for goal in _goals_of(rows) if goal["given"]]
    gone = [goal for goal in asked if not goal["reachable"]]
    told = [row for row in rows if row["task"] in ("goto", "shortcut")]
    there = [goal for goal in _goals_of(told) if goal["given"] and goal["reachable"]]
    lines = [("unreachable goals: said no route", gone, ">= 95%")] if gone else []
    lines += [("goto, shortcut: no route said of a reachable goal", there, "<= 3%")]
    return [rate_line(t, sum(g["no_route"] for g in some), len(some), a) for t, some, a in lines]


def _merges(rows: Sequence[Row]) -> list[str]:
    count: Counter[str] = Counter()
    for row in rows:
        count.update(row["entries"])
    again = sum(count[verdict] for verdict in REENTRIES)
    return [
        rate_line("re-entries by an unlinked exit: wrong merges", count[WRONG], again, "<= 2%"),
        rate_line("re-entries by an unlinked exit: missed", count[MISSED], again, "<= 5%"),
        value_line("rooms found new, as such", str(count[NEW])),
        value_line("rooms cut in two by an exit that is none", str(count[SPLIT])),
    ]


def _boundaries(rows: Sequence[Row]) -> list[str]:
    asrs, closed = (sum(row[key] for row in rows) for key in ("asrs", "closed"))
    ious = [iou for row in rows for iou in row["ious"]]
    middle, low = (f"{np.quantile(ious, q):.3f}" if ious else "-" for q in (0.5, 0.1))
    return [
        rate_line("ASR boundaries closed in the end", closed, asrs, ">= 90%"),
        value_line("IoU with the true room, median", middle, ">= 0.80"),
        value_line("IoU, tenth percentile", low),
    ]


def _crossings(rows: Sequence[Row]) -> list[str]:
    true, seen, false = (
        sum(row[key] for row in rows) for key in ("crossings", "noticed", "false_crossings")
    )
    a_run = f"{false / len(rows):.2f}" if rows else "-"
    return [
        rate_line("door crossings noticed", seen, true),
        value_line("false crossings a run", a_run),
    ]


def _cost(rows: Sequence[Row]) -> list[str]:
    """CPU times of a step: medians over the runs of each run's own figure."""
    if not rows:
        return []
    middle, high = (np.median([row[key] for row in rows]) for key in ("median_ms", "p95_ms"))
    lines = [value_line("CPU a step, median; 95 of 100 [ms]", f"{middle:.1f}; {high:.1f}", "< 10")]
    bins: dict[str, list[tuple[float, int]]] = {}
    for row in rows:
        for name, (median, steps) in row["ms_by_places"].items():
            bins.setdefault(name, []).append((median, steps))
    for name, taken in sorted(bins.items(), key=lambda item: int(item[0].split()[0])):
        seen = f"{np.median([t for t, _ in taken]):.1f} ({sum(n for _, n in taken)} steps)"
        lines.append(value_line(f"CPU a step with {name} ASRs, median [ms]", seen))
    return lines


def _failures(rows: Sequence[Row]) -> str:
    lines = [f"- {_name(row)}: {row['why']}" for row in rows if not row["success"]]
    return "Failures by run:\n\n" + "\n".join(lines or ["- none"]) + "\n"


def _faults(rows: Sequence[Row]) -> str:
    lines = [f"- {_name(row)}: {'; '.join(row['faults'])}" for row in rows if row["faults"]]
    lines += [
        f"- {_name(row)}: not noticed {', '.join(row['missed_at'])}"
        for row in rows
        if row["missed_at"]
    ]
    lines += [f"- {_name(row)}: false crossings at {row['false_at']}" for row in rows
              if row["false_at"]]  # fmt: skip
    return "Faults of the map by run:\n\n" + "\n".join(lines or ["- none"]) + "\n"


def _name(row: Row) -> str:
    return f"{row['task']}, office {row['office']}, seed {row['seed']}"
