"""A sweep at a glance: a table for each level of odometry, a row a robot, a column a task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cogmap_gym.statistics import Interval
from cogmap_gym.sweep_table import EXPLORE, Cell, Row, grouped, quartiles, rank

TASKS = (EXPLORE, "home", "goto", "shortcut")
"""In the order of the columns."""
COSTS = (("cpu_ms", "CPU a step [ms]", ".1f", 1.0), ("map_bytes", "map [kB]", ".0f", 1e-3))
"""Columns of medians: of the file, head, form, factor from the file's unit."""
NOTE = (
    "Goals met, for exploring the trials that saw 95 % in time and the coverage AUC over distance "
    "(interquartile mean), in brackets 95 % intervals; medians of cost over all tasks."
)


class Overview(NamedTuple):
    """One table."""

    odometry: str
    dynamics: str
    head: tuple[str, ...]
    lines: list[tuple[str, ...]]
    """A robot each, the one that met most goals first."""

    @property
    def title(self) -> str:
        """Its heading."""
        life = "" if self.dynamics == "off" else f", dynamics {self.dynamics}"
        return f"{self.odometry} odometry{life}"


def overviews(rows: Sequence[Row], found: Sequence[Cell]) -> list[Overview]:
    """The tables of a sweep, the best odometry first.

    Args:
        rows: all trials.
        found: its leaderboard.
    """
    groups = grouped(rows, ("odometry", "dynamics"))
    settings = sorted(groups.items(), key=lambda group: rank(*group[0]))
    return [_overview(level, life, some, found) for (level, life), some in settings]


def markdown(table: Overview) -> str:
    """A table as Markdown, under a heading."""
    lines = [table.head, ("---",) * len(table.head), *table.lines]
    body = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return f"## {table.title}\n\n{body}\n"


def _overview(odometry: str, dynamics: str, rows: Sequence[Row], found: Sequence[Cell]) -> Overview:
    here = {(c.agent, c.task): c for c in found if (c.odometry, c.dynamics) == (odometry, dynamics)}
    tasks = sorted({task for _, task in here}, key=TASKS.index)
    robots = sorted({agent for agent, _ in here}, key=lambda name: (-_met(name, rows), name))
    head = ["robot", "trials"]
    for task in tasks:
        head += ["explore: saw 95 %", "coverage AUC"] if task == EXPLORE else [task]
    by_agent = grouped(rows, ("agent",))
    lines = []
    for name in robots:
        line = [name, str(len(by_agent[(name,)]))]
        for task in tasks:
            line += _told(here.get((name, task)), task)
        line += [_median(by_agent[(name,)], *cost) for cost in COSTS]
        lines.append(tuple(line))
    return Overview(odometry, dynamics, (*head, *(cost[1] for cost in COSTS)), lines)


def _met(agent: str, rows: Sequence[Row]) -> float:
    """The share of all goals that a robot met."""
    some = [row for row in rows if row["agent"] == agent and row["task"] != EXPLORE]
    asked = sum(int(row["goals"] or 1) for row in some)
    return sum(int(row["goals_met"] or 0) for row in some) / asked if asked else 0.0


def _told(cell: Cell | None, task: str) -> list[str]:
    if cell is None:
        return ["-", "-"] if task == EXPLORE else ["-"]
    rate = _interval((100.0 * cell.rate[0], 100.0 * cell.rate[1], 100.0 * cell.rate[2]), ".0f")
    return [rate, _interval(cell.score, ".2f")] if task == EXPLORE else [rate]


def _interval(value: Interval, form: str) -> str:
    middle, low, high = (format(x, form) for x in value)
    unit = " %" if form == ".0f" else ""
    return f"{middle}{unit} ({low}-{high})"


def _median(rows: Sequence[Row], column: str, _: str, form: str, factor: float) -> str:
    held = [row for row in rows if row[column]]
    return format(factor * quartiles(held, column)[0], form) if held else "-"
