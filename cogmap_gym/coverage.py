"""How much of the free space the robot has truly seen, in cells of 0.1 m."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from cogmap_gym.coverage_kernel import look_once, scratch_of
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, Segments
from cogmap_gym.grid import CELL_M, Grid, Mask
from cogmap_gym.observation import LaserSpec
from cogmap_gym.tile_kernel import blocks_of, tiles_of
from cogmap_gym.world import World

WALL_M = 0.06
"""Cells whose centre is nearer to a wall do not count [m]: over half a cell, so that a thin
wall parts the cells on its two sides."""


class Coverage:
    """The share of the reachable free space that beams without noise have passed through.

    What counts is what can be reached from home with the doors as the plan has them at
    first; what lies behind a door that is shut then never counts.
    """

    def __init__(self, world: World, laser: LaserSpec) -> None:
        """Find the cells that count, with the world as it stands now."""
        self._world, self._laser = world, laser
        self._grid = Grid.over(world.plan.walls_and_furniture())
        counts = reachable(self._grid, world.plan, world.solid_segments)
        self._all = tiles_of(counts)
        self._total = max(int(counts.sum()), 1)
        self._last, self._centred = laser.beams - 1, laser.mount == (0.0, 0.0, 0.0)
        turns = (np.arange(laser.beams) - 0.5 * self._last) * laser.step
        self._fan = np.stack((np.cos(turns), np.sin(turns)))
        self._middle = laser.first_angle + 0.5 * self._last * float(laser.step)
        self._scratch = scratch_of(laser.beams)
        self.forget()

    @property
    def share(self) -> float:
        """Seen free area over all reachable free area, 0 to 1."""
        return self._count / self._total

    def forget(self) -> None:
        """Begin again with nothing seen."""
        self._unseen, self._blocks = self._all.copy(), blocks_of(self._all)
        self._count = 0

    def look(self, pose: Pose) -> float:
        """Mark what is visible from the robot's ``pose``; answer the share that is new."""
        eye = pose if self._centred else pose @ self._laser.robot_from_laser
        ranges = self._world.caster.ranges(eye, self._laser)
        x, y = (eye.x - self._grid.x0) / CELL_M, (eye.y - self._grid.y0) / CELL_M
        new = look_once(
            self._unseen, self._blocks, x, y, eye.theta + self._middle, self._fan, self._last,
            float(self._laser.step), ranges, self._scratch,
        )  # fmt: skip
        self._count += int(new)
        return int(new) / self._total


def reachable(grid: Grid, plan: FloorPlan, solid: Segments) -> Mask:
    """The cells that hang together with home, away from all that is ``solid`` (N, 2, 2) [m]."""
    xs, ys = grid.centres()
    left, low, right, high = plan.bounds
    inside = (xs > left) & (xs < right) & (ys > low) & (ys < high)
    labels, _ = ndimage.label(inside & ~grid.near(solid, WALL_M))
    return np.asarray(labels == labels[grid.cell(plan.home.x, plan.home.y)])
