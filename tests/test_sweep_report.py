"""The page of a sweep and its figures say what its rows say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from cogmap_gym.sweep_figures import FACTORS, curves_figure, looks, met_figure
from cogmap_gym.sweep_overview import markdown, overviews
from cogmap_gym.sweep_paths import paths_figure
from cogmap_gym.sweep_report import report_page
from cogmap_gym.sweep_table import Row, cells, duels
from tests.sweep_rows import GOALS, SEEN, row

DRIFT = next(factor for factor in FACTORS if "drift" in factor.title)


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def page_of(rows: Sequence[Row], baseline: str = "a") -> str:
    drawn = {"Coverage": curves_figure(rows), "Drift": met_figure(rows, DRIFT, rng())}
    pictures = {title: figure for title, figure in drawn.items() if figure is not None}
    return report_page(rows, cells(rows, rng()), duels(rows, baseline, rng()), baseline, pictures)


def test_the_page_holds_all_and_asks_nothing_of_the_network() -> None:
    page = page_of([*GOALS, *SEEN])
    assert page.count("data:image/png;base64,") == 2
    assert "88 % (75 to 100)" in page
    assert "Against a" in page
    assert "&lt;oops&gt;" in page
    assert "<oops>" not in page
    assert "http" not in page


def test_the_page_tells_code_and_parameters_and_says_where_they_are_mixed() -> None:
    rows = [{**r, "commit": "abc", "params": "123"} for r in SEEN]
    assert "<td>abc</td><td>123</td><td>2</td>" in page_of(rows)
    assert "are mixed" not in page_of(rows)
    assert "are mixed" in page_of([*rows, {**rows[0], "commit": "def", "seed": "1"}])


def test_what_the_rows_do_not_hold_is_left_out() -> None:
    assert curves_figure(GOALS) is None
    assert met_figure(GOALS, DRIFT, rng()) is None
    assert "Against" not in page_of(GOALS, "nobody")


def test_a_curve_is_the_middle_of_all_trials_broken_ones_too() -> None:
    told = enumerate(("0;1", "0;1", "0;0"))
    rows = [row("a", "explore", "low", k, curve=c, distance_curve=c) for k, c in told]
    figure = curves_figure(rows)
    assert figure is not None
    for ax in figure.axes:
        (line,) = ax.lines
        assert np.asarray(line.get_ydata()).tolist() == pytest.approx([0.0, 200 / 3])
        assert "[" in ax.get_xlabel()


@pytest.mark.parametrize(
    ("title", "classes"),
    [
        ("Success against drift", ["low", "high"]),
        ("Success against office size", ["0 to 99", "200 to 399"]),
        ("Success against furniture moved", ["0", "3 to 5"]),
        ("Success against doors changed", ["1", "4+"]),
    ],
)
def test_the_envelope_has_the_classes_that_were_seen(title: str, classes: list[str]) -> None:
    (factor,) = (factor for factor in FACTORS if factor.title == title)
    figure = met_figure(SEEN, factor, rng())
    assert figure is not None
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == classes


def test_a_level_that_does_not_vary_is_no_figure() -> None:
    (factor,) = (factor for factor in FACTORS if "living" in factor.title)
    assert met_figure(SEEN, factor, rng()) is None


def test_paths_are_drawn_a_panel_a_robot_on_the_trial_of_most_robots() -> None:
    alone = {**SEEN[0], "seed": "7"}
    rows = [alone, *({**SEEN[0], "agent": name} for name in ("a", "b", "c"))]
    figure = paths_figure(rows, "explore")
    assert figure is not None
    assert len(figure.axes) == 3
    assert [ax.get_title().split(":")[0] for ax in figure.axes] == ["a", "b", "c"]
    path = figure.axes[0].lines[0]
    assert np.asarray(path.get_xydata()).tolist() == [[1.0, 1.0], [3.0, 1.0]]
    assert "seed 0" in str(figure.get_suptitle())
    assert paths_figure(rows, "goto") is None


def test_success_is_drawn_at_its_level_with_a_line_a_robot() -> None:
    figure = met_figure(SEEN, DRIFT, rng())
    assert figure is not None
    (ax,) = figure.axes
    (line,) = (bar.lines[0] for bar in ax.containers)
    assert np.asarray(line.get_ydata()).tolist() == [100.0, 0.0]
    assert [text.get_text() for text in ax.get_xticklabels()] == ["low", "high"]
    assert "[%]" in ax.get_ylabel()


def test_no_two_of_many_robots_look_alike() -> None:
    drawn = looks([row(f"robot {k}", "explore", "low", 0) for k in range(20)])
    assert len(set(drawn.values())) == 20


def test_at_a_glance_a_robot_is_a_line_the_best_first() -> None:
    rows = [*GOALS, *SEEN]
    low, high = overviews(rows, cells(rows, rng()))
    assert (low.odometry, high.odometry) == ("low", "high")
    assert low.head == (
        "robot", "trials", "explore: saw 95 %", "coverage AUC", "goto", "CPU a step [ms]",
        "map [kB]",
    )  # fmt: skip
    assert [line[:2] for line in low.lines] == [("a", "3"), ("b", "1")]
    assert low.lines[0][4] == "88 % (75-100)"
    assert low.lines[0][5] == "2.0"
    assert low.lines[1][2:4] == ("-", "-"), "b never explored"
    told = markdown(low).splitlines()
    assert told[0] == "## low odometry"
    assert told[3].count("---") == len(low.head) == told[4].count("|") - 1
