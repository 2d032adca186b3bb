"""The shortest true ways of a robot in its world: for rewards, scores and oracles."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Pose, Segments, point_segment_distances
from cogmap_gym.visibility import TOLERANCE_M, Ints, VisibilityGraph, clear, first_clear
from cogmap_gym.world import World

CACHED_FIELDS = 64
"""How many fields of distances are kept; one of 1,000 nodes takes 20 kB."""
Solid = frozenset[str]
"""The names of all doors that are shut and all barriers that stand."""


class RouteTables:
    """What the routes of all robots of one plan share.

    The graph is made when the first way is asked for (half a second for a large office).
    """

    def __init__(self, plan: FloorPlan, movable: Segments, radius: float) -> None:
        """Nothing is computed yet."""
        self._plan, self._movable, self._radius = plan, movable, radius
        self._graph: VisibilityGraph | None = None
        self.fields: dict[tuple[object, ...], tuple[Array, Ints]] = {}

    @property
    def graph(self) -> VisibilityGraph:
        """The visibility graph of the plan."""
        if self._graph is None:
            self._graph = VisibilityGraph.of(self._plan, self._movable, self._radius)
        return self._graph


class Routes:
    """Shortest true ways in a world, with the doors as they stand, or as they might.

    Args:
        world: with the robot and the doors.
        tables: those of the world's plan and robot, where they are shared.
    """

    def __init__(self, world: World, tables: RouteTables | None = None) -> None:
        """Nothing is computed yet."""
        self._world = world
        own = RouteTables(world.plan, world.movable_segments, world.robot.radius)
        self._tables = own if tables is None else tables
        self._rows = {n: k for k, n in enumerate((*world.plan.door_names, *world.plan.barriers))}
        self._walls: tuple[Solid, Segments] = (frozenset(), world.fixed_segments)

    @property
    def solid(self) -> Solid:
        """What is in the way now."""
        return self._world.shut_doors | self._world.present_barriers

    def distance(self, here: Pose, there: Pose, solid: Solid | None = None) -> float:
        """Length of the shortest way between two poses [m]; infinite if there is none.

        Args:
            here: where the robot is.
            there: where it shall be.
            solid: which doors are shut and which barriers stand; by default, as it is now.
        """
        way = self._start_of_way(here, there, self.solid if solid is None else solid)
        return way[0]

    def way(self, here: Pose, there: Pose, solid: Solid | None = None) -> Points | None:
        """The points of the shortest way (K, 2) from ``here`` to ``there`` [m]; None: no way.

        The arguments are those of ``distance``.
        """
        solid = self.solid if solid is None else solid
        length, node = self._start_of_way(here, there, solid)
        if not math.isfinite(length):
            return None
        points = [here.position]
        if node >= 0:
            graph, (_, towards) = self._tables.graph, self._field(there, solid)
            while node < len(graph.nodes):
                points.append(graph.nodes[node])
                node = int(towards[node])
        return np.array((*points, there.position))

    def lengths_to(self, there: Pose) -> tuple[Points, Array, float]:
        """What ``distance`` to a pose is made of, with the doors as they are now.

        Returns:
            The nodes (K, 2), from each the length of the way (K,), and what a way must keep
            clear at its end, all [m].
        """
        solid = self.solid
        reach = self._reach(there.position, self._segments(solid))
        return self._tables.graph.nodes, self._field(there, solid)[0], reach

    def in_sight(self, eye: Points, name: str, solid: Solid) -> bool:
        """Whether a quarter point or the middle of a door or barrier is in line of sight.

        Args:
            eye: (2,), where one looks from, all round [m].
            name: of the door, open or shut, or of the barrier.
            solid: what is in the way of the look; the thing itself never is.
        """
        (a, b) = self._world.segment(name)[0]
        targets = a + np.array((0.25, 0.5, 0.75))[:, None] * (b - a)
        eyes = np.broadcast_to(eye, targets.shape).copy()
        return bool(clear(eyes, targets, self._segments(solid - {name}), 0.0).any())

    def _start_of_way(self, here: Pose, there: Pose, solid: Solid) -> tuple[float, int]:
        """The length of the way and its first node; -1 where there is none between."""
        segments = self._segments(solid)
        a, b = here.position, there.position
        reach = min(self._reach(a, segments), self._reach(b, segments))
        if clear(a[None], b[None], segments, reach)[0]:
            return here.distance(there), -1
        nodes = self._tables.graph.nodes
        lengths = self._field(there, solid)[0] + np.hypot(*(nodes - a).T)
        order = np.argsort(lengths, kind="stable")
        order = order[: np.count_nonzero(np.isfinite(lengths))]
        node = first_clear(a, nodes, order, segments, self._reach(a, segments))
        return (math.inf, -1) if node < 0 else (float(lengths[node]), node)

    def _reach(self, point: Points, segments: Segments) -> float:
        """What a way from a point must keep clear: the radius, or less where a wall is touched."""
        gap = float(point_segment_distances(point[None], segments).min())
        return min(self._world.robot.radius, gap) - TOLERANCE_M

    def _segments(self, solid: Solid) -> Segments:
        """All that is in the way, (N, 2, 2); the last answer is kept."""
        if self._walls[0] != solid:
            rows = [self._rows[name] for name in sorted(solid)]
            leaves = self._world.movable_segments[rows]
            self._walls = solid, np.concatenate((self._world.fixed_segments, leaves))
        return self._walls[1]

    def _field(self, there: Pose, solid: Solid) -> tuple[Array, Ints]:
        """From every node: how far it is to ``there`` [m], and the next node on the way."""
        key = (there.x, there.y, solid)
        fields = self._tables.fields
        if key not in fields:
            if len(fields) >= CACHED_FIELDS:
                fields.pop(next(iter(fields)))
            fields[key] = self._computed(there, solid)
        return fields[key]

    def _computed(self, there: Pose, solid: Solid) -> tuple[Array, Ints]:
        """Dijkstra from one more node, the last, which stands for ``there``."""
        graph, segments, goal = self._tables.graph, self._segments(solid), there.position
        count = len(graph.nodes)
        goals = np.broadcast_to(goal, graph.nodes.shape).copy()
        near = np.flatnonzero(clear(goals, graph.nodes, segments, self._reach(goal, segments)))
        legs = np.hypot(*(graph.nodes[near] - goal).T)
        open_ = ~graph.cut_by[:, [self._rows[name] for name in sorted(solid)]].any(axis=1)
        starts = np.concatenate((graph.edges[open_, 0], np.full(len(near), count)))
        ends = np.concatenate((graph.edges[open_, 1], near))
        weights = np.concatenate((graph.lengths[open_], np.maximum(legs, TOLERANCE_M)))
        matrix = csr_array((weights, (starts, ends)), shape=(count + 1, count + 1))
        lengths, towards = dijkstra(
            matrix, directed=False, indices=np.array(count), return_predecessors=True
        )
        return lengths[:count], towards[:count].astype(np.int64)
