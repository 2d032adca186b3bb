"""The figures of an experiment, as chapters 3 and 4 of the thesis show it.

Each function makes one figure from plain values: sketches as ``Agent.sketch`` gives
them, paths (N, 2) and Segments (N, 2, 2), in metres.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cogmap_gym import colors
from cogmap_gym import figures as draw
from cogmap_gym.figures import Sketch
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.labels import labels_of

MAP_IN = (10.0, 10.4)
"""Width and height of a figure of the whole map [inch]: ids of 300 surfaces can be read."""
MIN_PANEL_IN = 5.4
"""Least width of a panel: its title and legend fit [inch]."""
AROUND_M = 1.0
"""How much is shown around a local space or a view [m]."""
GREY = "#7F7F7F"
Solids = Mapping[str, Points]
"""What stands in the way, by name: lines (2, 2) in the sketch's frame."""
NO_SOLIDS: Solids = {}


@dataclass(frozen=True, slots=True, eq=False)
class TwoViews:
    """Two successive views and what became of the later one, in the later robot's frame."""

    step: int
    before: Segments
    """(M, 2, 2): surfaces of V_{n-1}, laid where odometry says."""
    before_ids: Sequence[int]
    """(M,): their ids, 0 for none."""
    view: Segments
    """(N, 2, 2): surfaces of V_n."""
    view_ids: Sequence[int]
    """(N,): the ids they got, 0 for none."""
    landmarks: Segments
    """(K, 2, 2): the landmarks of the step, normalised, as the MFIS now has them."""
    landmark_ids: Sequence[int]
    """(K,): their ids."""


def mfis_figure(sketch: Sketch, path: Points, title: str, solids: Solids = NO_SOLIDS) -> Figure:
    """The MFIS with ids of surfaces and exits, a path, what was shut (thesis Fig. 4.16, 4.50)."""
    figure, (ax,) = panels(1, MAP_IN)
    draw.plot_exits(ax, sketch)
    draw.plot_path(ax, path)
    draw.plot_surfaces(ax, sketch)
    plot_solids(ax, solids)
    finish_belief(ax, sketch, title)
    return figure


def network_figure(sketch: Sketch, title: str) -> Figure:
    """ASRs with their boundaries, and the network over them (thesis Fig. 4.19)."""
    figure, (ax,) = panels(1, MAP_IN)
    draw.plot_asrs(ax, {**sketch, "exits": ()}, ids=False)
    draw.plot_exits(ax, sketch, ids=False)
    draw.plot_network(ax, sketch)
    crossed = {link[1] for link in sketch["links"]}
    draw.plot_exits(ax, {"exits": [row for row in sketch["exits"] if row["id"] not in crossed]})
    finish_belief(ax, sketch, title)
    return figure


def landmarks_figure(views: TwoViews) -> Figure:
    """V_n over V_{n-1}, before and after normalisation (thesis Fig. 3.12, 3.17)."""
    shown = np.concatenate((views.view, views.before)).reshape(-1, 2)
    figure, (left, right) = panels(2, _fitting(shown, 8.0))
    ids = np.asarray(views.view_ids)
    known = np.isin(ids, views.landmark_ids) & (ids > 0)
    names = np.array([f"U{row + 1}" for row in range(len(ids))])
    named = np.array([f"{u}={i}" for u, i in zip(names, ids, strict=True)])
    entered, rest = ~known & (ids > 0), ids == 0
    _halo(left, views.view[known])
    old = [str(i or "") for i in views.before_ids]
    _draw(left, views.before, old, draw.VERMILLION, "V(n-1), with its ids", "--")
    _draw(left, views.view, names, draw.GREEN, "V(n), not yet named")
    _halo(right, views.landmarks)
    new = [str(i) for i in views.landmark_ids]
    _draw(right, views.landmarks, new, draw.BLUE, "landmark, normalised")
    _draw(right, views.view[entered], named[entered], draw.VERMILLION, "named by transfer", "-.")
    _draw(right, views.view[rest], names[rest], GREY, "not entered", ":")
    for ax, what in (
        (left, "(a) V(n-1), moved by odometry, and V(n)"),
        (right, "(b) landmarks after normalisation"),
    ):
        ax.plot(0.0, 0.0, ">", color=draw.BLACK, ms=9, zorder=6, label="robot")
        draw.finish(ax, f"{what}: step {views.step}")
        _window(ax, shown)
    return figure


def asr_figure(
    sketch: Sketch, asr_id: int, own_ids: Collection[int],
    corners: Points, large: Segments, path: Points,
) -> Figure:  # fmt: skip
    """How an ASR was cut: surfaces, corners, boundary (thesis Fig. 3.23, 4.1 to 4.3).

    Args:
        sketch: what the robot believes just after.
        asr_id: which ASR of the sketch.
        own_ids: ids of the surfaces that are its own.
        corners: (C, 2), its corner points.
        large: (L, 2, 2), its large surfaces.
        path: (P, 2), the robot's way in it.
    """
    asr = next(row for row in sketch["asrs"] if row["id"] == asr_id)
    exits = [row for row in sketch["exits"] if row["id"] in asr["exits"]]
    own = {"surfaces": [row for row in sketch["surfaces"] if row["id"] in own_ids]}
    other = {"surfaces": [row for row in sketch["surfaces"] if row["id"] not in own_ids]}
    ends = [point for row in own["surfaces"] for point in (row["p"], row["q"])]
    shown = np.array([*ends, *asr["boundary"], *path.tolist()])
    figure, (first, second, third) = panels(3, _fitting(shown))
    draw.plot_exits(first, {"exits": exits})
    draw.plot_path(first, path)
    draw.plot_surfaces(first, own)
    draw.plot_exits(second, {"exits": exits}, ids=False)
    draw.plot_surfaces(second, own, ids=False, color=GREY, label="small surface")
    second.plot(*corners.T, "o", color=draw.BLUE, ms=5, zorder=5, label="corner point")
    draw.plot_asrs(third, {"asrs": (asr,), "exits": exits})
    draw.plot_path(third, path)
    for ax in (second, third):
        draw.plot_surfaces(ax, large, ids=False, color=draw.VERMILLION, label="large surface")
    third_title = "boundary" if len(asr["boundary"]) else "no boundary found"
    titles = ("surfaces and path", "corner points, large surfaces", third_title)
    for ax, title in zip((first, second, third), titles, strict=True):
        draw.plot_surfaces(ax, other, ids=False, color=GREY, label="of another place", style=":")
        draw.finish(ax, f"ASR{asr_id}: {title}")
        _window(ax, shown)
    return figure


def overview_figure(
    plan: FloorPlan, true_path: Points, sketch: Sketch | None, path: Points,
    plan_from_sketch: Pose, title: str, shut: Iterable[str] = (),
) -> Figure:  # fmt: skip
    """The truth at the left, what the robot believes at the right, in the plan's frame.

    Args:
        plan: the floor plan.
        true_path: (T, 2) in the plan.
        sketch: in its own frame; None for a robot that tells nothing.
        path: (T, 2), as believed, in the sketch's frame.
        plan_from_sketch: where home lies in the plan.
        title: of the figure.
        shut: names of the doors that are shut.
    """
    figure, (left, *others) = panels(1 if sketch is None else 2, (9.0, 10.0))
    draw.plot_plan(left, plan, shut=shut)
    draw.plot_path(left, true_path, label="true path")
    draw.plot_home(left, plan_from_sketch)
    draw.finish(left, "the truth")
    if sketch is not None:
        believed, (right,) = draw.moved(sketch, plan_from_sketch), others
        draw.plot_plan(right, plan, light=True, names=False)
        draw.plot_asrs(right, believed)
        draw.plot_surfaces(right, believed, ids=False)
        draw.plot_path(right, plan_from_sketch.apply(path), label="believed path")
        finish_belief(right, believed, "what the robot believes, laid on the truth at home")
    figure.suptitle(title)
    return figure


def plot_solids(ax: Axes, solids: Solids) -> None:
    """Draw barriers and shut doors as dotted lines with their names."""
    for number, (name, line) in enumerate(solids.items()):
        label = "" if number else "barrier or shut door, in truth"
        color = draw.VERMILLION
        ax.plot(*line.T, color=color, lw=3.5, ls=(0, (0.6, 0.6)), zorder=7, label=label)
        labels_of(ax).add(name, line, size=draw.LARGE_PT, color=color, clear=4.0)


def panels(count: int, panel: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Panels of this width and height [inch], side by side."""
    figure = Figure(figsize=(count * panel[0], panel[1]), layout="constrained")
    return figure, [figure.add_subplot(1, count, k + 1) for k in range(count)]


def _fitting(points: Points, largest: float = 6.5) -> tuple[float, float]:
    """Width and height [inch] of a panel that shows these points (P, 2) without waste."""
    extent = np.ptp(points, axis=0) + 2.0 * AROUND_M if len(points) else np.ones(2)
    width, height = largest * extent / extent.max()
    return max(float(width) + 0.6, MIN_PANEL_IN), float(height) + 1.3


def finish_belief(ax: Axes, sketch: Sketch, title: str) -> None:
    """Home and the robot as believed, then axes and legend."""
    if sketch.get("home") is not None:
        draw.plot_home(ax, Pose(*sketch["home"][:2]))
    if sketch.get("pose") is not None:
        x, y, theta = sketch["pose"]
        turned = (3, 0, np.degrees(theta) - 90.0)
        ax.plot(x, y, ls="", marker=turned, color=draw.BLACK, ms=10, zorder=7, label="robot")
    draw.finish(ax, title)


def _draw(
    ax: Axes, lines: Segments, names: Iterable[str], color: str, label: str, style: str = "-"
) -> None:
    draw.plot_surfaces(ax, lines, ids=list(names), color=color, label=label, style=style)


def _halo(ax: Axes, lines: Segments) -> None:
    """A pale band under the landmarks."""
    for row, line in enumerate(lines):
        label = "" if row else "landmark"
        ax.plot(*line.T, color=colors.YELLOW, lw=7, alpha=0.6, zorder=1, label=label)


def _window(ax: Axes, points: Points) -> None:
    """Show these points (P, 2) and a little around them, and nothing else."""
    if len(points):
        low, high = points.min(axis=0) - AROUND_M, points.max(axis=0) + AROUND_M
        ax.set_aspect("equal", adjustable="box")
        ax.set_xlim(low[0], high[0])
        ax.set_ylim(low[1], high[1])
