"""What the colours and signs of a frame mean."""

from __future__ import annotations

from typing import Any

from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cogmap_gym import colors


def handles() -> list[Any]:
    """Handles of a legend: the truth of the left panel, then what the right one adds."""
    return [
        _line("wall", colors.WALL, lw=1.4),
        Patch(facecolor=colors.FURNITURE, edgecolor=colors.WALL, label="furniture"),
        _line("shut door", colors.VERMILLION, lw=2.2),
        _line("barrier", colors.VERMILLION, lw=2.6, ls=":"),
        Patch(facecolor=colors.GREEN + "60", edgecolor=colors.GREEN, label="box or chair"),
        _sign("person", colors.PURPLE, "o"),
        _sign("end of a beam", colors.ORANGE, "."),
        _line("path", colors.BLUE, lw=1.2),
        _sign("robot", colors.BLUE, "o"),
        _sign("home", colors.VERMILLION, "*"),
        _sign("goal", colors.PURPLE, "D", mfc="white", mew=2.0),
        Patch(facecolor=colors.SKY + "40", edgecolor=colors.SKY, label="believed: place (ASR)"),
        _line("believed: surface", colors.BLACK, lw=1.4),
        _line("believed: exit", colors.GREEN, lw=3.0),
    ]


def _line(label: str, color: str, **style: Any) -> Line2D:
    return Line2D([], [], color=color, label=label, **style)


def _sign(label: str, color: str, marker: str, **style: Any) -> Line2D:
    return Line2D([], [], color=color, marker=marker, ms=8, ls="", label=label, **style)
