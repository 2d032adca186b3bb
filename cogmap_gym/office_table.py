"""Tables of issue 3 from the rows of many episodes in offices."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from cogmap_gym.metrics import wilson

Row = Mapping[str, Any]
"""What ``cogmap_gym.office_scores.office_score`` returns, with task, office, seed, odometry,
difficulty and variant."""
HEAD = "| figure | seen | 95 % interval | asked |\n|---|---|---|---|\n"
RESAMPLES = 2000
"""How often offices are drawn again for the interval of a mean [-]."""


def offices_table(rows: Iterable[Row], rng: np.random.Generator) -> str:
    """Markdown tables of all rows: a section for each level, difficulty and variant.

    Args:
        rows: a row an episode.
        rng: draws offices again for the intervals of means.
    """
    ordered = sorted(rows, key=lambda row: (*_group(row), row["task"], row["office"], row["seed"]))
    return "\n".join(_section(key, list(group), rng) for key, group in groupby(ordered, _group))


def _group(row: Row) -> tuple[str, str, str]:
    return row["variant"], row["odometry"], row["difficulty"]


def _section(key: tuple[str, str, str], rows: Sequence[Row], rng: np.random.Generator) -> str:
    variant, odometry, difficulty = key
    offices = len({row["office"] for row in rows})
    title = (
        f"## {variant}, {odometry} odometry, {difficulty} offices: {len(rows)} runs in {offices}"
    )
    by_task = {t: list(g) for t, g in groupby(rows, lambda row: row["task"])}
    lines: list[str] = []
    for task, least in (("explore", 0.9), ("home", 0.92)):
        mine = by_task.get(task, [])
        lines += [_rate(_ASKED[task], sum(row["success"] for row in mine), len(mine), least)]
    lines += _moves(by_task.get("explore", ()))
    for task, least in (("goto", 0.88), ("shortcut", 0.8)):
        lines += _goals(task, by_task.get(task, ()), least, rng)
    return f"{title}\n\n{HEAD}{''.join(lines)}\n{_failures(rows)}"


_ASKED = {
    "explore": "explore: 95 % of the free area seen",
    "home": "home: within 1.0 m of home",
}


def _goals(task: str, rows: Sequence[Row], least: float, rng: np.random.Generator) -> list[str]:
    goals = [goal for row in rows for goal in row.get("goals", ())]
    lines = [_rate(f"{task}: goals met", sum(g["success"] for g in goals), len(goals), least)]
    kinds = Counter(goal["kind"] for goal in goals if goal["kind"])
    lines += [_rate(f"{task}: failed, {kind}", n, len(goals)) for kind, n in kinds.most_common()]
    if task == "shortcut":
        lines.append(_spl(rows, rng))
    return lines


def _spl(rows: Sequence[Row], rng: np.random.Generator) -> str:
    by_office: dict[int, list[float]] = {}
    for row in rows:
        good = [g["spl_learning"] for g in row.get("goals", ()) if g["success"]]
        by_office.setdefault(row["office"], []).extend(s for s in good if s >= 0.0)
    return mean_line("shortcut: mean SPL of goals met, against the learning walk",
                     by_office, ">= 0.70", rng)  # fmt: skip


def _moves(rows: Sequence[Row]) -> list[str]:
    lines = []
    for share in ("80%", "90%", "95%"):
        taken = [row.get(f"moves_{share}") for row in rows]
        reached = [moves for moves in taken if moves is not None]
        seen = f"{np.median(reached):.0f} ({len(reached)} of {len(taken)} runs)" if reached else "-"
        lines.append(_value(f"explore: moves to {share}, median of runs that got there", seen))
    return lines


def mean_line(
    text: str, by_office: Mapping[int, Sequence[float]], asked: str, rng: np.random.Generator
) -> str:
    """A mean with a bootstrap interval over offices."""
    low, mean, high = bootstrap_mean([v for v in by_office.values() if v], rng)
    seen = "-" if np.isnan(mean) else f"{mean:.3f}"
    return f"| {text} | {seen} | {low:.3f} to {high:.3f} | {asked} |\n"


def bootstrap_mean(
    groups: Sequence[Sequence[float]], rng: np.random.Generator
) -> tuple[float, float, float]:
    """The mean of all values, and the 95 % interval of it when whole groups are drawn again.

    Returns:
        Lower bound, mean, upper bound; NaN without a value.
    """
    if not groups:
        return np.nan, np.nan, np.nan
    sums, counts = (np.array([f(g) for g in groups], dtype=float) for f in (np.sum, len))
    drawn = rng.integers(len(groups), size=(RESAMPLES, len(groups)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return float(low), float(sums.sum() / counts.sum()), float(high)


def _rate(text: str, successes: int, trials: int, least: float | None = None) -> str:
    low, high = wilson(successes, trials)
    seen = f"{successes}/{trials} = {successes / trials:.1%}" if trials else "no trial"
    wanted = "" if least is None else f">= {least:.0%}"
    return f"| {text} | {seen} | {low:.1%} to {high:.1%} | {wanted} |\n"


def _value(text: str, seen: str, asked: str = "") -> str:
    return f"| {text} | {seen} | | {asked} |\n"


def _failures(rows: Sequence[Row]) -> str:
    lines = [
        f"- {row['task']}, office {row['office']}, seed {row['seed']}: {row['why']}"
        for row in rows
        if not row["success"]
    ]
    return "Failures by run:\n\n" + "\n".join(lines or ["- none"]) + "\n"
