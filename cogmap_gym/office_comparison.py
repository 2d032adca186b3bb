"""Whether it matters where a building stands: runs in an office against runs in the same moved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from typing import Any

from cogmap_gym.table_lines import HEAD, rate_line, rate_text

Row = Mapping[str, Any]
_SAME = ("task", "office", "seed", "odometry", "difficulty")
"""What two runs that are compared have in common."""


def comparisons(rows: Iterable[Row]) -> list[str]:
    """Sections on the moved and the mirrored offices, where there are runs of both kinds."""
    rows = list(rows)
    pairs = paired(rows, "plain", "moved")
    sections = [_moved(pairs)] if pairs else []
    here, there = (
        [row for row in rows if row["variant"] == name] for name in ("symmetric", "mirrored")
    )
    return sections + ([_mirrored(here, there)] if here and there else [])


def paired(rows: Iterable[Row], first: str, second: str) -> list[tuple[Row, Row]]:
    """The runs of two variants that are otherwise the same."""
    found: dict[tuple[Any, ...], dict[str, Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in _SAME), {})[row["variant"]] = row
    return [(both[first], both[second]) for both in found.values() if {first, second} <= set(both)]


def first_difference(one: Sequence[Sequence[Any]], other: Sequence[Sequence[Any]]) -> int | None:
    """The first step at which two sequences of [door, step] cross other doors; None if never."""
    for a, b in zip_longest(one, other):
        if a is None or b is None or a[0] != b[0]:
            return min(int(crossing[1]) for crossing in (a, b) if crossing is not None)
    return None


def _moved(pairs: Sequence[tuple[Row, Row]]) -> str:
    differ = []
    for plain, moved in pairs:
        at = first_difference(plain.get("doors", ()), moved.get("doors", ()))
        if at is not None:
            name = f"{plain['task']}, office {plain['office']}, seed {plain['seed']}"
            differ.append(f"- {name}: other doors from step {at} on")
    line = rate_line("the same doors in the same order", len(pairs) - len(differ), len(pairs),
                     ">= 98%")  # fmt: skip
    listed = "\n".join(differ or ["- none"])
    return f"## Moved against plain\n\n{HEAD}{line}\nRuns that differ:\n\n{listed}\n"


def _mirrored(here: Sequence[Row], there: Sequence[Row]) -> str:
    lines = [
        "| figure | as it is | 95 % interval | mirrored | 95 % interval |\n|---|---|---|---|---|\n"
    ]
    for task in sorted({row["task"] for row in (*here, *there)}):
        shown = [part for rows in (here, there) for part in rate_text(*_met(rows, task))]
        lines.append(f"| {task} | {' | '.join(shown)} |\n")
    return f"## Mirrored against plain, symmetric fan\n\n{''.join(lines)}"


def _met(rows: Iterable[Row], task: str) -> tuple[int, int]:
    """How many goals of a task were met, of how many; runs for the tasks without marks."""
    mine = [row for row in rows if row["task"] == task]
    if task in ("explore", "home"):
        return sum(row["success"] for row in mine), len(mine)
    missed = ({"success": False},)  # by a run that broke down
    goals = [goal for row in mine for goal in row.get("goals", missed)]
    return sum(goal["success"] for goal in goals), len(goals)
