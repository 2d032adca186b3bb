"""Bitmaps become line walls: near the pixels, without noise, with home and rooms."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from shapely.geometry import MultiLineString, Point
from skimage.draw import disk, polygon

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, lengths
from tests.drawings import CELL, FREE, GREY, WALL, two_rooms, write_ros


def edges_of(pixels: Any, plan_from_raster: Pose) -> shapely.Geometry:
    """The edges between free pixels and others, in the plan's frame, by the obvious way."""
    rows, columns = np.nonzero(np.flipud(pixels) == FREE)
    squares = shapely.box(columns, rows, columns + 1.0, rows + 1.0)
    return shapely.transform(
        shapely.union_all(squares).boundary, lambda points: plan_from_raster.apply(CELL * points)
    )


def walls_of(plan: FloorPlan) -> shapely.Geometry:
    return MultiLineString([line.tolist() for line in plan.walls])


def hall_with(rng: np.random.Generator) -> Any:
    """A hall of 8 x 6 m with tilted walls and some pillars, square, tilted and round."""
    pixels = np.full((120, 160), WALL, dtype=np.uint8)
    shift = rng.uniform(-4.0, 4.0, (4, 2))
    corners = np.array(((8, 8), (8, 152), (112, 152), (112, 8))) + shift
    pixels[polygon(*corners.T, shape=pixels.shape)] = FREE
    for row, column in ((30, 40), (30, 120), (90, 40), (90, 120)):
        turn, size = rng.uniform(0.0, np.pi), rng.uniform(4.0, 12.0)
        angle = turn + np.arange(4) * np.pi / 2.0
        square = np.array((row, column)) + size * np.column_stack((np.cos(angle), np.sin(angle)))
        is_round = rng.random() < 0.5
        cells = disk((row, column), size) if is_round else polygon(*square.T, shape=pixels.shape)
        pixels[cells] = WALL
    return pixels


@pytest.mark.parametrize("seed", range(1000, 1012))
def test_walls_and_pixel_edges_keep_within_one_and_a_half_pixels(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    pixels, turn = hall_with(rng), rng.uniform(-np.pi, np.pi)
    path = write_ros(tmp_path, pixels, origin=f"[3.0, -7.0, {turn}]")
    plan = FloorPlan.load(path)
    edges = edges_of(pixels, Pose(3.0, -7.0, turn))
    gap = shapely.hausdorff_distance(walls_of(plan), edges, densify=0.01)
    assert gap <= 1.5 * CELL
    assert len(plan.wall_segments()) < 150


def test_straight_walls_come_out_straight_and_exact(tmp_path: Path) -> None:
    plan = FloorPlan.load(write_ros(tmp_path, two_rooms()))
    assert len(plan.walls) == 1
    assert len(plan.wall_segments()) == 12
    gap = walls_of(plan).hausdorff_distance(edges_of(two_rooms(), Pose()))
    assert gap < 0.05 * CELL
    assert plan.bounds == pytest.approx((0.25, 0.25, 6.45, 3.25), abs=0.005)


def test_specks_and_rays_are_taken_away_and_legs_of_tables_stay(tmp_path: Path) -> None:
    noisy = two_rooms()
    noisy[10:60:7, 10:60:7] = WALL  # single pixels
    noisy[20, 80:83] = GREY
    noisy[2:4, 0:60] = FREE  # a ray along the outside
    noisy[0:5, 30:32] = FREE  # and one that leads there
    noisy[50:52, 100:102] = WALL  # the leg of a table: 0.1 m
    plan = FloorPlan.load(write_ros(tmp_path, noisy))
    assert len(plan.walls) == 2
    assert len(plan.wall_segments()) < 24
    assert plan.bounds == pytest.approx((0.25, 0.25, 6.45, 3.25), abs=0.06)


def test_only_the_free_space_that_holds_home_is_kept(tmp_path: Path) -> None:
    shut = two_rooms()
    shut[:, 65:69] = WALL
    shut[5:65, 64] = WALL  # the left room is smaller now
    right = FloorPlan.load(write_ros(tmp_path, shut))
    left = FloorPlan.load(write_ros(tmp_path, shut, home="[1.0, 1.0, 90]"))
    assert right.bounds[0] > 3.4
    assert left.bounds[2] < 3.4
    assert left.to_mapping()["home"] == [1.0, 1.0, 90.0]


def test_home_is_the_most_open_point_of_the_largest_free_space(tmp_path: Path) -> None:
    plan = FloorPlan.load(write_ros(tmp_path, two_rooms()))
    middles = (1.75, 1.75), (4.95, 1.75)
    assert min(np.hypot(plan.home.x - x, plan.home.y - y) for x, y in middles) < 0.3
    white = np.where(two_rooms() == GREY, FREE, two_rooms()).astype(np.uint8)
    outside = FloorPlan.load(write_ros(tmp_path, np.pad(white, 30, constant_values=FREE)))
    assert outside.area == pytest.approx(plan.area, abs=0.01), "home is not outside the house"


def test_the_origin_turns_and_shifts_the_plan(tmp_path: Path) -> None:
    upright = FloorPlan.load(write_ros(tmp_path, two_rooms()))
    turned = FloorPlan.load(write_ros(tmp_path, two_rooms(), origin="[10.0, 20.0, 0.7]"))
    place = Pose(10.0, 20.0, 0.7)
    assert np.allclose(place.apply(upright.walls[0]), turned.walls[0])
    assert np.allclose(place.apply(upright.home.position), turned.home.position)
    assert turned.area == pytest.approx(upright.area)


def test_the_top_row_of_an_image_has_the_largest_y(tmp_path: Path) -> None:
    pixels = np.full((60, 60), WALL, dtype=np.uint8)
    pixels[5:25, 5:45] = FREE
    assert FloorPlan.load(write_ros(tmp_path, pixels)).bounds == pytest.approx(
        (0.25, 35 * CELL, 45 * CELL, 55 * CELL), abs=0.01
    )


def test_rooms_are_parted_at_the_doorway(tmp_path: Path) -> None:
    plan = FloorPlan.load(write_ros(tmp_path, two_rooms()))
    assert plan.room_at(1.0, 1.0) != plan.room_at(6.0, 1.0)
    assert {plan.room_at(1.0, 1.0), plan.room_at(6.0, 1.0)} == {"R1", "R2"}
    areas = [plan.room_free_space(name).area for name in plan.rooms]
    assert sum(areas) == pytest.approx(plan.area, rel=0.01)
    assert max(areas) < 9.4


def test_rooms_come_from_the_colours_of_an_image(tmp_path: Path) -> None:
    path = write_ros(tmp_path, two_rooms())
    colours = np.zeros((70, 134, 3), dtype=np.uint8)
    colours[:35, :67], colours[35:, :67], colours[:, 67:] = (200, 0, 0), (0, 200, 0), (0, 0, 200)
    Image.fromarray(colours).save(tmp_path / "rooms.png")
    described = {
        "image": str(tmp_path / "map.pgm"),
        "metres_per_pixel": CELL,
        "rooms": str(tmp_path / "rooms.png"),
    }
    plan = FloorPlan.load(json.loads(json.dumps(described)))
    assert len(plan.rooms) == 3
    assert len({plan.room_at(*at) for at in ((1.0, 1.0), (1.0, 2.5), (6.0, 1.0))}) == 3
    with path.open("a") as file:
        file.write("rooms: rooms.png\n")
    assert len(FloorPlan.load(path).rooms) == 3


def test_a_room_that_runs_round_another_holds_its_own_points_alone(tmp_path: Path) -> None:
    pixels = np.full((170, 170), WALL, dtype=np.uint8)
    pixels[5:165, 5:165] = FREE
    pixels[40:130, 40:130] = WALL
    pixels[45:125, 45:125] = FREE
    pixels[38:46, 76:94] = FREE
    plan = FloorPlan.load(write_ros(tmp_path, pixels))
    assert len(plan.rooms) == 2
    middle, around = plan.room_at(4.25, 4.25), plan.room_at(1.0, 1.0)
    assert middle != around
    assert plan.room_at(7.5, 1.0) == plan.room_at(7.5, 7.5) == around
    assert not plan.room_free_space(str(around)).contains(Point(4.25, 4.25))
    inside = sum(plan.room_free_space(name).area for name in plan.rooms)
    assert inside == pytest.approx(plan.area, rel=0.01)


@pytest.mark.parametrize("cell", [0.01, 0.05, 0.1, 0.25])
def test_any_scale_gives_the_same_hall(cell: float, tmp_path: Path) -> None:
    side = round(6.0 / cell)
    pixels = np.pad(np.full((side, side), FREE, dtype=np.uint8), 2, constant_values=WALL)
    plan = FloorPlan.load(write_ros(tmp_path, pixels, resolution=cell))
    assert plan.area == pytest.approx(36.0, abs=0.1)
    assert len(plan.wall_segments()) == 4
    assert lengths(plan.wall_segments()) == pytest.approx([6.0] * 4, abs=0.02)
