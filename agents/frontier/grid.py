"""The occupancy grid: what the robot has seen of free space and of things, and when."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from agents.frontier import params
from agents.frontier.grid_kernel import Window, carve, stamp_hits, update_clearance
from agents.frontier.scans import NO_EVIDENCE
from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import LaserSpec

NEVER = -1
"""The stamp of a cell never seen."""


class OccupancyGrid:
    """Votes of the beams, cell by cell, in the frame in which the robot began.

    Args:
        numbers: sizes and votes.
        cap: distances to the nearest occupied cell are known up to here [m].
        laser: whose scans are entered.
    """

    def __init__(self, numbers: params.Grid, cap: float, laser: LaserSpec) -> None:
        """Nothing is known yet."""
        self._numbers, self._laser = numbers, laser
        self._cap = math.ceil(cap / numbers.cell)
        side = 2 * round(numbers.grow / numbers.cell)
        self.corner = np.full(2, -numbers.grow)
        """x and y of the outer corner of cell (0, 0) [m]."""
        self.votes = np.zeros((side, side), dtype=np.int8)
        """(H, W): above 0 occupied, below free, 0 never seen."""
        self.stamps = np.full((side, side), NEVER, dtype=np.int32)
        """(H, W): the step at which each cell was last seen."""
        self.visits = np.full((side, side), NEVER, dtype=np.int32)
        """(H, W): the step at which the robot last was near each cell and saw it."""
        self.clearance = np.full((side, side), self._cap, dtype=np.float32)
        """(H, W): distance to the nearest occupied cell, up to the cap [cells]."""
        self.ignored = np.zeros((side, side), dtype=np.bool_)
        """(H, W): the unknown beside these cells was looked at in vain."""
        self.barred = np.full((side, side), NEVER, dtype=np.int32)
        """(H, W): the step at which the way through each cell last proved to be none."""

    def fade(self, before: int) -> None:
        """Forget what was last seen before a step, and all that was tried."""
        old = self.stamps < before
        self.votes[old], self.ignored[:], self.barred[:] = 0, False, NEVER
        self._refresh()

    def wipe(self, point: Points, radius: float) -> None:
        """Forget what was seen within ``radius`` [m] of a point (2,)."""
        self.votes[self.near(point, radius)] = 0

    @property
    def cell(self) -> float:
        """Side of a cell [m]."""
        return self._numbers.cell

    def add(self, robot: Pose, ranges: Array, now: int) -> None:
        """Enter a scan; ``_vote`` tells the arguments."""
        window = self._grown(self._vote(robot, ranges, now))
        update_clearance(self.clearance, self.votes, window, self._cap)

    def rebuild(self, robots: Iterable[Pose], scans: Iterable[NDArray[np.float32]]) -> None:
        """Enter all scans anew, the first of step 0, keeping what was tried."""
        self.votes[:], self.stamps[:], self.visits[:] = 0, NEVER, NEVER
        for step, (robot, ranges) in enumerate(zip(robots, scans, strict=True)):
            self._vote(robot, ranges.astype(np.float64), step)
        self._refresh()

    def _refresh(self) -> None:
        """Bring the clearance of all cells up to date."""
        height, width = self.votes.shape
        update_clearance(self.clearance, self.votes, (0, height, 0, width), self._cap)

    def _vote(self, robot: Pose, ranges: Array, now: int) -> Window:
        """Let the beams of a scan vote; answer the cells that they may have changed.

        Args:
            robot: the robot's pose.
            ranges: (beams,) [m], ``NO_EVIDENCE`` where a beam tells nothing.
            now: number of the step.
        """
        numbers, laser = self._numbers, self._laser
        eye = robot @ laser.robot_from_laser
        angles = laser.angles + eye.theta
        ends = eye.position + np.minimum(ranges, numbers.reach)[:, None] * np.stack(
            (np.cos(angles), np.sin(angles)), axis=1
        )
        around = robot.position + numbers.body * np.array(((-1, -1), (1, 1)))
        window = self._window(np.concatenate((ends, around)))
        place = (float(self.corner[0]), float(self.corner[1]), self.cell)
        view = (eye.x, eye.y, eye.theta)
        fan = (laser.first_angle, laser.step)
        limits = (numbers.reach, numbers.margin, numbers.near)
        carve(
            self.votes, self.stamps, self.visits, window, place, view, ranges, fan, limits,
            numbers.free, now,
        )  # fmt: skip
        hit = (ranges > NO_EVIDENCE) & (ranges <= numbers.reach)
        rows, columns = self.cells(ends[hit])
        stamp_hits(self.votes, self.stamps, rows, columns, numbers.occupied, now)
        self._stand(robot, now)
        return window

    @property
    def known_bytes(self) -> int:
        """Of the smallest rectangle with all that was ever seen, a byte a cell."""
        known = np.argwhere(self.votes != 0)
        return int(np.prod(np.ptp(known, axis=0) + 1)) if len(known) else 0

    def cells(self, points: Points) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Row and column of each point (N, 2) [m]."""
        index = np.floor((points - self.corner) / self.cell).astype(np.int64)
        return index[:, 1], index[:, 0]

    def centres(self, cells: NDArray[np.int64]) -> Points:
        """The centres of cells (N, 2), row and column, as points (N, 2) [m]."""
        return np.asarray(self.corner + (cells[:, ::-1] + 0.5) * self.cell)

    def near(self, point: Points, radius: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The cells whose centre is within ``radius`` [m] of a point and on the grid."""
        reach = math.ceil(radius / self.cell) + 1
        row, column = (int(k[0]) for k in self.cells(point[None]))
        rows, columns = np.mgrid[row - reach : row + reach + 1, column - reach : column + reach + 1]
        index = np.stack((rows.ravel(), columns.ravel()), axis=1)
        inside = ((index >= 0) & (index < self.votes.shape)).all(axis=1)
        index = index[inside]
        index = index[np.hypot(*(self.centres(index) - point).T) <= radius]
        return index[:, 0], index[:, 1]

    def _stand(self, robot: Pose, now: int) -> None:
        """Where the body is nothing else can be."""
        under = self.near(robot.position, self._numbers.body)
        self.votes[under] = np.minimum(self.votes[under], -1)
        self.stamps[under] = self.visits[under] = now

    def _grown(self, window: Window) -> Window:
        """The window and all cells whose clearance depends on it."""
        height, width = self.votes.shape
        a, b, c, d = window
        cap = self._cap
        return max(0, a - cap), min(height, b + cap), max(0, c - cap), min(width, d + cap)

    def _window(self, points: Points) -> Window:
        """The cells that hold these points, (N, 2) [m]; the grid grows until it has them all."""
        low, high = points.min(axis=0) - self.cell, points.max(axis=0) + self.cell
        block = self._numbers.grow
        size = np.array(self.votes.shape[::-1]) * self.cell
        before = np.ceil(np.maximum(0.0, self.corner - low) / block)
        after = np.ceil(np.maximum(0.0, high - self.corner - size) / block)
        if before.any() or after.any():
            self._grow(before, after)
        (top, bottom), (left, right) = self.cells(np.stack((low, high)))
        return int(top), int(bottom) + 1, int(left), int(right) + 1

    def _grow(self, before: Array, after: Array) -> None:
        cells = round(self._numbers.grow / self.cell)
        x, y = (cells * np.stack((before, after), axis=1)).astype(np.int64)
        self.votes = np.pad(self.votes, (y, x))
        self.stamps = np.pad(self.stamps, (y, x), constant_values=NEVER)
        self.visits = np.pad(self.visits, (y, x), constant_values=NEVER)
        self.clearance = np.pad(self.clearance, (y, x), constant_values=self._cap)
        self.ignored = np.pad(self.ignored, (y, x))
        self.barred = np.pad(self.barred, (y, x), constant_values=NEVER)
        self.corner = self.corner - before * self._numbers.grow
