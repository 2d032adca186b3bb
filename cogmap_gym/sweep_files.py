"""What a sweep leaves in its folder: the page, the tables as Markdown, the figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from cogmap_gym.saving import write_whole
from cogmap_gym.sweep_figures import FACTORS, curves_figure, met_figure
from cogmap_gym.sweep_overview import NOTE, markdown, overviews
from cogmap_gym.sweep_paths import paths_figure
from cogmap_gym.sweep_report import report_page
from cogmap_gym.sweep_table import Row, cells, duels

ENDINGS = ("png", "pdf")
"""Each figure is written as."""
DPI = 180
"""Pixels an inch."""


def write_sweep(rows: Sequence[Row], tasks: Iterable[str], baseline: str, out: Path) -> Path:
    """Write ``report.html``, ``leaderboard.md`` and each figure; returns the path of the page.

    Args:
        rows: all trials.
        tasks: whose paths are drawn.
        baseline: the robot that the others are compared with.
        out: the folder.
    """
    rng = np.random.default_rng(0)
    drawn = {"Coverage": curves_figure(rows)}
    drawn |= {factor.title: met_figure(rows, factor, rng) for factor in FACTORS}
    drawn |= {f"Paths, {task}": paths_figure(rows, task) for task in tasks}
    pictures = {title: figure for title, figure in drawn.items() if figure is not None}
    for title, figure in pictures.items():
        stem = title.lower().replace(",", "").replace(" ", "_")
        for ending in ENDINGS:
            figure.savefig(out / f"{stem}.{ending}", dpi=DPI)
    found = cells(rows, rng)
    told = "\n".join(markdown(table) for table in overviews(rows, found))
    write_whole(out / "leaderboard.md", f"# Leaderboard\n\n{NOTE}\n\n{told}".encode())
    page = report_page(rows, found, duels(rows, baseline, rng), baseline, pictures)
    return write_whole(out / "report.html", page.encode())
