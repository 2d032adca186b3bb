"""A run that failed: the truth beside the belief, with the way to the goal that was missed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from matplotlib.figure import Figure

from cogmap_gym.colors import BLACK, GREEN, PURPLE
from cogmap_gym.experiment_figures import overview_figure
from cogmap_gym.figures import Sketch
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.tasks import HOME


def failure_figure(
    plan: FloorPlan, poses: Array, sketch: Sketch | None, believed: Points,
    marks: Mapping[int, Pose], title: str, mark: int = 0, way: Points | None = None,
    shut: Iterable[str] = (),
) -> Figure:  # fmt: skip
    """Draw it.

    Args:
        plan: the truth.
        poses: (T, 3), true, from home on.
        sketch: what the robot believes at the end, in its own frame; None if it tells nothing.
        believed: (T, 2), its path as it believes, in the sketch's frame.
        marks: where they truly are.
        title: of the figure; parts after a semicolon begin a line.
        mark: the goal that was missed first; 0 for none.
        way: (N, 2), the true path on the way there.
        shut: names of the doors that were shut then.
    """
    home = Pose(*(float(value) for value in poses[0]))
    text = "\n".join(title.split("; "))
    figure = overview_figure(plan, poses[:, :2], sketch, believed, home, text, shut)
    ax = figure.axes[0]
    for number, pose in marks.items():
        if number != HOME:
            ax.plot(pose.x, pose.y, "*", color=PURPLE, ms=14, zorder=8)
            ax.annotate(
                f"mark {number}", (pose.x, pose.y), (0, 9), textcoords="offset points", zorder=9,
                ha="center", fontsize=9, bbox={"fc": "white", "ec": "none", "alpha": 0.7, "pad": 1},
            )  # fmt: skip
    if way is not None and len(way):
        label = f"on the way to mark {mark}"
        ax.plot(*way.T, color=GREEN, lw=2, zorder=6, label=label)
    ax.plot(*poses[-1, :2], "X", color=BLACK, ms=10, zorder=8, label="end")
    ax.legend(loc="upper left", fontsize="small")
    return figure
