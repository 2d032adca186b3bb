"""Pictures of an episode: the truth at the left, what the robot believes at the right.

Drawn by Matplotlib's Agg canvas rather than on pygame surfaces: frames and the figures
for publication then share one way to draw, lines are smooth, no display is needed, and a
frame takes some tens of milliseconds; a window to watch in is drawn by ``screen``. Matplotlib
is imported when the first frame is drawn, so that training without pictures never loads it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import LaserSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Frame = NDArray[np.uint8]
"""A picture, shape (H, W, 3)."""

DPI = 100
"""Pixels an inch: fixes how large letters are in a frame."""
ROBOT_RADIUS_M = 0.25
"""Radius at which the robot is drawn; that of the Pioneer 3DX [m]."""
LEGEND_COLUMN_PX = 150
"""Width of a column of the legend [pixels]."""
MARGIN = 0.06
"""Room left around the plan for caption and scale bar, as a part of its extent."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """All that one frame shows; coordinates in the plan's frame, metres and radians."""

    plan: FloorPlan
    pose: Pose
    """Where the robot truly is."""
    shut: tuple[str, ...] = ()
    """Names of the doors that are shut."""
    barriers: tuple[str, ...] = ()
    """Names of the barriers that stand."""
    boxes: tuple[Points, ...] = ()
    """Corners of what can be pushed, (K, 2) each."""
    people: tuple[Points, ...] = ()
    """Corners of people, (K, 2) each."""
    scan: Points = field(default_factory=lambda: np.zeros((0, 2)))
    """Where the beams ended, (K, 2)."""
    path: Points = field(default_factory=lambda: np.zeros((0, 2)))
    """Where the robot has been, (N, 2)."""
    sketch: Mapping[str, Any] | None = None
    """What the robot believes, in its own frame, as ``Agent.sketch`` gives it."""
    plan_from_sketch: Pose = field(default_factory=Pose)
    """Where the sketch's origin lies in the plan."""
    goal: int = 0
    """The mark to go to, or 0."""
    goal_pose: Pose | None = None
    """Where that mark truly is."""
    caption: str = ""
    """What is going on; by default the plan's name."""


def draw(scene: Scene, size: tuple[int, int] = (480, 960)) -> Frame:
    """Draw one frame; no display is needed.

    Args:
        scene: what to show. Without a sketch the plan fills the whole frame.
        size: height and width in pixels, each at least 64.

    Returns:
        A fresh array uint8 (height, width, 3).

    Raises:
        ValueError: the size is not two numbers of at least 64.
    """
    height, width = _checked(size)
    figure = _blank(height, width)
    panels = 1 if scene.sketch is None else 2
    for panel in range(panels):
        ax = figure.add_axes((panel / panels, 0.0, 1.0 / panels, 1.0))
        _set_window(ax, scene.plan, panels * height / width)
        if panel == 0:
            _draw_truth(ax, scene)
        else:
            _draw_belief(ax, scene)
    return _pixels(figure)


def draw_legend(size: tuple[int, int] = (64, 960)) -> Frame:
    """What the colours and signs of ``draw`` mean, as a strip to put below frames.

    Size, result and errors are those of ``draw``.
    """
    from cogmap_gym.legend import handles

    height, width = _checked(size)
    figure = _blank(height, width)
    columns = max(width // LEGEND_COLUMN_PX, 1)
    figure.legend(handles=handles(), loc="center", ncols=columns, fontsize=8, frameon=False)
    return _pixels(figure)


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    """Height and width of a frame [pixels]."""
    if len(size) != 2 or min(size) < 64:
        raise ValueError(f"draw: expected size (height, width) of at least 64 each, got {size}")
    return int(size[0]), int(size[1])


def _blank(height: int, width: int) -> Figure:
    """A figure of this size [pixels], on a canvas that needs no display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def _pixels(figure: Figure) -> Frame:
    """The figure as a frame of its own size."""
    pixels, (width, height) = figure.canvas.print_to_buffer()  # type: ignore[attr-defined]
    return np.frombuffer(pixels, dtype=np.uint8).reshape(height, width, 4)[..., :3].copy()


def scan_ends(ranges: NDArray[Any], laser: LaserSpec, plan_from_robot: Pose) -> Points:
    """Where the beams (B,) that returned ended, (K, 2), plan frame [m]."""
    hit = ranges < laser.range_max
    reach, angles = ranges[hit].astype(np.float64), laser.angles[hit]
    ends = np.stack((reach * np.cos(angles), reach * np.sin(angles)), axis=-1)
    return (plan_from_robot @ laser.robot_from_laser).apply(ends)


def _set_window(ax: Axes, plan: FloorPlan, shape: float) -> None:
    """Show the whole plan in a panel whose height is ``shape`` times its width."""
    corners = np.concatenate([np.asarray(wall, dtype=np.float64) for wall in plan.walls])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, extent = (low + high) / 2.0, (high - low) * (1.0 + 2.0 * MARGIN)
    width = max(float(extent[0]), float(extent[1]) / shape)
    ax.set_axis_off()
    ax.set_autoscale_on(False)
    ax.set_xlim(middle[0] - width / 2.0, middle[0] + width / 2.0)
    ax.set_ylim(middle[1] - width * shape / 2.0, middle[1] + width * shape / 2.0)


def _draw_truth(ax: Axes, scene: Scene) -> None:
    from cogmap_gym import figures
    from cogmap_gym.journey_figures import plot_goal

    figures.plot_plan(ax, scene.plan, shut=scene.shut, barriers=scene.barriers)
    for outline in scene.boxes:
        ax.fill(*outline.T, facecolor=figures.GREEN + "60", edgecolor=figures.GREEN, lw=1.0)
    for outline in scene.people:
        ax.fill(*outline.T, facecolor=figures.PURPLE, edgecolor=figures.PURPLE, zorder=3)
    if len(scene.scan):
        ax.plot(*np.asarray(scene.scan).T, ".", color=figures.ORANGE, ms=2.5, zorder=3)
    figures.plot_path(ax, scene.path)
    figures.plot_home(ax, scene.plan.home)
    if scene.goal_pose is not None:
        plot_goal(ax, scene.goal_pose.position)
    _draw_robot(ax, scene.pose, figures.BLUE)
    _draw_scale(ax)
    _write(ax, scene.caption or scene.plan.name)


def _draw_belief(ax: Axes, scene: Scene) -> None:
    from cogmap_gym import figures
    from cogmap_gym.journey_figures import plot_route

    assert scene.sketch is not None, "the right panel is drawn for a sketch only"
    sketch = figures.moved(scene.sketch, scene.plan_from_sketch)
    figures.plot_plan(ax, scene.plan, light=True, names=False)
    figures.plot_asrs(ax, sketch)
    figures.plot_surfaces(ax, sketch, ids=False)  # ids could not be read at this size
    plot_route(ax, sketch, scene.goal)
    if sketch.get("home") is not None:
        figures.plot_home(ax, Pose(*sketch["home"]))
    if sketch.get("pose") is not None:
        _draw_robot(ax, Pose(*sketch["pose"]), figures.BLUE)
    status = sketch.get("status")
    _write(ax, f"believed: {status}" if status else "believed")


def _draw_robot(ax: Axes, pose: Pose, color: str) -> None:
    from matplotlib.patches import Circle

    nose = pose.apply(np.array((2.0 * ROBOT_RADIUS_M, 0.0)))
    ax.add_patch(Circle((pose.x, pose.y), ROBOT_RADIUS_M, color=color, zorder=6))
    ax.plot((pose.x, nose[0]), (pose.y, nose[1]), color=color, lw=2.0, zorder=6)


def _draw_scale(ax: Axes) -> None:
    """A bar of 1, 2 or 5 times a power of ten metres, at most a quarter of the panel."""
    (left, right), bottom = ax.get_xlim(), ax.get_ylim()[0]
    longest = (right - left) / 4.0
    decade = 10.0 ** math.floor(math.log10(longest))
    length = decade * max(n for n in (1.0, 2.0, 5.0) if n * decade <= longest)
    x, y = left + 0.02 * (right - left), bottom + 0.02 * (right - left)
    ax.plot((x, x + length), (y, y), color="black", lw=2.0, solid_capstyle="butt")
    ax.text(x + length, y, f" {length:g} m", fontsize=7, va="center")


def _write(ax: Axes, caption: str) -> None:
    ax.text(0.01, 0.985, caption, transform=ax.transAxes, fontsize=10, va="top")
