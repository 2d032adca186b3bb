"""All robots of a vector environment as arrays, and the compiled step over them."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.coverage_kernel import scratch_of
from cogmap_gym.disc_kernel import MOST_POINTS, NEAR
from cogmap_gym.geometry import Array, Points
from cogmap_gym.helper import Helper
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.raycast_kernel import LANES, Ints
from cogmap_gym.sensors import OdometrySpec, odometry_bound
from cogmap_gym.shared_count import all_finished, new_count
from cogmap_gym.sites import Site
from cogmap_gym.trail_kernel import MOST_ENTERED, NOWHERE
from cogmap_gym.vector_kernel import step_robots
from cogmap_gym.vector_tables import PLAN, POSE, ROBOT, SPEC

LINE_BYTES = 128
"""Bytes that a processor fetches together [-], at most."""
PAUSE_S = 1e-4
"""How long a thread sleeps before it looks again whether the others have finished [s]."""
FEWEST_IN_THREADS = 8
"""Fewer robots are stepped on one thread: starting others costs more."""


class Fleet:
    """Robots on one or many sites.

    Args:
        sites: the buildings.
        where: (N,), the site of each robot.
        robot: size and speeds.
        laser: what they see with.
        odometry: how far their wheels mislead.
        threads: on how many the robots are stepped.
    """

    def __init__(
        self,
        sites: Sequence[Site],
        where: Ints,
        robot: RobotSpec,
        laser: LaserSpec,
        odometry: OdometrySpec,
        threads: int,
    ) -> None:
        """Lay out the tables; robots appear by ``place``."""
        count = len(where)
        self.sites, self.where, self.count = sites, where, count
        self.threads = threads if count >= FEWEST_IN_THREADS else 1
        self.plans = _plan_table(sites)
        self._spec = _spec_row(robot, laser, odometry)
        self._beams = laser.beams
        self.robots = np.zeros(count, dtype=ROBOT)
        self.robots["plan"], self.robots["room"] = where, NOWHERE
        self.robots["last"] = NOWHERE
        tiles = np.array([site.tiles.size for site in sites], dtype=np.int64)[where]
        self.robots["tiles"] = np.cumsum(tiles) - tiles
        self.robots["blocks"] = self.robots["tiles"] // 16
        self._memory = np.zeros(tiles.sum(), np.uint64), np.zeros(tiles.sum() // 16, np.uint8)
        self.solid = np.zeros((count, max(len(site.movable) for site in sites)), dtype=np.bool_)
        most_rooms = max(len(site.polygons) for site in sites)
        self.wanted = np.zeros((count, most_rooms), dtype=np.bool_)
        self.entered = np.zeros((count, MOST_ENTERED + 1), dtype=np.int64)
        self._tables = (
            np.array([site.grid for site in sites]),
            *_joined_cells(sites),
            _fan(laser),
        )
        self._rooms = (np.concatenate([site.segments for site in sites]), *_joined_rooms(sites))
        self._goals: tuple[Array, Array] = np.zeros((0, 2)), np.zeros((count, 0))
        self._graphs: dict[int, int] = {}
        self._scratch = [self._made_scratch() for _ in range(self.threads)]
        self._helpers: list[Helper] = []

    def site(self, row: int) -> Site:
        """The building of a robot."""
        site: Site = self.sites[int(self.where[row])]
        return site

    def poses(self) -> Array:
        """A fresh array (N, 3) of the true poses: x [m], y [m], heading [rad]."""
        poses: Array = self.robots.view(POSE)["pose"].copy()
        return poses

    def place(self, row: int, x: float, y: float, theta: float) -> None:
        """Put a robot somewhere at the beginning of an episode, with nothing seen."""
        robot, site = self.robots[row], self.site(row)
        robot["x"], robot["y"], robot["theta"] = x, y, theta
        robot["count"], robot["length"], robot["goal"] = 0, 0.0, 0
        size, (tiles, blocks) = site.tiles.size, self._memory
        tiles[robot["tiles"] : robot["tiles"] + size] = site.tiles.ravel()
        blocks[robot["blocks"] : robot["blocks"] + size // 16] = site.blocks.ravel()

    def aim(self, row: int, goal: int, way: tuple[Points, Array, float], mark: Points) -> None:
        """Give a robot a goal.

        Args:
            row: of the robot.
            goal: number of the mark.
            way: what ``Routes.lengths_to`` says of it.
            mark: (2,), where it is [m].
        """
        nodes, lengths, reach = way
        robot, site = self.robots[row], int(self.where[row])
        all_nodes, all_lengths = self._goals
        if site not in self._graphs:
            self._graphs[site] = len(nodes)
            self.plans[site]["nodes"] = len(all_nodes)
            self.plans[site]["nodes_end"] = len(all_nodes) + len(nodes)
            all_nodes = np.concatenate((all_nodes, nodes))
            wide = max(len(nodes) - all_lengths.shape[1], 0)
            all_lengths = np.pad(all_lengths, ((0, 0), (0, wide)))
            self._goals = all_nodes, all_lengths
            width = all_lengths.shape[1]
            self._scratch = [(*most, _apart(width)) for *most, _ in self._scratch]
        all_lengths[row, : len(lengths)] = lengths
        robot["goal"], robot["mark_reach"] = goal, reach
        robot["mark_x"], robot["mark_y"] = mark

    def step(
        self, modes: NDArray[np.int64], actions: Array, scan: NDArray[np.float32] | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Step all robots.

        Args:
            modes: (N,), what each does: ``MOVE``, ``DECLARE``, ``APPEAR`` or ``REST``.
            actions: (N, 3) in [-1, 1].
            scan: (N, beams), written in place of a fresh one.

        Returns:
            Fresh arrays: scans (N, beams) [m] and odometry (N, 3) [m, m, rad]; those of robots
            at rest are not written.

        Raises:
            RuntimeError: a thread beside this one has failed.
        """
        if scan is None:
            scan = np.empty((self.count, self._beams), dtype=np.float32)
        odometry = np.empty((self.count, 3), dtype=np.float32)
        arrays: tuple[Any, ...] = (
            *(modes, actions, self._spec, self.plans, self.robots, self.solid, self.wanted),
            *(self._tables, self._rooms, self._memory, self._goals, self.entered, scan, odometry),
        )
        count = new_count()
        for helper, scratch in zip(self._awake(), self._scratch[1:], strict=True):
            helper.tell(step_robots, count, scratch, *arrays)
        step_robots(count, self._scratch[0], *arrays)
        while self.threads > 1 and not all_finished(count, self.count):
            if not all(helper.alive for helper in self._helpers):
                raise RuntimeError("a thread has failed; its error stands above")
            time.sleep(PAUSE_S)
        return scan, odometry

    def close(self) -> None:
        """Let the threads go; they come back when they are needed."""
        self._helpers = []

    def __getstate__(self) -> dict[str, Any]:
        """All but the threads."""
        return {**self.__dict__, "_helpers": []}

    def _awake(self) -> list[Helper]:
        """The threads beside the one that calls; a forked process starts its own."""
        if not (self._helpers and all(helper.alive for helper in self._helpers)):
            self._helpers = [Helper() for _ in range(self.threads - 1)]
        return self._helpers

    def _made_scratch(self) -> tuple[Any, ...]:
        """What a thread writes and forgets."""
        most = max(len(site.fixed) + len(site.movable) for site in self.sites)
        return (
            *(_apart(most, NEAR), _apart(4), _apart(MOST_POINTS, 2), _apart(7)),
            *(_apart(most, dtype=np.int64), _apart(1, dtype=np.int64)),
            tuple(_moved_apart(part) for part in scratch_of(self._beams)),
            *(_apart(self._beams), _apart(self._beams, dtype=np.bool_), _apart(0)),
        )


def _moved_apart(array: NDArray[Any]) -> NDArray[Any]:
    """A copy that shares no cache line with other arrays."""
    copy = _apart(*array.shape, dtype=array.dtype)
    copy[...] = array
    return copy


def _apart(*shape: int, dtype: Any = np.float64) -> NDArray[Any]:
    """Zeros that share no cache line with other arrays, so that no thread waits for another."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.zeros(size + 2 * LINE_BYTES, dtype=np.uint8)
    begin = -memory.ctypes.data % LINE_BYTES
    zeros: NDArray[Any] = memory[begin : begin + size].view(dtype).reshape(shape)
    return zeros


def _plan_table(sites: Sequence[Site]) -> NDArray[Any]:
    """The row of each site in the joint tables."""
    plans = np.zeros(len(sites), dtype=PLAN)
    begin = cells = rooms = 0
    for plan, site in zip(plans, sites, strict=True):
        plan["begin"], plan["cells"], plan["rooms"] = begin, cells, rooms
        plan["fixed"], plan["movable"] = len(site.fixed), len(site.movable)
        plan["doors"] = len(site.plan.doors)
        plan["columns"], plan["lines"] = site.size
        plan["tile_rows"], plan["tile_columns"] = site.tiles.shape
        plan["corner_x"], plan["corner_y"] = site.corner
        begin += len(site.fixed) + len(site.movable)
        cells += len(site.first)
        rooms += len(site.polygons)
        plan["rooms_end"] = rooms
    return plans


def _joined_cells(sites: Sequence[Site]) -> tuple[Ints, Ints]:
    """The laser's cells of all sites: where the rows of each begin, and the rows."""
    ends = np.cumsum([0, *(len(site.rows) for site in sites)])
    first = [site.first + end for site, end in zip(sites, ends[:-1].tolist(), strict=True)]
    return np.concatenate(first), np.concatenate([site.rows for site in sites])


def _joined_rooms(sites: Sequence[Site]) -> tuple[Array, Ints, Array]:
    """The rooms of all sites: boxes (R, 4), where their edges begin (R + 1,), edges (E, 4)."""
    rings = [np.asarray(ring) for site in sites for ring in site.polygons]
    boxes = [np.concatenate((ring.min(axis=0), ring.max(axis=0))) for ring in rings]
    edges = [np.hstack((ring, np.roll(ring, -1, axis=0))) for ring in rings]
    corners = np.cumsum([0, *map(len, rings)])
    return (
        np.array(boxes).reshape(-1, 4),
        corners.astype(np.int64),
        np.concatenate(edges) if edges else np.zeros((0, 4)),
    )


def _fan(laser: LaserSpec) -> Array:
    """Cosines and sines of the beams about the middle of the fan, as in ``raycast``."""
    angles = (np.arange(laser.beams) - 0.5 * (laser.beams - 1)) * laser.step
    fan = np.zeros((2, -(-laser.beams // LANES) * LANES))
    fan[:, : laser.beams] = np.cos(angles), np.sin(angles)
    return fan


def _spec_row(robot: RobotSpec, laser: LaserSpec, odometry: OdometrySpec) -> Any:
    """The numbers of the specs, as the compiled step reads them."""
    middle = laser.first_angle + 0.5 * (laser.beams - 1) * float(laser.step)
    row = (
        *(int(robot.control == "velocity"), robot.radius, robot.max_forward, robot.max_turn),
        *(robot.max_speed, robot.max_turn_rate, robot.velocity_step),
        *(odometry.distance_sd, odometry.turn_sd, odometry.distance_bias, odometry.turn_bias),
        *odometry_bound(robot, odometry),
        *(laser.range_max, laser.sd, laser.step, middle + laser.mount[2], *laser.mount[:2]),
        laser.beams,
    )
    return np.array([row], dtype=SPEC)[0]
