"""The shortest true distances, for rewards and oracles: a grid geodesic.

Cells of 0.1 m nearer to a wall than the robot's radius are closed. A route may step to
any of 32 neighbours, so that its length is at most 1.3 % above the true shortest one.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from cogmap_gym.geometry import Array, Pose
from cogmap_gym.grid import CELL_M, Grid, Mask
from cogmap_gym.world import World

SLACK_M = 0.04
"""Less than the radius is kept clear [m], or cells of 0.1 m would shut a gap of 0.6 m."""
SNAP_CELLS = 4
"""A pose in a closed cell counts as the nearest open cell within this many cells."""
CACHED_FIELDS = 64
"""How many distance fields are kept; one of 90,000 cells takes 0.7 MB."""
STEPS = ((0, 1), (1, 0), (1, 1), (1, 2), (2, 1), (1, 3), (3, 1), (2, 3), (3, 2))
"""Steps of a route in (rows, columns); each also to the left: with those back, 32."""


class Routes:
    """Shortest true distances in a world, with the doors as they stand at each call."""

    def __init__(self, world: World) -> None:
        """Lay the grid over the world's walls."""
        self._world = world
        self.grid = Grid.over(world.plan.walls_and_furniture())
        self._fields: dict[tuple[object, ...], Array] = {}

    def distance(self, here: Pose, there: Pose) -> float:
        """Length of the shortest route between two poses [m]; infinite if there is none."""
        field = self._field(there)
        row, column = self.grid.cell(here.x, here.y)
        rows = slice(max(row - SNAP_CELLS, 0), row + SNAP_CELLS + 1)
        columns = slice(max(column - SNAP_CELLS, 0), column + SNAP_CELLS + 1)
        near = field[rows, columns]
        reach = np.isfinite(near)
        if field[row, column] < math.inf:
            return self._refined(float(field[row, column]), here, there, (row, column))
        if not reach.any():
            return math.inf
        i, j = np.nonzero(reach)
        gap = np.hypot(i + rows.start - row, j + columns.start - column)
        best = int(gap.argmin())
        return float(near[i[best], j[best]] + CELL_M * gap[best])

    def _refined(self, length: float, here: Pose, there: Pose, cell: tuple[int, int]) -> float:
        """Let a length between cell centres follow the pose within its cell."""
        centre = self.grid.centre(*cell)
        straight = math.hypot(centre[0] - there.x, centre[1] - there.y)
        if straight > length + CELL_M or straight < CELL_M:
            return length
        return max(length + here.distance(there) - straight, 0.0)

    def _field(self, there: Pose) -> Array:
        """Shortest distances from every cell to ``there`` [m], (rows, columns)."""
        goal = self.grid.cell(there.x, there.y)
        key = (goal, self._world.shut_doors, self._world.present_barriers)
        if key not in self._fields:
            if len(self._fields) >= CACHED_FIELDS:
                self._fields.pop(next(iter(self._fields)))
            self._fields[key] = self._computed(goal)
        return self._fields[key]

    def _computed(self, goal: tuple[int, int]) -> Array:
        radius = self._world.robot.radius - SLACK_M
        free = ~self.grid.near(self._world.solid_segments, radius)
        free[goal] = True
        lengths = dijkstra(_graph(free), directed=False, indices=goal[0] * free.shape[1] + goal[1])
        return np.asarray(lengths, dtype=np.float64).reshape(free.shape)


def _graph(free: Mask) -> coo_array:
    """The graph of the free cells (flattened), an edge a step, weighted in metres."""
    index = np.arange(free.size).reshape(free.shape)
    height, width = free.shape
    starts, ends, weights = [], [], []
    for i, j in (*STEPS, *((i, -j) for i, j in STEPS if i and j)):
        here = np.s_[: height - i, max(-j, 0) : width - max(j, 0)]
        there = np.s_[i:, max(j, 0) : width + min(j, 0)]
        both = free[here] & free[there]
        starts.append(index[here][both])
        ends.append(index[there][both])
        weights.append(np.full(starts[-1].size, CELL_M * math.hypot(i, j)))
    rows, columns = np.concatenate(starts), np.concatenate(ends)
    return coo_array((np.concatenate(weights), (rows, columns)), shape=(free.size, free.size))
