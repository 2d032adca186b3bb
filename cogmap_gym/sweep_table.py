"""What the rows of a sweep say: who did how well in which task, and against whom.

A row is what ``agents/sweep.py`` writes, as text. A trial that broke down is in every figure, with
the score 0 and all its goals missed; who crashes is never better off than who fails.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogmap_gym.dynamics import LEVELS as DYNAMICS
from cogmap_gym.metrics import wilson
from cogmap_gym.statistics import (
    Interval,
    Strata,
    goal_rate,
    interquartile_mean_of,
    interval_of,
    paired_difference,
    probability_of_improvement,
)

Row = Mapping[str, str]
LEVELS = ("perfect", "low", "medium", "high", "severe")
"""Odometry levels, the best first."""
EXPLORE = "explore"
"""The task without a goal."""
SCORES = {EXPLORE: "coverage_auc"}
"""The column of a task's score ..."""
GOAL_SCORE = "soft_spl"
"""... and that of the tasks with goals."""
SETTING = ("task", "odometry", "dynamics")
"""What robots are compared within."""
TRIAL = (*SETTING, "map", "seed")
"""What is the same for all robots on a trial."""
NEVER = ("distance_90%", "distance_95%", "tour_ratio")
"""Columns that are empty where the robot never got so far: then they are infinite."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One robot in one setting."""

    agent: str
    task: str
    odometry: str
    dynamics: str
    trials: int
    failed: int
    """Trials that broke down."""
    rate: Interval
    """Share of the goals met (explore: of the trials that saw 95 %)."""
    score: Interval
    """Interquartile mean of the score."""


@dataclass(frozen=True, slots=True)
class Duel:
    """One robot against the baseline, on the trials that both have run, in one setting."""

    agent: str
    task: str
    odometry: str
    dynamics: str
    trials: int
    difference: Interval
    """Mean difference of the score on the same trials."""
    improvement: Interval
    """Probability that the robot beats the baseline."""


def cells(rows: Sequence[Row], rng: np.random.Generator) -> list[Cell]:
    """The leaderboard, by setting, the best rate first."""
    found = [_cell(key, group, rng) for key, group in grouped(rows, (*SETTING, "agent")).items()]
    return sorted(found, key=lambda c: (*_order(c), -c.rate[0], c.agent))


def duels(rows: Sequence[Row], baseline: str, rng: np.random.Generator) -> list[Duel]:
    """Every other robot against the baseline, by setting, the best first."""
    found = []
    for (task, odometry, dynamics), group in grouped(rows, SETTING).items():
        column = score_column(task)
        by_agent = grouped(group, ("agent",))
        theirs = by_agent.pop((baseline,), [])
        for (agent,), ours in by_agent.items():
            mine, others = (scores_by_map(side, column) for side in _common(ours, theirs))
            count, apart = sum(map(len, mine)), paired_difference(mine, others, rng)
            beats = probability_of_improvement(mine, others, rng)
            found.append(Duel(agent, task, odometry, dynamics, count, apart, beats))
    told = [duel for duel in found if duel.trials]
    return sorted(told, key=lambda d: (*_order(d), -d.difference[0], d.agent))


def rate_of(rows: Sequence[Row], rng: np.random.Generator) -> Interval:
    """The share of what was met, with Wilson's interval where a trial has one outcome alone.

    Trials with several goals get the interval of a cluster bootstrap.
    """
    counts = counts_by_map(rows)
    met, asked = np.concatenate(counts).sum(axis=0).tolist()
    if asked == len(rows):
        return met / asked, *wilson(met, asked)
    return goal_rate(counts, rng)


def counts_by_map(rows: Sequence[Row]) -> Strata:
    """Goals met and asked for, (n, 2) a map; exploring all is a goal, too.

    A trial that broke down before its goals could be counted has one.
    """
    return [
        np.array([_counts(row) for row in sorted(group, key=_seed)])
        for group in grouped(rows, ("map",)).values()
    ]


def scores_by_map(rows: Sequence[Row], column: str) -> Strata:
    """The scores of a column, an array a map, in the order of the seeds.

    A trial that broke down scores 0.
    """
    return [
        np.array([float(row[column] or 0.0) for row in sorted(group, key=_seed)])
        for group in grouped(rows, ("map",)).values()
    ]


def score_column(task: str) -> str:
    """The column of a task's score."""
    return SCORES.get(task, GOAL_SCORE)


def grouped(rows: Sequence[Row], columns: Sequence[str]) -> dict[tuple[str, ...], list[Row]]:
    """Rows by the values of some columns, in the order in which they first come."""
    found: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[name] for name in columns), []).append(row)
    return found


def _cell(key: tuple[str, ...], rows: Sequence[Row], rng: np.random.Generator) -> Cell:
    task, odometry, dynamics, agent = key
    strata = scores_by_map(rows, score_column(task))
    return Cell(
        agent,
        task,
        odometry,
        dynamics,
        len(rows),
        sum(bool(row["error"]) for row in rows),
        rate_of(rows, rng),
        interval_of(strata, interquartile_mean_of, rng),
    )


def quartiles(rows: Sequence[Row], column: str) -> Interval:
    """The median, and the lower and the upper quartile, of a column; NaN where no row tells it.

    They are values that were seen, the lower of two. What was never reached is infinite; else
    rows that do not tell a column, such as those of trials that broke down, are left out.
    """
    held = [float(row[column]) for row in rows if row[column]]
    if column in NEVER and rows and rows[0]["task"] == EXPLORE:
        held += [float("inf")] * (len(rows) - len(held))
    if not held:
        return float("nan"), float("nan"), float("nan")
    middle, low, high = np.quantile(held, (0.5, 0.25, 0.75), method="lower").tolist()
    return middle, low, high


def _common(ours: Sequence[Row], theirs: Sequence[Row]) -> tuple[list[Row], list[Row]]:
    """The rows of the trials that both have run, by map and seed."""
    mine, others = grouped(ours, TRIAL), grouped(theirs, TRIAL)
    both = sorted(set(mine) & set(others))
    return [mine[key][0] for key in both], [others[key][0] for key in both]


def _counts(row: Row) -> tuple[int, int]:
    if row["task"] == EXPLORE:
        return int(row["success"] or 0), 1
    return int(row["goals_met"] or 0), int(row["goals"] or 1)


def rank(odometry: str, dynamics: str) -> tuple[int, int]:
    """The place of a setting in a list: the best odometry first, a still office before a living."""
    return LEVELS.index(odometry), list(DYNAMICS).index(dynamics)


def _order(found: Cell | Duel) -> tuple[str, int, int]:
    return found.task, *rank(found.odometry, found.dynamics)


def _seed(row: Row) -> int:
    return int(row["seed"])
