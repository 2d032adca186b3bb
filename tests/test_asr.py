"""Algorithm 6: the ASR just left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from agents.cogmap.asr import ASR, compute_asr
from agents.cogmap.params import Boundary
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments
from tests.mfis_figures import WELL_SEEN, cut, measure, scene_of
from tests.mfis_rooms import Scene

SEEDS = range(20)


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    return [scene_of(seed) for seed in SEEDS]


def same_area(a: Points, b: Points) -> bool:
    """Whether two polygons cover the same area, or both are open."""
    if len(a) == 0 or len(b) == 0:
        return len(a) == len(b)
    difference = shapely.Polygon(a).symmetric_difference(shapely.Polygon(b)).area
    return bool(difference < 1e-6)


def mapped(scene: Scene, move: Pose) -> Scene:
    parts = ("surfaces", "exit_crossed", "other_exits", "path")
    return replace(scene, **{name: move.apply(getattr(scene, name)) for name in parts})


def mirrored(scene: Scene) -> Scene:
    flip = np.array((1.0, -1.0))
    return replace(
        scene,
        surfaces=(scene.surfaces * flip)[:, ::-1],
        exit_crossed=scene.exit_crossed * flip,
        other_exits=scene.other_exits * flip,
        path=scene.path * flip,
    )


def box_room() -> Scene:
    """A room 6 m by 4 m, a door of 0.9 m in its east wall, entered from the west."""
    walls = np.array(
        [
            [[0.0, 0.0], [6.0, 0.0]],
            [[6.0, 0.0], [6.0, 1.5]],
            [[6.0, 2.4], [6.0, 4.0]],
            [[6.0, 4.0], [0.0, 4.0]],
            [[0.0, 4.0], [0.0, 2.5]],
            [[0.0, 1.6], [0.0, 0.0]],
            [[9.0, 0.0], [9.0, 4.0]],
        ]
    )
    door = np.array([[6.0, 1.5], [6.0, 2.4]])
    entry = np.array([[[0.0, 1.6], [0.0, 2.5]]])
    path = np.array([[0.2, 2.0], [2.0, 2.1], [4.0, 1.9], [6.5, 2.0]])
    room = shapely.box(0, 0, 6, 4)
    return Scene("box", room, shapely.Polygon(), walls, door, entry, path, 1.0)


@pytest.mark.parametrize("params", [Boundary(), Boundary.literal()], ids=["ours", "literal"])
def test_a_plain_room_is_cut_out_along_its_walls(params: Boundary) -> None:
    asr = cut(box_room(), params)
    assert asr.closed
    assert shapely.LinearRing(asr.boundary).is_ccw
    assert shapely.Polygon(asr.boundary).symmetric_difference(box_room().room).area < 4.0


def test_our_boundary_of_a_plain_room_is_exact_and_names_its_walls() -> None:
    asr = cut(box_room(), Boundary())
    assert shapely.Polygon(asr.boundary).symmetric_difference(box_room().room).area < 1e-9
    assert sorted(asr.boundary_surfaces) == sorted(asr.surfaces) == [0, 1, 2, 3, 4, 5]


def test_most_rooms_close_and_follow_the_true_walls() -> None:
    figures = measure(range(50), Boundary())
    well_seen = figures.seen > WELL_SEEN
    assert figures.closed.mean() >= 0.95
    assert np.median(figures.overlap) >= 0.9
    assert np.mean(figures.overlap[well_seen] >= 0.85) >= 0.9


def test_our_walk_closes_more_rooms_than_the_text() -> None:
    ours, text = measure(SEEDS, Boundary()), measure(SEEDS, Boundary.literal())
    assert ours.closed.mean() > text.closed.mean()


def test_a_boundary_is_simple_counter_clockwise_and_contains_the_path(scenes: list[Scene]) -> None:
    for scene in scenes:
        asr = cut(scene, Boundary())
        polygon = shapely.Polygon(asr.boundary)
        assert polygon.is_valid
        assert polygon.exterior.is_ccw
        before = shapely.LineString(scene.path[:-1])
        assert before.intersection(polygon).length >= 0.8 * before.length


def test_boundary_surfaces_are_its_own(scenes: list[Scene]) -> None:
    for scene in scenes:
        asr = cut(scene, Boundary())
        assert set(asr.boundary_surfaces) <= set(asr.surfaces)


@pytest.mark.parametrize("params", [Boundary(), Boundary.literal()], ids=["ours", "literal"])
def test_a_rigid_motion_of_everything_moves_the_boundary(
    scenes: list[Scene], params: Boundary
) -> None:
    move = Pose(31.0, -17.0, 2.3)
    for scene in scenes:
        still, moved = cut(scene, params), cut(mapped(scene, move), params)
        assert same_area(move.apply(still.boundary), moved.boundary)
        np.testing.assert_array_equal(still.surfaces, moved.surfaces)


def test_the_order_of_rows_does_not_matter(scenes: list[Scene]) -> None:
    rng = np.random.default_rng(7)
    for scene in scenes:
        order = rng.permutation(len(scene.surfaces))
        exits = scene.other_exits[::-1, ::-1]
        args = (scene.surfaces[order], order, scene.exit_crossed[::-1], exits, scene.path)
        mixed, plain = compute_asr(1, *args, Boundary()), cut(scene, Boundary())
        assert same_area(plain.boundary, mixed.boundary)
        assert set(plain.surfaces) == set(mixed.surfaces)
        assert set(plain.boundary_surfaces) == set(mixed.boundary_surfaces)


def test_a_mirrored_room_has_the_mirrored_boundary(scenes: list[Scene]) -> None:
    for scene in scenes:
        plain, mirror = cut(scene, Boundary()), cut(mirrored(scene), Boundary())
        assert same_area(plain.boundary * np.array((1.0, -1.0)), mirror.boundary)


def bare(surfaces: Segments, path: Points, params: Boundary) -> ASR:
    door = np.array([[6.0, 1.5], [6.0, 2.4]])
    return compute_asr(3, surfaces, np.arange(len(surfaces)), door, NO_SEGMENTS, path, params)


@pytest.mark.parametrize("params", [Boundary(), Boundary.literal()], ids=["ours", "literal"])
def test_without_surfaces_nothing_closes(params: Boundary) -> None:
    asr = bare(NO_SEGMENTS, box_room().path, params)
    assert not asr.closed
    assert asr.boundary.shape == (0, 2)
    assert asr.surfaces.shape == asr.boundary_surfaces.shape == (0,)


@pytest.mark.parametrize("params", [Boundary(), Boundary.literal()], ids=["ours", "literal"])
@pytest.mark.parametrize(
    "path",
    [
        [[5.0, 2.0]],
        [[6.0, 2.0], [6.0, 2.0]],
        [[3.0, 0.0], [6.0, 1.5], [6.0, 2.4], [6.5, 2.0]],
        [[7.0, 2.0], [5.0, 2.0], [7.0, 2.1]],
        [[1.0, 1.0], [2.0, 1.0]],
        [[5.0, 2.0], [7.0, 2.0], [5.0, 1.9], [3.0, 1.0], [7.0, 2.0]],
    ],
)
def test_odd_paths_do_not_crash(path: list[list[float]], params: Boundary) -> None:
    walls = box_room().surfaces
    doubled = np.concatenate((walls, walls[:2], walls[:1, :1].repeat(2, axis=1)))
    assert bare(doubled, np.array(path), params).id == 3


def test_more_surfaces_on_a_later_visit_close_what_was_open() -> None:
    room = box_room()
    first = bare(room.surfaces[2:3], room.path, Boundary())
    later = cut(room, Boundary())
    assert later.closed
    assert first.boundary.shape[1] == 2


def test_a_room_left_by_the_door_it_was_entered_by_is_closed() -> None:
    room = box_room()
    walls = np.concatenate((room.surfaces[:4], [[[0.0, 4.0], [0.0, 0.0]]]))
    path = np.array([[6.3, 2.0], [5.5, 2.0], [3.0, 2.5], [2.0, 1.5], [5.0, 1.8], [6.4, 1.9]])
    asr = bare(walls, path, Boundary())
    assert shapely.Polygon(asr.boundary).symmetric_difference(room.room).area < 1e-9
