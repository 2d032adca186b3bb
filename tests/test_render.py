"""Frames need no display and hide nothing; ids on a figure never cover one another."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from cogmap_gym import figures, labels
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.legend import handles
from cogmap_gym.render import Scene, draw, draw_legend

TWO_ROOMS = {
    "name": "two_rooms",
    "walls": [[[0, 0], [8, 0], [8, 5], [0, 5], [0, 0]], [[4, 0], [4, 2]], [[4, 3], [4, 5]]],
    "furniture": [[[1, 4], [2, 4], [2, 4.5], [1, 4.5]]],
    "doors": {"E1": [[4, 2], [4, 3]]},
    "closed": [],
    "barriers": {"B1": [[0, 3.5], [4, 3.5]]},
    "rooms": {
        "R1": [[0, 0], [4, 0], [4, 5], [0, 5]],
        "R2": [[4, 0], [8, 0], [8, 5], [4, 5]],
    },
    "home": [2, 2.5, 0],
}
SKETCH: dict[str, Any] = {
    "surfaces": [
        {"id": 7, "p": [-2.0, -2.5], "q": [6.0, -2.5]},
        {"id": 8, "p": [6.0, -2.5], "q": [6.0, 2.5]},
    ],
    "exits": [{"id": 1, "p": [2.0, -0.5], "q": [2.0, 0.5]}],
    "asrs": [
        {"id": 1, "boundary": [[-2, -2.5], [2, -2.5], [2, 2.5], [-2, 2.5]], "exits": [1]},
        {"id": 2, "boundary": [], "exits": [1]},
        {"id": 3, "boundary": [], "exits": []},
    ],
    "links": [[1, 1, 2], [2, 9, 3]],
    "here": 1,
    "pose": [0.0, 0.0, 0.0],
    "home": [0.0, 0.0, 0.0],
    "marks": {},
    "route": None,
    "status": "explore",
}


@pytest.fixture(scope="module")
def scene() -> Scene:
    plan = FloorPlan.load(TWO_ROOMS)
    path = np.array([[2.0, 2.5], [3.0, 2.0]])
    return Scene(plan, Pose(3.0, 2.0, 0.5), path=path, plan_from_sketch=plan.home)


def canvas() -> tuple[FigureCanvasAgg, Any]:
    figure = Figure(figsize=(5, 5), dpi=80)
    return FigureCanvasAgg(figure), figure.add_subplot()


def written(axes: Any) -> list[Text]:
    """The labels that a rendering left on the paper."""
    found = [label.text for label in labels.labels_of(axes)._labels]
    return [text for text in found if text.get_position() != (0.0, 0.0)]


def test_a_frame_has_the_size_and_type_that_a_video_needs(scene: Scene) -> None:
    frame = draw(scene, (120, 241))
    assert frame.shape == (120, 241, 3)
    assert frame.dtype == np.uint8


def test_every_frame_is_a_fresh_array_with_the_same_bits(scene: Scene) -> None:
    first, second = draw(scene, (120, 240)), draw(scene, (120, 240))
    assert np.array_equal(first, second)
    assert not np.shares_memory(first, second)
    assert first.flags.writeable


@pytest.mark.parametrize(
    "change",
    [
        {"pose": Pose(6.0, 4.0, 0.0)},
        {"pose": Pose(3.0, 2.0, 2.5)},
        {"shut": ("E1",)},
        {"barriers": ("B1",)},
        {"scan": np.array([[4.0, 1.0], [3.0, 5.0]])},
        {"path": np.array([[2.0, 2.5], [2.0, 1.0]])},
        {"sketch": SKETCH},
    ],
    ids=lambda change: next(iter(change)),
)
def test_whatever_changes_in_the_scene_changes_the_frame(
    scene: Scene, change: dict[str, Any]
) -> None:
    assert not np.array_equal(draw(scene), draw(dataclasses.replace(scene, **change)))


def test_the_belief_stands_beside_the_truth_and_leaves_it_as_it_is(scene: Scene) -> None:
    one = draw(dataclasses.replace(scene, sketch=SKETCH))
    lost = draw(dataclasses.replace(scene, sketch=SKETCH, plan_from_sketch=Pose(2.5, 2.0, 0.4)))
    half = one.shape[1] // 2
    assert np.array_equal(one[:, :half], lost[:, :half])
    assert not np.array_equal(one[:, half:], lost[:, half:])


def test_an_agent_that_believes_nothing_yet_can_be_drawn(scene: Scene) -> None:
    nothing = {"surfaces": [], "exits": [], "asrs": [], "links": [], "here": None}
    assert draw(dataclasses.replace(scene, sketch=nothing)).shape == (480, 960, 3)


def test_every_colour_of_a_frame_is_in_the_legend_and_fits() -> None:
    strip = draw_legend((70, 1400))
    assert strip.shape == (70, 1400, 3)
    assert strip.dtype == np.uint8
    edge = np.concatenate((strip[0], strip[-1], strip[:, 0], strip[:, -1]))
    assert (edge == 255).all(), "nothing is cut off"
    shown = {handle.get_label() for handle in handles()}
    assert {"wall", "furniture", "shut door", "barrier", "path", "home", "goal"} <= shown


def test_a_frame_too_small_to_draw_on_is_refused(scene: Scene) -> None:
    with pytest.raises(ValueError, match="at least 64"):
        draw(scene, (480, 10))


@given(x=st.floats(-50, 50), y=st.floats(-50, 50), theta=st.floats(-3.1, 3.1, allow_nan=False))
def test_a_moved_sketch_moved_back_is_the_sketch(x: float, y: float, theta: float) -> None:
    there = Pose(x, y, theta)
    back = figures.moved(figures.moved(SKETCH, there), there.inverse())
    for key in ("surfaces", "exits"):
        for old, new in zip(SKETCH[key], back[key], strict=True):
            assert np.allclose([old["p"], old["q"]], [new["p"], new["q"]], atol=1e-9)
    assert np.allclose(SKETCH["asrs"][0]["boundary"], back["asrs"][0]["boundary"], atol=1e-9)
    assert np.allclose(back["pose"], SKETCH["pose"], atol=1e-9)


def test_moving_a_sketch_leaves_the_original_untouched() -> None:
    before = repr(SKETCH)
    figures.moved(SKETCH, Pose(1.0, 2.0, 0.3))
    assert repr(SKETCH) == before


def test_ids_never_cover_one_another_however_crowded_the_map() -> None:
    rng = np.random.default_rng(5)
    start = rng.uniform(0.0, 10.0, (150, 2))
    angle = rng.uniform(-math.pi, math.pi, 150)
    surfaces = np.stack((start, start + np.stack((np.cos(angle), np.sin(angle)), 1)), axis=1)
    paper, axes = canvas()
    figures.plot_surfaces(axes, surfaces)
    paper.draw()
    boxes = [text.get_window_extent() for text in written(axes)]
    assert 20 < len(boxes) <= 150
    for number, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:number])


def test_every_id_is_written_where_there_is_room() -> None:
    surfaces = np.array([[[0.0, y], [10.0, y]] for y in range(10)])
    paper, axes = canvas()
    figures.plot_surfaces(axes, surfaces)
    paper.draw()
    assert {text.get_text() for text in written(axes)} == {str(row) for row in range(10)}


def test_the_network_places_an_asr_without_boundary_by_its_exits() -> None:
    paper, axes = canvas()
    figures.plot_network(axes, SKETCH)
    figures.finish(axes, "network")
    paper.draw()
    assert sorted(text.get_text() for text in written(axes)) == ["1", "1", "2"]


def test_a_figure_has_metres_on_its_axes_and_equal_scales(scene: Scene) -> None:
    paper, axes = canvas()
    figures.plot_plan(axes, scene.plan, shut=("E1",), barriers=("B1",))
    figures.plot_asrs(axes, SKETCH)
    figures.plot_path(axes, scene.path)
    figures.finish(axes, "plan")
    paper.draw()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")
    one_metre = axes.transData.transform([[1.0, 1.0]]) - axes.transData.transform([[0.0, 0.0]])
    assert one_metre[0, 0] == pytest.approx(one_metre[0, 1])
    names = {text.get_text() for text in axes.get_legend().get_texts()}
    assert {"wall", "furniture", "shut door", "barrier", "ASR", "exit", "path"} <= names
