"""The figures of a journey, as thesis 4.4 shows it: the way, and the options weighed.

Each function draws from plain values: sketches as ``Agent.sketch`` gives them, points
(P, 2) and lines (2, 2), in metres, in the sketch's frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cogmap_gym import figures as draw
from cogmap_gym.experiment_figures import (
    GREY,
    MAP_IN,
    NO_SOLIDS,
    Solids,
    finish_belief,
    mfis_figure,
    network_figure,
    panels,
    plot_solids,
)
from cogmap_gym.figures import Sketch
from cogmap_gym.geometry import Points
from cogmap_gym.labels import labels_of

STYLES: Mapping[str, tuple[str, Any, str]] = {
    "known": (draw.VERMILLION, "--", "known way, shut"),
    "back": (draw.ORANGE, (0, (4, 1, 1, 1)), "going back"),
    "new": (draw.BLUE, ":", "new exit, then straight to the goal"),
}
"""Colour, line and name of each kind of option."""
NO_POINTS: Points = np.zeros((0, 2))
NO_POINTS.setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """One of the ways that a robot weighs."""

    kind: str
    """One of ``STYLES``."""
    exits: Sequence[int]
    """Ids of the exits to cross, in order."""
    points: Points
    """(P, 2): from the robot over these exits to the goal."""
    length: float
    """As the robot estimates it [m]."""


def plot_goal(ax: Axes, goal: Points) -> None:
    """Mark a goal (2,) with a diamond."""
    ax.plot(*goal, "D", color=draw.PURPLE, mfc="white", mew=2.0, ms=8, zorder=6, label="goal")


def plot_route(ax: Axes, sketch: Sketch, goal: int) -> None:
    """Draw the way that a sketch plans, over its exits to this mark; nothing for mark 0."""
    mark = mark_of(sketch, goal)
    if mark is None:
        return
    exits = {row["id"]: np.mean((row["p"], row["q"]), axis=0) for row in sketch["exits"]}
    crossed = [exits[leave] for leave in sketch.get("route") or () if leave in exits]
    if crossed or mark["asr"] == sketch["here"]:
        way = np.array([sketch["pose"][:2], *crossed, mark["point"]])
        ax.plot(*way.T, color=draw.PURPLE, lw=1.6, ls="--", zorder=5, label="way planned")
    plot_goal(ax, np.array(mark["point"]))


def mark_of(sketch: Sketch, goal: int) -> Mapping[str, Any] | None:
    """What the sketch says of this mark, if anything."""
    return next((mark for mark in sketch.get("marks") or () if mark["id"] == goal), None)


def way_figure(
    sketch: Sketch, path: Points, title: str, goal: int, planned: Points, solids: Solids
) -> Figure:
    """The way to a goal, move by move, over the ASRs (thesis Fig. 4.26, 4.46, 4.48, 4.52).

    Args:
        sketch: what the robot believes at the end.
        path: (P, 2), its way.
        title: of the figure.
        goal: the mark it went to.
        planned: (Q, 2), the way as it was planned at the start.
        solids: what stood in the way.
    """
    figure, (ax,) = panels(1, MAP_IN)
    draw.plot_surfaces(ax, sketch, ids=False, color=GREY)
    draw.plot_asrs(ax, sketch)
    if len(planned):
        label = "planned at the start"
        ax.plot(*planned.T, color=draw.PURPLE, lw=1.6, ls="--", zorder=3, label=label)
    draw.plot_path(ax, path)
    ax.plot(*path.T, ".", color=draw.BLUE, ms=5, zorder=4, label="end of a move")
    _goal_and_solids(ax, sketch, goal, solids)
    finish_belief(ax, sketch, title)
    return figure


def options_figure(
    sketch: Sketch, options: Sequence[Option], chosen: int, title: str, goal: int, solids: Solids
) -> Figure:
    """The moment of choosing a new exit, and the ways that were weighed (thesis Fig. 4.47).

    Args:
        sketch: what the robot believes at that moment.
        options: the ways weighed.
        chosen: id of the new exit that was chosen.
        title: of the figure.
        goal: the mark that it goes to.
        solids: what stands in the way.
    """
    figure, (ax,) = panels(1, MAP_IN)
    draw.plot_surfaces(ax, sketch, ids=False, color=GREY)
    draw.plot_asrs(ax, sketch)
    labels = labels_of(ax)
    for option in options:
        color, style, name = STYLES[option.kind]
        best = option.kind == "new" and chosen in option.exits
        over = "-".join(f"E{e}" for e in option.exits)
        label = f"{name}: {over}, {option.length:.1f} m" + (" (chosen)" if best else "")
        ax.plot(*option.points.T, color=color, ls=style, lw=2.4, zorder=4, label=label)
        legs = np.stack((option.points[:-1], option.points[1:]), axis=1)
        longest = legs[np.argmax(np.hypot(*(legs[:, 1] - legs[:, 0]).T))]
        labels.add(f"{option.length:.1f} m", longest, size=11.0, color=color, clear=3.0)
        labels.avoid(legs)
    _goal_and_solids(ax, sketch, goal, solids)
    finish_belief(ax, sketch, title)
    return figure


def phase_figures(
    number: int, phase: Mapping[str, Any], sketch: Sketch, path: Points,
    goal: int = 0, planned: Points = NO_POINTS, solids: Solids = NO_SOLIDS,
) -> dict[str, Figure]:  # fmt: skip
    """The figures of a finished phase, by name (thesis Fig. 4.39 to 4.52).

    Args:
        number: of the phase, from 1.
        phase: as in ``result.json``.
        sketch: what the robot believes at its end.
        path: (P, 2), its way in the phase as believed.
        goal: the mark it went to, or 0.
        planned: (Q, 2), the way as it was planned at the start.
        solids: what stood in the way to the goal.
    """
    task = phase["task"]
    outcome = "done" if phase["success"] else "failed"
    title = f"phase {number}, {task}: {outcome} in {phase['moves']} moves"
    name = f"phase{number}_{task.replace(':', '_')}"
    made = {
        f"{name}_mfis": mfis_figure(sketch, path, f"MFIS after {title}", solids),
        f"{name}_network": network_figure(sketch, f"ASRs and network after {title}"),
    }
    if task != "explore":
        way = goal, planned, solids
        made[f"{name}_path"] = way_figure(sketch, path, f"Way of {title}", *way)
    return made


def _goal_and_solids(ax: Axes, sketch: Sketch, goal: int, solids: Solids) -> None:
    mark = mark_of(sketch, goal)
    if mark is not None:
        plot_goal(ax, np.array(mark["point"]))
    plot_solids(ax, solids)
