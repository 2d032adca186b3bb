"""The figures of a journey show what was planned, what was weighed and what stood in the way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cogmap_gym import journey_figures as fig
from cogmap_gym.saving import save_png

PATH = np.array([[1.0, 1.0], [1.5, 1.0]])
SOLIDS = {"B5": np.array([[0.0, 1.5], [2.0, 1.5]])}


def sketch(**changes: Any) -> dict[str, Any]:
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    return {
        "surfaces": [{"id": 3, "p": [0.0, 0.0], "q": [2.0, 0.0]}],
        "exits": [{"id": 1, "p": [2.0, 0.5], "q": [2.0, 1.5]}],
        "asrs": [{"id": 1, "boundary": square, "exits": [1]}],
        "links": [[1, 1, 2]],
        "here": 1,
        "pose": [1.0, 1.0, 0.5],
        "home": [1.0, 1.0],
        "marks": [{"id": 2, "asr": 2, "point": [4.0, 1.0]}],
        "route": [1],
        "status": "to mark 2",
    } | changes


def legend(ax: Axes) -> set[str]:
    return set(ax.get_legend_handles_labels()[1])


def line(ax: Axes, label: str) -> np.ndarray:
    (found,) = (row for row in ax.lines if row.get_label() == label)
    return np.asarray(found.get_xydata())


def test_only_a_phase_with_a_goal_has_a_picture_of_its_way() -> None:
    phase = {"task": "goto:2", "success": False, "moves": 3}
    names = fig.phase_figures(4, phase, sketch(), PATH, 2, PATH, SOLIDS)
    assert set(names) == {f"phase4_goto_2_{kind}" for kind in ("mfis", "network", "path")}
    explored = fig.phase_figures(1, {**phase, "task": "explore"}, sketch(), PATH)
    assert set(explored) == {"phase1_explore_mfis", "phase1_explore_network"}
    way = names["phase4_goto_2_path"].axes[0]
    assert {"planned at the start", "path", "goal"} <= legend(way)
    for name in ("phase4_goto_2_path", "phase4_goto_2_mfis"):
        assert "barrier or shut door, in truth" in legend(names[name].axes[0])


def test_each_option_is_drawn_with_its_exits_and_its_estimate(tmp_path: Path) -> None:
    ends = np.array([[1.0, 1.0], [4.0, 1.0]])
    options = [
        fig.Option("known", (4, 3), ends, 30.0),
        fig.Option("back", (5, 6), ends, 62.04),
        fig.Option("new", (7,), ends, 25.1),
        fig.Option("new", (8,), ends, 27.0),
    ]
    figure = fig.options_figure(sketch(), options, 7, "choosing", 2, SOLIDS)
    assert save_png(figure, tmp_path / "choice.png").exists()
    assert {
        "known way, shut: E4-E3, 30.0 m",
        "going back: E5-E6, 62.0 m",
        "new exit, then straight to the goal: E7, 25.1 m (chosen)",
        "new exit, then straight to the goal: E8, 27.0 m",
    } <= legend(figure.axes[0])


@pytest.mark.parametrize(
    ("changes", "points"),
    [
        ({}, [[1, 1], [2, 1], [4, 1]]),
        ({"route": [], "here": 2}, [[1, 1], [4, 1]]),
        ({"route": []}, None),
        ({"route": None}, None),
        ({"marks": []}, None),
    ],
    ids=["over an exit", "in the place itself", "not yet planned", "no route", "unknown mark"],
)
def test_a_planned_way_leads_over_its_exits_to_the_mark(
    changes: dict[str, Any], points: list[list[float]] | None
) -> None:
    ax = Figure().add_subplot()
    fig.plot_route(ax, sketch(**changes), 2)
    assert ("way planned" in legend(ax)) == (points is not None)
    assert ("goal" in legend(ax)) == (changes.get("marks") != [])
    if points is not None:
        assert np.allclose(line(ax, "way planned"), points)
