"""The table and the figure of an ablation, from the rows of many episodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cogmap_gym.metrics import wilson
from cogmap_gym.score_table import RING_QUESTIONS

Row = Mapping[str, Any]
"""A scored episode, with the parameter set that was used under ``params``."""
Names = Sequence[tuple[str, str]]
"""Of each parameter set its name, and what its rows have under ``params``."""
COLUMNS = {
    **{f"exp {k} ({question})": (k, question) for k in (1, 2) for question in RING_QUESTIONS},
    "exp 3 goals": (3, "goals"),
    "exp 3 own doors, network": (3, "thesis"),
}
"""The questions of a row of the table: the experiment and the key of a scored episode."""
CELL_IN = (1.0, 0.4)
"""Width and height of a cell of the figure [inch]."""
MARGIN_IN = (3.6, 1.5)
"""Room for the names of rows, of columns and of the scale [inch]."""
DARK = 0.55
"""Shares below are written in white [-]."""


def ablation_table(rows: Iterable[Row], sections: Mapping[str, Names]) -> str:
    """A Markdown table for each section: a parameter set a row, a question a column.

    Args:
        rows: of all episodes.
        sections: under each title the parameter sets, in order.
    """
    kept = list(rows)
    return "\n".join(_section(title, names, kept) for title, names in sections.items())


def counted(rows: Iterable[Row], params: str, column: str) -> tuple[int, int]:
    """In how many episodes with these parameters the answer was yes, and of how many."""
    experiment, question = COLUMNS[column]
    answers = [
        bool(row[question])
        for row in rows
        if row["params"] == params and row["experiment"] == experiment
    ]
    return sum(answers), len(answers)


def ablation_figure(rows: Iterable[Row], sections: Mapping[str, Names], title: str) -> Figure:
    """The share of runs in which the answer was yes, one panel a section, one cell a question."""
    kept, count = list(rows), sum(len(names) for names in sections.values())
    size = (
        len(COLUMNS) * CELL_IN[0] + MARGIN_IN[0],
        count * CELL_IN[1] + len(sections) * MARGIN_IN[1],
    )
    figure = Figure(figsize=size, layout="constrained")
    heights = [len(names) for names in sections.values()]
    grid = figure.add_gridspec(len(sections), 1, height_ratios=heights)
    axes = [figure.add_subplot(grid[k, 0]) for k in range(len(sections))]
    for ax, (name, names) in zip(axes, sections.items(), strict=True):
        _panel(ax, name, names, kept)
    if axes:
        label = "share of runs [-]"
        figure.colorbar(axes[0].images[0], ax=axes, label=label, shrink=0.6, pad=0.02)
    figure.suptitle(title)
    return figure


def _section(title: str, names: Names, rows: Sequence[Row]) -> str:
    head = f"| parameters | {' | '.join(COLUMNS)} |\n|{'---|' * (len(COLUMNS) + 1)}\n"
    lines = [
        f"| {name} | {' | '.join(_cell(*counted(rows, key, column)) for column in COLUMNS)} |\n"
        for name, key in names
    ]
    return f"## {title}\n\n{head}{''.join(lines)}"


def _cell(successes: int, trials: int) -> str:
    if trials == 0:
        return "-"
    low, high = wilson(successes, trials)
    return f"{successes}/{trials} ({100 * low:.0f}-{100 * high:.0f})"


def _panel(ax: Axes, title: str, names: Names, rows: Sequence[Row]) -> None:
    counts = np.array([[counted(rows, key, column) for column in COLUMNS] for _, key in names])
    with np.errstate(invalid="ignore"):
        shares = counts[..., 0] / counts[..., 1]  # nan, an empty cell, without a run
    ax.imshow(shares, vmin=0.0, vmax=1.0, cmap="cividis", aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        successes, trials = counts[row, column]
        said, color = f"{successes}/{trials}" if trials else "-", "white"
        color = color if share < DARK else "black"
        ax.text(column, row, said, ha="center", va="center", color=color, fontsize=9)
    columns = [column.replace(" (", "\n(").replace("3 ", "3\n", 1) for column in COLUMNS]
    ax.set_xticks(range(len(COLUMNS)), [column.replace(", ", ",\n") for column in columns])
    ax.set_yticks(range(len(names)), [name for name, _ in names])
    ax.tick_params(length=0)
    ax.set_xlabel("experiment and question")
    ax.set_title(title)
    experiments = [experiment for experiment, _ in COLUMNS.values()]
    for border in range(1, len(COLUMNS)):
        new = experiments[border] != experiments[border - 1]
        ax.axvline(border - 0.5, color="white", lw=5.0 if new else 0.8)
    for border in range(1, len(names)):
        ax.axhline(border - 0.5, color="white", lw=0.8)
