"""Where robots went: the true paths over the plan, a panel a robot, all on the same trial."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cogmap_gym.colors import BLACK, VERMILLION
from cogmap_gym.dynamics import LEVELS as DYNAMICS
from cogmap_gym.figures import plot_plan
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points
from cogmap_gym.sweep_figures import looks
from cogmap_gym.sweep_table import EXPLORE, LEVELS, TRIAL, Row, grouped
from cogmap_gym.tasks import HOME

ACROSS = 4
"""Panels side by side [-]."""
PANEL_IN = 3.6
"""Width of a panel [inch]."""
TITLE_IN = 0.45
"""Height of a panel's title and axis [inch]."""

LEGEND = "star: home; numbers: marks; cross: end; bars: doors that are shut at first"


def paths_figure(rows: Sequence[Row], task: str) -> Figure | None:
    """Small multiples of paths on one trial of a task; None where nobody told a path.

    The trial is one that most robots have run, on the largest plan, nearest to medium odometry,
    with the least life in the office, of the lowest seed.
    """
    told = [row for row in rows if row["task"] == task and row["path"]]
    if not told:
        return None
    trials = list(grouped(told, TRIAL).values())
    chosen = min(trials, key=_rank)
    plan = FloorPlan.load(chosen[0]["map"])
    left, low, right, high = plan.bounds
    across = min(len(chosen), ACROSS)
    down = math.ceil(len(chosen) / across)
    height = PANEL_IN * min((high - low) / (right - left), 2.0) + TITLE_IN
    figure = Figure(figsize=(PANEL_IN * across, height * down + TITLE_IN), layout="constrained")
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).ravel()
    for ax, row in zip(axes, sorted(chosen, key=lambda row: row["agent"]), strict=False):
        _panel(ax, plan, row, looks(rows)[row["agent"]].color)
    for ax in axes[len(chosen) :]:
        ax.set_visible(False)
    first = chosen[0]
    told_of = f"{first['map']}, {first['odometry']} odometry, dynamics {first['dynamics']}"
    title = f"{task}: {told_of}, seed {first['seed']}"
    figure.suptitle(f"{title}\n{LEGEND}", fontsize=9)
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    return figure


def _rank(rows: Sequence[Row]) -> tuple[int, float, int, int, int]:
    """Smaller for the trial that shows more."""
    row = rows[0]
    drift = abs(LEVELS.index(row["odometry"]) - LEVELS.index("medium"))
    life = tuple(DYNAMICS).index(row["dynamics"])
    return -len(rows), -float(row["plan_area"] or 0.0), drift, life, int(row["seed"])


def _panel(ax: Axes, plan: FloorPlan, row: Row, color: str) -> None:
    """One robot's path, with home (star), the other marks (numbers) and the end (cross)."""
    plot_plan(ax, plan, light=True, names=False, shut=plan.closed)
    path = points_of(row["path"])
    ax.plot(*path.T, color=color, lw=1.2, zorder=4)
    for mark, x, y in _marks(row["marks"]):
        if mark == HOME:
            ax.plot(x, y, "*", color=VERMILLION, ms=11, mec="white", mew=0.5, zorder=6)
        else:
            ax.annotate(
                f"{mark}", (x, y), ha="center", va="center", fontsize=8, zorder=7, color=BLACK,
                bbox={"boxstyle": "circle,pad=0.15", "fc": "white", "ec": BLACK, "lw": 0.8},
            )  # fmt: skip
    ax.plot(*path[-1], "X", color=BLACK, ms=7, mec="white", mew=0.5, zorder=5)
    if row["task"] == EXPLORE:
        outcome = f"{float(row['coverage']):.0%} seen"
    else:
        outcome = f"{row['goals_met']} of {row['goals']} goals met"
    ax.set_title(f"{row['agent']}: {outcome}, {float(row['path_length']):.0f} m", fontsize=9)
    ax.set_aspect("equal")
    ax.tick_params(labelsize=8)


def points_of(text: str) -> Points:
    """A path (N, 2) [m] as it stands in a row."""
    return np.array([[float(x) for x in point.split(",")] for point in text.split(";")])


def _marks(text: str) -> list[tuple[int, float, float]]:
    found = (word.split(",") for word in text.split(";") if word)
    return [(int(mark), float(x), float(y)) for mark, x, y in found]
