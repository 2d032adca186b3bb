"""The figures of a sweep: what was seen by when, and how far success reaches.

A row is what ``agents/sweep.py`` writes, as text. What the rows do not hold is left out. Robots
are told apart by colour, colour-blind safe, by marker and by line; axes carry units.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from cogmap_gym.colors import BLACK, BLUE, GREEN, ORANGE, PURPLE, ROOM_NAME, SKY, VERMILLION
from cogmap_gym.dynamics import LEVELS as DYNAMICS
from cogmap_gym.sweep_table import EXPLORE, LEVELS, Row, grouped, rate_of
from cogmap_gym.trial_scores import TOURS

COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, BLACK, SKY, ROOM_NAME)
"""Of robots, in the order of their names; colour-blind safe."""
STYLES = ("-", "--", ":")
"""Of lines, where there are more robots than colours."""
MARKERS = "osD^vP*X"
"""Of robots, in the order of their names."""


CURVES = (
    ("distance_curve", TOURS, "distance driven [lengths of the oracle's tour]"),
    ("curve", 100.0, "moves [% of the budget]"),
)
"""Columns with coverage curves: where their axis ends, and what it says."""


@dataclass(frozen=True, slots=True)
class Look:
    """How a robot is drawn, the same in every figure."""

    color: str
    style: str
    marker: str


def looks(rows: Sequence[Row]) -> dict[str, Look]:
    """The look of each robot of a sweep."""
    return {
        agent: Look(
            COLORS[k % len(COLORS)],
            STYLES[k // len(COLORS) % len(STYLES)],
            MARKERS[k % len(MARKERS)],
        )
        for k, agent in enumerate(sorted({row["agent"] for row in rows}))
    }


def curves_figure(rows: Sequence[Row]) -> Figure | None:
    """The share seen against distance and against moves, a line a robot; None without a curve."""
    told = [row for row in rows if row["task"] == EXPLORE and row["distance_curve"]]
    if not told:
        return None
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    axes, drawn = figure.subplots(1, 2, sharey=True), looks(rows)
    for ax, (column, end, axis) in zip(axes, CURVES, strict=True):
        for (agent,), group in sorted(grouped(told, ("agent",)).items()):
            middle, look = _middle_curve([row[column] for row in group]), drawn[agent]
            at = np.linspace(0.0, end, len(middle))
            ax.plot(at, 100.0 * middle, look.style, color=look.color, marker=look.marker,
                    markevery=4, ms=4, label=agent)  # fmt: skip
        ax.set(xlabel=axis, ylim=(0, 102), xlim=(0, end))
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("free area seen [%]")
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside right center", fontsize="small"
    )
    return figure


def _middle_curve(texts: Sequence[str]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """The interquartile mean, point by point."""
    every = np.sort([[float(share) for share in text.split(";")] for text in texts], axis=0)
    cut = len(every) // 4
    return np.asarray(every[cut : len(every) - cut].mean(axis=0))


@dataclass(frozen=True, slots=True)
class Factor:
    """What may make a trial hard."""

    title: str
    axis: str
    """Label of its axis, with its unit."""
    classes: tuple[str, ...]
    """From easy to hard."""
    class_of: Callable[[Row], str | None]
    """The class of a trial; None where it has none."""


def _binned(column: str, *starts: int) -> tuple[tuple[str, ...], Callable[[Row], str | None]]:
    """Classes of whole numbers from each start up to the next, and the class of a row."""
    ends = [start - 1 for start in starts[1:]]
    names = [f"{a}" if a == b else f"{a} to {b}" for a, b in zip(starts, ends, strict=False)]
    names.append(f"{starts[-1]}+")

    def class_of(row: Row) -> str | None:
        if not row[column]:
            return None
        return names[int(np.searchsorted(starts, float(row[column]), side="right")) - 1]

    return tuple(names), class_of


FACTORS = (
    Factor("Success against drift", "odometry [level]", LEVELS, lambda row: row["odometry"]),
    Factor(
        "Success against office size", "free area [m²]",
        *_binned("plan_area", 0, 100, 200, 400, 800),
    ),
    Factor(
        "Success in a living office", "dynamics [level]", tuple(DYNAMICS),
        lambda row: row["dynamics"],
    ),
    Factor(
        "Success against furniture moved", "boxes moved since exploring",
        *_binned("boxes_moved", 0, 1, 3, 6),
    ),
    Factor(
        "Success against doors changed", "doors changed since exploring",
        *_binned("doors_changed", 0, 1, 2, 4),
    ),
)  # fmt: skip
"""What the robustness envelope is drawn over."""


def met_figure(rows: Sequence[Row], factor: Factor, rng: np.random.Generator) -> Figure | None:
    """What was met against a factor, a panel a task; None where the factor does not vary."""
    told = [row for row in rows if factor.class_of(row) is not None]
    classes = [c for c in factor.classes if any(factor.class_of(row) == c for row in told)]
    if len(classes) < 2:
        return None
    by_task, drawn = grouped(told, ("task",)), looks(rows)
    figure = Figure(figsize=(3.4 * len(by_task) + 1.8, 3.6), layout="constrained")
    axes = figure.subplots(1, len(by_task), sharey=True, squeeze=False)
    for ax, ((task,), mine) in zip(axes[0], by_task.items(), strict=True):
        agents = grouped(mine, ("agent",))
        for k, ((agent,), group) in enumerate(sorted(agents.items())):
            found = [[row for row in group if factor.class_of(row) == c] for c in classes]
            at = [i for i, some in enumerate(found) if some]
            rates = 100.0 * np.array([rate_of(found[i], rng) for i in at])
            spread = np.maximum([rates[:, 0] - rates[:, 1], rates[:, 2] - rates[:, 0]], 0.0)
            aside = 0.6 / len(agents) * (k - 0.5 * (len(agents) - 1))
            look = drawn[agent]
            ax.errorbar(np.array(at) + aside, rates[:, 0], spread, ls=look.style, ms=4, lw=1.2,
                        marker=look.marker, color=look.color, label=agent)  # fmt: skip
        ax.set(title=task, xlabel=factor.axis, ylim=(-2, 102), xlim=(-0.5, len(classes) - 0.5))
        ax.set_xticks(range(len(classes)), classes)
        ax.grid(alpha=0.3)
    axes[0, 0].set_ylabel("met [%]")
    shown = dict(zip(*axes[0, 0].get_legend_handles_labels()[::-1], strict=True))
    for ax in axes[0, 1:]:
        shown |= dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(shown.values()), list(shown), loc="outside right center", fontsize="small")
    return figure
