"""The shortest true distances, for rewards and oracles: a grid geodesic.

Cells of 0.1 m nearer to a wall than the robot's radius are closed. A route may step to
any of 32 neighbours, so that its length is at most 1.3 % above the true shortest one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from cogmap_gym.geometry import Array, Pose
from cogmap_gym.grid import CELL_M, Grid, Mask
from cogmap_gym.world import World

SLACK_M = 0.04
"""Less than the radius is kept clear [m], or cells of 0.1 m would shut a gap of 0.6 m."""
REACH_CELLS = 2
"""A pose is joined to the open cells this many cells around it, in straight lines."""
CACHED_FIELDS = 64
"""How many distance fields are kept; one of 90,000 cells takes 0.7 MB."""
STEPS = ((0, 1), (1, 0), (1, 1), (1, 2), (2, 1), (1, 3), (3, 1), (2, 3), (3, 2))
"""Steps of a route in (rows, columns); each also to the left: with those back, 32."""
Ints = NDArray[np.int64]


class Routes:
    """Shortest true distances in a world, with the doors as they stand at each call."""

    def __init__(self, world: World) -> None:
        """Lay the grid over the world's walls."""
        self._world = world
        self.grid = Grid.over(world.plan.walls_and_furniture())
        self._fields: dict[tuple[object, ...], Array] = {}

    def distance(self, here: Pose, there: Pose) -> float:
        """Length of the shortest route between two poses [m]; infinite if there is none."""
        straight = here.distance(there)
        if straight <= REACH_CELLS * CELL_M:
            return straight
        cells, legs = self._joined(here)
        return float((self._field(there)[cells] + legs).min())

    def _joined(self, pose: Pose) -> tuple[Ints, Array]:
        """The cells around a pose (flattened) and the distances of their centres [m]."""
        grid, reach = self.grid, REACH_CELLS
        row, column = grid.cell(pose.x, pose.y)
        rows = np.arange(max(row - reach, 0), min(row + reach + 1, grid.rows))
        columns = np.arange(max(column - reach, 0), min(column + reach + 1, grid.columns))
        dx = grid.x0 + CELL_M * (columns + 0.5) - pose.x
        dy = grid.y0 + CELL_M * (rows + 0.5) - pose.y
        cells = rows[:, None] * grid.columns + columns
        return cells.ravel(), np.hypot(dx, dy[:, None]).ravel()

    def _field(self, there: Pose) -> Array:
        """Shortest distances from every cell (flattened) to ``there`` [m]."""
        key = (there.x, there.y, self._world.shut_doors, self._world.present_barriers)
        if key not in self._fields:
            if len(self._fields) >= CACHED_FIELDS:
                self._fields.pop(next(iter(self._fields)))
            self._fields[key] = self._computed(there)
        return self._fields[key]

    def _computed(self, there: Pose) -> Array:
        """Dijkstra from one more node, which stands for ``there``."""
        radius = self._world.robot.radius - SLACK_M
        free = ~self.grid.near(self._world.solid_segments, radius)
        cells, legs = self._joined(there)
        near = free.ravel()[cells]
        graph = _graph(free, cells[near], legs[near])
        lengths = dijkstra(graph, directed=False, indices=np.array((free.size,)))
        return np.asarray(lengths[0, :-1], dtype=np.float64)


def _graph(free: Mask, cells: Ints, legs: Array) -> csr_array:
    """The graph of the free cells (flattened), an edge a step, weighted in metres.

    One more node, the last, is joined to ``cells`` by edges of length ``legs``.
    """
    index = np.arange(free.size).reshape(free.shape)
    height, width = free.shape
    starts, ends, weights = [np.full(cells.size, free.size)], [cells], [legs]
    for i, j in (*STEPS, *((i, -j) for i, j in STEPS if i and j)):
        here = np.s_[: height - i, max(-j, 0) : width - max(j, 0)]
        there = np.s_[i:, max(j, 0) : width + min(j, 0)]
        both = free[here] & free[there]
        starts.append(index[here][both])
        ends.append(index[there][both])
        weights.append(np.full(starts[-1].size, CELL_M * math.hypot(i, j)))
    nodes = free.size + 1
    rows, columns = np.concatenate(starts), np.concatenate(ends)
    return csr_array((np.concatenate(weights), (rows, columns)), shape=(nodes, nodes))
