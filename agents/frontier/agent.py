"""The frontier robot: it sees all by going to where the known ends, and plans its ways."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.frontier.driver import Move, move_towards
from agents.frontier.flood_kernel import Prices
from agents.frontier.grid import OccupancyGrid
from agents.frontier.params import Params
from agents.frontier.patrol import way_to_doubtful_wall, way_to_stale, way_to_unvisited
from agents.frontier.planner import (
    Mask,
    Way,
    frontiers,
    is_open,
    prices,
    straight_reach,
    way_to,
)
from agents.frontier.positions import PoseSource
from agents.frontier.scans import clean_ranges, hits_in_robot
from agents.frontier.sketch import draw_sketch
from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

Action = NDArray[np.float32]


class FrontierAgent:
    """Frontier exploration and planning on an own grid, behind the agent protocol.

    B. Yamauchi, A frontier-based approach for autonomous exploration, CIRA 1997.

    Args:
        source: tells it where it is.
        params: all its numbers.
    """

    def __init__(self, source: PoseSource, params: Params | None = None) -> None:
        """Take the source of poses and the numbers."""
        self.source, self.params = source, params or Params()
        self.reset(RobotSpec(), LaserSpec())

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing."""
        self.robot, self.laser = robot, laser
        self.source.reset(laser)
        self.grid = OccupancyGrid(self.params.grid, self.params.planner.comfort, laser)
        self.scans: list[NDArray[np.float32]] = []
        self.mark_steps: dict[int, int] = {}
        self.goal, self.since, self.searched = 0, 0, 0
        self.way: Way | None = None
        self.patrol: Way | None = None
        self.planned, self.revision = 0, 0
        self.status = "exploring"

    def act(self, observation: Observation) -> Action:
        """Find out where it is, enter the scan, and make for the frontier or the goal."""
        ranges = clean_ranges(observation["scan"], self.laser)
        self.pose = self.source.follow(observation, ranges)
        self.hits = hits_in_robot(ranges, self.laser)
        self._enter(ranges)
        if observation["mark"]:
            self.mark_steps.setdefault(int(observation["mark"]), self.now)
        if int(observation["goal"]) != self.goal:
            self.goal, self.since, self.searched = int(observation["goal"]), self.now, 0
            self.way = self.patrol = None
        if self.goal in self.mark_steps:
            return self._travel(self._mark(self.goal))
        return self._explore()

    @property
    def now(self) -> int:
        """Number of the present step."""
        return len(self.source.poses) - 1

    @property
    def map_bytes(self) -> int:
        """Size of its map: the grid, and what of the scans it must keep to mend it."""
        scans = sum(scan.nbytes for scan in self.scans)
        return self.grid.known_bytes + self.source.kept_bytes + scans

    def sketch(self) -> dict[str, Any]:
        """What it believes, JSON-able, in the frame in which it began."""
        marks = {k: self._mark(k) for k in self.mark_steps}
        pose = self.source.poses[-1] if self.source.poses else Pose()
        return draw_sketch(self.grid, pose, marks, self.way, self.status)

    def _mark(self, mark: int) -> Points:
        """Where a mark is believed to be, (2,)."""
        return self.source.poses[self.mark_steps[mark]].position

    def _enter(self, ranges: Array) -> None:
        """Enter the scan; all of them anew if the poses of the past have changed."""
        if self.source.corrects:
            self.scans.append(ranges.astype(np.float32))
        if self.source.revision != self.revision:
            self.revision, self.way, self.patrol = self.source.revision, None, None
            self.grid.rebuild(self.source.poses[:-1], self.scans[:-1])
        self.grid.add(self.pose, ranges, self.now)
        here = self.grid.cells(self.pose.position[None])
        if self.grid.clearance[here][0] * self.grid.cell < self.params.planner.wall:
            self.grid.wipe(self.pose.position, self.params.planner.comfort)
            self.grid.add(self.pose, ranges, self.now)

    def _explore(self) -> Action:
        """To the cheapest frontier; once all is known, to what was seen longest ago."""
        grid, numbers = self.grid, self.params.planner
        if self._patrols(grid.visits):
            return self._look(self.patrol)
        self.status = "exploring"
        ends, price = frontiers(grid, numbers), self._prices()
        if self._is_stale(price) or not self._target_in(ends):
            self._plan(way_to(grid, price, self.pose.position, ends))
            if self.way is None and self._fades():
                ends, price = frontiers(grid, numbers), self._prices()
                self._plan(way_to(grid, price, self.pose.position, ends))
        way = self.way
        if way is None:
            self.status = "all known"
            return self._look(way_to_unvisited(grid, numbers, price, self.pose.position))
        move = self._follow(way, price, self.params.driver.stride)
        if move.blocked or self._is_at(way.target):
            grid.ignored[grid.near(way.target, numbers.ignored)] = True
            self.way = None
        return move.action

    def _travel(self, mark: Points) -> Action:
        """To a mark; where no way is known, look again at what was not seen since it was asked."""
        driver = self.params.driver
        self.status = "going to a mark"
        distance = float(np.hypot(*(mark - self.pose.position)))
        if distance < driver.arrived:
            return self.robot.declare()
        if self._patrols(self.grid.stamps):
            return self._look(self.patrol)
        price = self._prices()
        if self._is_stale(price) or not self._is_for(mark):
            way = self._way_to_mark(mark)
            self._plan(self._way_to_mark(mark) if way is None and self._fades() else way)
            price = self._prices()
        if self.way is None:
            self.status = "looking for a way"
            return self._search(mark, price)
        move = self._follow(self.way, price, self.robot.max_forward)
        return self.robot.declare() if move.blocked and distance < driver.nearly else move.action

    def _way_to_mark(self, mark: Points) -> Way | None:
        """Over what is known; else through what was never seen."""
        ends = np.zeros(self.grid.votes.shape, dtype=np.bool_)
        ends[self.grid.near(mark, self.params.driver.arrived / 2.0)] = True
        for through in (False, True):
            way = way_to(self.grid, self._prices(through), self.pose.position, ends)
            if way is not None:
                return replace(way, target=mark, through_unknown=through)
        return None

    def _search(self, mark: Points, price: Prices) -> Action:
        """Look again where a way may have opened; declare once there is nothing left."""
        grid, here = self.grid, self.pose.position
        if self.searched > self.params.planner.patience:
            return self.robot.declare()
        way = way_to_doubtful_wall(
            grid, self.params.planner, price, (here, mark), self.since
        ) or way_to_stale(grid, price, here, self.since)
        return self.robot.declare() if way is None else self._look(way)

    def _patrols(self, steps: NDArray[np.int32]) -> bool:
        """Whether it is on its way to something whose step is not younger than the plan."""
        if self.patrol is None or self.now - self.planned >= self.params.planner.replan:
            return False
        return bool(steps[self.grid.cells(self.patrol.target[None])][0] < self.planned)

    def _look(self, way: Way | None) -> Action:
        """One step of a way that leads to something to look at; what cannot be is given up."""
        self.patrol, self.searched = way, self.searched + 1
        if way is None:
            return self.robot.move(self.robot.max_turn, 0.0)
        move = self._follow(way, self._prices(), self.params.driver.stride)
        if move.blocked or self._is_at(way.points[-1]):
            seen = self.grid.near(way.target, self.params.planner.ignored)
            self.grid.stamps[seen] = self.grid.visits[seen] = self.now
            self.grid.votes[seen] = np.where(self.grid.votes[seen] == 1, 2, self.grid.votes[seen])
        return move.action

    def _follow(self, way: Way, price: Prices, longest: float) -> Move:
        """Make for the farthest point of the way that a straight line leads to."""
        points = way.ahead(self.pose.position)
        row = straight_reach(self.grid, price, points, self.pose.position)
        point = points[max(row, min(1, len(points) - 1))]
        move = move_towards(point, self.pose, self.hits, self.robot, self.params.driver, longest)
        if move.blocked:
            ahead = (point - self.pose.position) / np.hypot(*(point - self.pose.position))
            bar = self.params.planner.bar
            self.grid.barred[self.grid.near(self.pose.position + 1.5 * bar * ahead, bar)] = self.now
            self.way = self.patrol = None
        return move

    def _fades(self) -> bool:
        """Forget the older part of a map that drifts; whether there is such a map."""
        if self.source.drifts:
            self.grid.fade(self.now - self.params.planner.fresh)
        return self.source.drifts

    def _plan(self, way: Way | None) -> None:
        self.way, self.planned = way, self.now

    def _prices(self, through_unknown: bool | None = None) -> Prices:
        """Of all cells; for the way that is being followed if not told otherwise."""
        if through_unknown is None:
            through_unknown = self.way is not None and self.way.through_unknown
        numbers = self.params.planner
        return prices(self.grid, numbers, self.now, through_unknown=through_unknown)

    def _is_stale(self, price: Prices) -> bool:
        """Whether the way must be looked for anew."""
        if self.way is None or self.now - self.planned >= self.params.planner.replan:
            return True
        return not is_open(self.grid, price, self.way.ahead(self.pose.position))

    def _target_in(self, ends: Mask) -> bool:
        """Whether the way still leads to one of these cells."""
        return self.way is not None and bool(ends[self.grid.cells(self.way.target[None])][0])

    def _is_for(self, mark: Points) -> bool:
        return self.way is not None and np.array_equal(self.way.target, mark)

    def _is_at(self, point: Points) -> bool:
        return float(np.hypot(*(point - self.pose.position))) < self.params.driver.reached
