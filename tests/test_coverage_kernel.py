"""Coverage that visits cells against coverage that walks along beams."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.coverage import Coverage
from cogmap_gym.coverage_kernel import SPAN, Tiles, blocks_of, look, tiles_of
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.grid import CELL_M
from cogmap_gym.observation import LaserSpec, RobotSpec
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
    coverage, grid = Coverage(world, laser), Coverage(world, laser)._grid
    tiles = tiles_of(~coverage._uncounted)
    blocks, longest = blocks_of(tiles), np.zeros(laser.beams // SPAN + 1)
    turns = (np.arange(laser.beams) - 0.5 * (laser.beams - 1)) * laser.step
    fan = np.stack((np.cos(turns), np.sin(turns)))
    middle = laser.first_angle + 0.5 * (laser.beams - 1) * laser.step
    pose = plan.home
    for _ in range(30):
        world._body.pose = pose = world.pose @ Pose(0.0, 0.0, float(rng.uniform(-1.0, 1.0)))
        world.move(0.0, float(rng.uniform(0.0, 3.0)))
        pose = world.pose
        before = coverage.share
        coverage.look(pose)
        new = look(
            *(tiles, blocks, (pose.x - grid.x0) / CELL_M, (pose.y - grid.y0) / CELL_M),
            *(pose.theta + middle, fan, laser.beams - 1, laser.step),
            *(world.caster.ranges(pose, laser), longest),
        )
        assert abs(new / coverage._total - (coverage.share - before)) <= 4 / coverage._total
        assert (blocks == blocks_of(tiles)).all()
    unlike = cells_of(tiles, grid.shape) != ~coverage._seen
    assert np.count_nonzero(unlike) <= 4
    assert coverage.share > 0.02
