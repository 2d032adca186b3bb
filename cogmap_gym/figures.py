"""Figures for publication: the floor plan, and what a robot believes about it.

Every function draws on axes that the caller made, in metres, in the frame of what it is
given; ``moved`` brings a sketch into another frame. Draw first, then call ``finish``.
Colours are those of Okabe and Ito, told apart by colour-blind readers too; line style
and label say the same again. Nothing here touches pyplot or a display.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray
from shapely.geometry import Polygon

from cogmap_gym import colors
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.labels import labels_of

Sketch = Mapping[str, Any]
"""What an agent believes, with the keys of ``Agent.sketch``."""

BLACK, ORANGE, SKY, GREEN = colors.BLACK, colors.ORANGE, colors.SKY, colors.GREEN
BLUE, VERMILLION, PURPLE = colors.BLUE, colors.VERMILLION, colors.PURPLE
SMALL_PT, MEDIUM_PT, LARGE_PT = 5.5, 7.0, 9.0
"""Sizes of letters: surfaces, exits and doors, ASRs and rooms [pt]."""


def plot_plan(
    ax: Axes,
    plan: FloorPlan,
    *,
    shut: Iterable[str] = (),
    barriers: Iterable[str] = (),
    light: bool = False,
    names: bool = True,
) -> None:
    """Draw the truth: walls, furniture, doors, barriers and the names of rooms.

    Args:
        ax: axes in the plan's frame.
        plan: the floor plan.
        shut: names of the doors that are shut; the others are open.
        barriers: names of the barriers that stand.
        light: pale, as a background for what a robot believes.
        names: write the names of rooms and doors.
    """
    shut, barriers = set(shut), set(barriers)
    walls = [np.asarray(wall, dtype=np.float64) for wall in plan.walls]
    _lines(ax, walls, colors.LIGHT_WALL if light else colors.WALL, 1.0 if light else 1.4, "wall")
    fill, edge = (
        (colors.LIGHT_FURNITURE, colors.LIGHT_WALL) if light else (colors.FURNITURE, colors.WALL)
    )
    pieces = [np.asarray(piece, dtype=np.float64) for piece in plan.furniture]
    _polygons(ax, pieces, fill, edge, "" if light else "furniture")
    closed = [np.asarray(plan.doors[name], dtype=np.float64) for name in sorted(shut)]
    standing = [np.asarray(plan.barriers[name], dtype=np.float64) for name in sorted(barriers)]
    _lines(ax, closed, VERMILLION, 2.2, "shut door")
    _lines(ax, standing, VERMILLION, 2.6, "barrier", ":")
    labels = labels_of(ax)
    shown = {**plan.doors, **{name: plan.barriers[name] for name in sorted(barriers)}}
    for name, line in shown.items() if names else ():
        color = VERMILLION if name in shut | barriers else colors.WALL
        labels.add(name, np.asarray(line), size=MEDIUM_PT, color=color, clear=3.0)
    for name, room in plan.rooms.items() if names else ():
        labels.add(name, _on(_inside(room)), size=LARGE_PT, color=colors.ROOM_NAME)
    for wall in walls if names else ():
        labels.avoid(np.stack((wall[:-1], wall[1:]), axis=1))


def plot_surfaces(
    ax: Axes, surfaces: Sketch | Segments, *,
    ids: bool | Sequence[str] = True, color: str = BLACK, label: str = "surface", style: str = "-",
) -> None:  # fmt: skip
    """Draw the surfaces of a sketch, or Segments (N, 2, 2), each beside its id.

    The id of a row of Segments is its number, from 0, or what ``ids`` says. No id covers another.
    """
    lines, names = _segments(surfaces)
    names = names if isinstance(ids, bool) else list(ids)
    _lines(ax, list(lines), color, 1.4, label, style)
    labels = labels_of(ax)
    labels.avoid(lines)
    order = np.argsort(-np.hypot(*(lines[:, 1] - lines[:, 0]).T)) if len(lines) else ()
    for row in order if ids is not False else ():
        labels.add(names[row], lines[row], size=SMALL_PT, color=color)


def plot_asrs(ax: Axes, sketch: Sketch, *, ids: bool = True) -> None:
    """Draw each ASR's boundary and each exit, with their ids; the robot's ASR is framed."""
    labels = labels_of(ax)
    for number, asr in enumerate(sketch["asrs"]):
        boundary = _points(asr["boundary"])
        if len(boundary) < 3:
            continue
        color = colors.ASR_COLORS[number % len(colors.ASR_COLORS)]
        here = asr["id"] == sketch.get("here")
        area = ax.fill(
            *boundary.T, facecolor=color + "40", edgecolor=color, lw=2.4 if here else 1.0
        )
        area[0].set_label("" if number else "ASR")
        if ids:
            labels.add(str(asr["id"]), _on(_inside(boundary)), size=LARGE_PT, color=BLACK)
    plot_exits(ax, sketch, ids=ids)


def plot_exits(ax: Axes, sketch: Sketch, *, ids: bool = True) -> None:
    """Draw each exit as a line across its opening, with its id."""
    lines = _rows(sketch["exits"])
    _lines(ax, list(lines), GREEN, 3.0, "exit")
    labels_of(ax).avoid(lines)
    for leave, line in zip(sketch["exits"] if ids else (), lines, strict=False):
        labels_of(ax).add(str(leave["id"]), line, size=MEDIUM_PT, color=GREEN, clear=2.0)


def plot_network(ax: Axes, sketch: Sketch) -> None:
    """Draw the network: a node at the middle of each ASR, edges by way of their exits.

    An ASR without a boundary stands at the mean of its exits; a link to no ASR ends at its exit.
    """
    exits = dict(zip([e["id"] for e in sketch["exits"]], _rows(sketch["exits"]), strict=True))
    nodes = {a["id"]: place for a in sketch["asrs"] if (place := _node(a, exits)) is not None}
    labels = labels_of(ax)
    edges = []
    for name, place in nodes.items():
        labels.add(str(name), _on(place), size=LARGE_PT, color=BLACK, fixed=True)
    for one, leave, other in sketch["links"]:
        ends = [nodes[asr] for asr in (one, other) if asr in nodes]
        if ends and leave in exits:
            middle = exits[leave].mean(axis=0)
            edges.append(np.stack((ends[0], middle, *ends[1:])))
            labels.add(str(leave), exits[leave], size=MEDIUM_PT, color=GREEN, clear=3.0)
            labels.avoid(np.stack((edges[-1][:-1], edges[-1][1:]), axis=1))
    _lines(ax, edges, BLUE, 1.4, "link")
    if edges:
        ax.plot(
            *np.array([edge[1] for edge in edges]).T, "s", color=GREEN, ms=5, zorder=5, label="exit"
        )
    if nodes:
        places = np.array(list(nodes.values()))
        ax.plot(*places.T, "o", mfc="white", mec=BLUE, mew=1.4, ms=19, zorder=6, label="ASR")


def plot_path(
    ax: Axes, path: Points, *, color: str = BLUE, label: str = "path", style: str = "-"
) -> None:
    """Draw a path (N, 2) from its start (circle) to its end (square)."""
    path = _points(path)
    if len(path) == 0:
        return
    ax.plot(*path.T, color=color, lw=1.2, ls=style, label=label, zorder=4)
    labels_of(ax).avoid(np.stack((path[:-1], path[1:]), axis=1))
    ax.plot(*path[0], "o", color=color, mfc="white", ms=5, zorder=5)
    ax.plot(*path[-1], "s", color=color, ms=4, zorder=5)


def plot_home(ax: Axes, home: Pose) -> None:
    """Mark home with a star."""
    ax.plot(
        home.x, home.y, "*", color=VERMILLION, ms=15, mec="white", mew=0.5, zorder=6, label="home"
    )


def moved(sketch: Sketch, target_from_sketch: Pose) -> dict[str, Any]:
    """The drawn parts of a sketch in another frame: all but links, route and status."""
    out = dict(sketch)
    place, marks = target_from_sketch.apply, sketch.get("marks") or ()
    for key in ("surfaces", "exits"):
        lines = place(_rows(sketch[key]))
        out[key] = [{**row, "p": p, "q": q} for row, (p, q) in zip(sketch[key], lines, strict=True)]
    out["asrs"] = [{**asr, "boundary": place(_points(asr["boundary"]))} for asr in sketch["asrs"]]
    out["marks"] = [{**mark, "point": place(np.array(mark["point"]))} for mark in marks]
    for key in ("pose", "home"):
        if sketch.get(key) is not None:
            pose = target_from_sketch @ Pose(*(float(v) for v in sketch[key]))
            out[key] = [pose.x, pose.y, pose.theta]
    return out


def finish(ax: Axes, title: str = "", *, legend: bool = True) -> None:
    """Equal aspect, metres on both axes, a title, and the legend below the drawing."""
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.04)
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.set_title(title)
    handles, names = ax.get_legend_handles_labels()
    shown = dict(zip(names, handles, strict=True))
    if legend and shown:
        ax.legend(
            list(shown.values()), list(shown), loc="upper center", frameon=False, ncols=4,
            bbox_to_anchor=(0.5, 0.0), borderaxespad=5.0, fontsize=8, markerscale=0.7,
        )  # fmt: skip


def _lines(
    ax: Axes, lines: Sequence[Points], color: str, width: float, label: str, style: str = "-"
) -> None:
    if len(lines):
        ax.add_collection(
            LineCollection(lines, colors=color, linewidths=width, linestyles=style, label=label)
        )
        ax.autoscale_view()


def _polygons(ax: Axes, polygons: Sequence[Points], fill: str, edge: str, label: str) -> None:
    if len(polygons):
        ax.add_collection(
            PolyCollection(polygons, facecolors=fill, edgecolors=edge, linewidths=0.8, label=label)
        )
        ax.autoscale_view()


def _points(values: Any) -> Points:
    return np.asarray(values, dtype=np.float64).reshape(-1, 2)


def _rows(rows: Sequence[Mapping[str, Any]]) -> Segments:
    return np.array([(row["p"], row["q"]) for row in rows], dtype=np.float64).reshape(-1, 2, 2)


def _segments(surfaces: Sketch | Segments) -> tuple[Segments, list[str]]:
    if isinstance(surfaces, np.ndarray):
        return surfaces.reshape(-1, 2, 2), [str(row) for row in range(len(surfaces))]
    return _rows(surfaces["surfaces"]), [str(row["id"]) for row in surfaces["surfaces"]]


def _on(point: Points) -> NDArray[np.float64]:
    return np.stack((point, point))


def _inside(boundary: Any) -> Points:
    """The centroid where it lies inside the polygon, else some point that does."""
    polygon = Polygon(_points(boundary)).buffer(0)
    centroid = polygon.centroid
    point = centroid if polygon.contains(centroid) else polygon.representative_point()
    return np.array((point.x, point.y))


def _node(asr: Mapping[str, Any], exits: Mapping[Any, Segments]) -> Points | None:
    boundary = _points(asr["boundary"])
    if len(boundary) >= 3:
        return _inside(boundary)
    known = [exits[e].mean(axis=0) for e in asr["exits"] if e in exits]
    return np.mean(known, axis=0) if known else None
