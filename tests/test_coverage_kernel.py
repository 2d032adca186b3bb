"""Coverage that visits cells against coverage that walks along beams."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.coverage import Coverage
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.grid import mark_seen
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.tile_kernel import Tiles, blocks_of, tiles_of
from cogmap_gym.world import World
from tests.rooms import l_room, room_with_pillar

LASERS = [
    LaserSpec(),
    LaserSpec(first_angle=-math.pi, step=math.radians(1.0), beams=360),
    LaserSpec(first_angle=-0.5, step=0.05, beams=21, range_max=3.0),
]


def cells_of(tiles: Tiles, shape: tuple[int, int]) -> np.ndarray:
    """Which cells' bits are set."""
    bits = (tiles[:, :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    rows, columns = tiles.shape
    cells = bits.reshape(rows, columns, 8, 8).swapaxes(1, 2).reshape(rows * 8, columns * 8)
    return cells[: shape[0], : shape[1]].astype(bool)


def test_tiles_hold_the_cells() -> None:
    cells = np.random.default_rng(0).random((37, 70)) < 0.3
    tiles = tiles_of(cells)
    assert tiles.shape == (8, 12)
    assert (cells_of(tiles, cells.shape) == cells).all()
    assert blocks_of(tiles).sum() == np.count_nonzero(tiles)


@pytest.mark.parametrize("laser", LASERS)
@pytest.mark.parametrize(
    "plan", [FloorPlan.load("thesis_office"), l_room(), room_with_pillar()], ids=lambda p: p.name
)
def test_it_sees_the_cells_that_beams_pass_through(plan: FloorPlan, laser: LaserSpec) -> None:
    world, rng = World(plan, RobotSpec()), np.random.default_rng(3)
    coverage = Coverage(world, laser)
    grid, total = coverage._grid, coverage._total
    uncounted = ~cells_of(coverage._unseen, grid.shape)
    seen = uncounted.copy()
    for _ in range(30):
        world._body.pose = world.pose @ Pose(0.0, 0.0, float(rng.uniform(-1.0, 1.0)))
        world.move(0.0, float(rng.uniform(0.0, 3.0)))
        pose = world.pose
        new = coverage.look(pose)
        ranges, directions = world.caster.ranges(pose, laser), laser.angles + pose.theta
        true = mark_seen(seen, grid.x0, grid.y0, pose.position, directions, ranges)
        assert abs(new * total - true) <= 4
        assert (coverage._blocks == blocks_of(coverage._unseen)).all()
    unlike = cells_of(coverage._unseen, grid.shape) != ~seen
    assert np.count_nonzero(unlike) <= 4
    assert coverage.share > 0.02
