"""What learned robots are shown, made of plain observations, for one robot or for many alike.

Training and the robot itself call the same code; every robot's numbers are worked out by scalar
loops of its own, so that they do not depend on how many stand beside it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from agents.ppo.memory_kernel import SHIFT, Array, Cells, Counts, Floats, draw, look_around, paint
from agents.ppo.params import MARKS, Percepts
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

NEAR_M = 2.0
"""A range or distance of this reads one half [m]."""


class Perception:
    """The memories of some robots, and what their networks are shown.

    Args:
        count: how many robots.
        robot: gives the scale of the odometry.
        laser: whose scans they get.
        numbers: sizes.

    Raises:
        ValueError: the laser has fewer beams than sectors are wanted.
    """

    def __init__(self, count: int, robot: RobotSpec, laser: LaserSpec, numbers: Percepts) -> None:
        """Nothing is known yet."""
        if laser.beams < numbers.sectors:
            raise ValueError(f"laser: expected {numbers.sectors} beams at least, got {laser.beams}")
        self.numbers, self._robot, self._laser = numbers, robot, laser
        self._first = np.arange(numbers.sectors) * laser.beams // numbers.sectors
        self._angles = np.ascontiguousarray(laser.angles[:: numbers.stride])
        side = numbers.side
        self._cells: Cells = np.zeros((count, side, side), dtype=np.uint8)
        self._visits: Counts = np.zeros((count, side >> SHIFT, side >> SHIFT), dtype=np.float32)
        self._poses = [Pose()] * count
        self._marks: Array = np.full((count, MARKS, 2), np.nan)

    def forget(self, row: int) -> None:
        """Begin a life of one robot."""
        self._cells[row], self._visits[row], self._marks[row] = 0, 0.0, np.nan
        self._poses[row] = Pose()

    def pose(self, row: int) -> Pose:
        """Where a robot believes to be, ``start_from_robot``."""
        return self._poses[row]

    def marks(self, row: int) -> Array:
        """Where a robot believes its marks, (MARKS, 2) from the start [m]; NaN: not given."""
        marks: Array = self._marks[row]
        return marks

    def known_bytes(self, row: int) -> int:
        """Bytes of the rectangle of a robot's memory that holds all it knows."""
        rows, columns = np.nonzero(self._cells[row])
        if len(rows) == 0:
            return 0
        cells = int(np.ptp(rows) + 1) * int(np.ptp(columns) + 1)
        return cells * self._cells.itemsize + (cells * self._visits.itemsize >> 2 * SHIFT)

    def to_goal(self, row: int, goal: int) -> tuple[float, float] | None:
        """The way to a goal as the crow flies: distance [m], direction [rad]; None without one."""
        mark = self._marks[row, goal]
        if goal == 0 or np.isnan(mark[0]):
            return None
        x, y = self._poses[row].inverse().apply(mark).tolist()
        return math.hypot(x, y), math.atan2(y, x)

    def perceive(self, row: int, observation: Observation) -> Floats:
        """Take in the next observation of one robot; what its network is shown, (size,).

        Args:
            row: of the robot.
            observation: its own, as an agent gets it.

        Raises:
            ValueError: the scan has another number of beams than the laser.
        """
        numbers, ranges = self.numbers, clean(observation["scan"], self._laser)
        motion = [float(v) for v in observation["odometry"]]
        pose = self._poses[row] = self._poses[row] @ Pose(*motion)
        if mark := int(observation["mark"]):
            self._marks[row, mark] = pose.position
        self._remember(row, ranges)
        out = np.empty(numbers.size, dtype=np.float32)
        ends = np.cumsum((numbers.sectors, numbers.directions, numbers.directions))
        scan, walls, unknowns, rest = np.split(out, ends)
        seen = np.where(ranges > 0.0, ranges, self._laser.range_max)
        nearest = np.minimum.reduceat(seen, self._first)
        scan[:] = nearest / (nearest + NEAR_M)
        place = self._in_cells(pose)
        look_around(self._cells[row], place, numbers.reach / numbers.cell, walls, unknowns)
        pictures = self._paint(row, place, rest)
        rest[pictures] = 2.0 * float(observation["bump"])
        rest[pictures + 1 : pictures + 4] = self._scaled(motion)
        rest[pictures + 4 :] = _goal(self.to_goal(row, int(observation["goal"])))
        return out

    def _remember(self, row: int, ranges: Array) -> None:
        """Draw a scan into the memory, and count the visit."""
        numbers, pose = self.numbers, self._poses[row]
        eye = self._in_cells(pose @ self._laser.robot_from_laser)
        some = ranges[:: numbers.stride] / numbers.cell
        draw(self._cells[row], eye, self._angles, some, numbers.reach / numbers.cell)
        x, y, _ = self._in_cells(pose)
        if 0.0 <= x < numbers.side and 0.0 <= y < numbers.side:
            self._visits[row, int(y) >> SHIFT, int(x) >> SHIFT] += 1.0

    def _paint(self, row: int, place: tuple[float, float, float], out: Floats) -> int:
        """Write the near and the far picture; how many numbers they are."""
        n, begin = self.numbers, 0
        for fields, size in ((n.near_cells, n.near_size), (n.far_cells, n.far_size)):
            end = begin + 3 * fields**2
            picture = out[begin:end].reshape(3, fields, fields)
            step = size / n.samples / n.cell
            paint(self._cells[row], self._visits[row], place, step, n.samples, picture)
            begin = end
        return begin

    def _in_cells(self, pose: Pose) -> tuple[float, float, float]:
        """A pose in the frame of the memory's corner [cells, cells, rad]."""
        half = self.numbers.side / 2.0
        return pose.x / self.numbers.cell + half, pose.y / self.numbers.cell + half, pose.theta

    def _scaled(self, motion: list[float]) -> tuple[float, float, float]:
        """The measured motion in the longest moves."""
        forward, turn = self._robot.max_forward, self._robot.max_turn
        return motion[0] / forward, motion[1] / forward, motion[2] / turn


def clean(scan: NDArray[np.float32], laser: LaserSpec) -> Array:
    """Ranges (beams,) [m]; 0 where a beam is not finite or returned nothing: no evidence.

    Raises:
        ValueError: another number of beams than the laser's.
    """
    ranges = np.asarray(scan, dtype=np.float64)
    if ranges.shape != (laser.beams,):
        raise ValueError(f"observation: scan: expected {laser.beams} beams, got {ranges.shape}")
    good = np.isfinite(ranges) & (ranges > 0.0) & (ranges < np.float32(laser.range_max))
    return np.where(good, ranges, 0.0)


def _goal(way: tuple[float, float] | None) -> tuple[float, float, float, float]:
    """A flag, how near the goal is believed, and cosine and sine of its direction."""
    if way is None:
        return 0.0, 0.0, 0.0, 0.0
    distance, direction = way
    return 1.0, NEAR_M / (distance + NEAR_M), math.cos(direction), math.sin(direction)
