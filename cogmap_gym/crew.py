"""What the robots of a fleet shall do, and how they get on: their tasks, side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.crew_kernel import judge_steps
from cogmap_gym.fleet import Fleet
from cogmap_gym.geometry import Array, Pose
from cogmap_gym.observation import MARKS, LaserSpec, RobotSpec
from cogmap_gym.phases import Course
from cogmap_gym.raycast_kernel import Ints
from cogmap_gym.routes import Routes, RouteTables
from cogmap_gym.row_task import RowCoverage, RowTask, RowWorld
from cogmap_gym.scores import SCORES
from cogmap_gym.trail_kernel import NOWHERE
from cogmap_gym.vector_tables import DECLARE

Flags = NDArray[np.bool_]


class Crew:
    """The tasks of all robots.

    Args:
        fleet: the robots.
        course: what the episodes consist of.
        robot: size of the robots.
        laser: what they see with.
        steps_a_move: how many steps count as one move of a budget.
    """

    def __init__(
        self, fleet: Fleet, course: Course, robot: RobotSpec, laser: LaserSpec, steps_a_move: int
    ) -> None:
        """Make a task for each robot; each begins with ``reset``.

        Raises:
            ValueError: if a plan lacks what the course needs.
        """
        count = fleet.count
        self._fleet = fleet
        self.cells: Ints = np.array([site.cells for site in fleet.sites], np.int64)[fleet.where]
        self.seen: Ints = np.zeros(count, dtype=np.int64)
        """(N,): how many cells each robot has seen."""
        self.goal, self.mark, self.phase = (np.zeros(count, dtype=np.int64) for _ in range(3))
        self.is_success = np.zeros(count, dtype=np.bool_)
        self.scores = np.full((len(SCORES), count, MARKS), -1.0)
        self.events = np.empty(count, dtype=object)
        self.changed: set[int] = set()
        """The robots whose doors or barriers have changed in the last step."""
        self._steps, self._most_steps = (np.zeros(count, dtype=np.int64) for _ in range(2))
        self._share = np.full(count, 2.0)
        self._rooms, self._always = (np.zeros(count, dtype=np.bool_) for _ in range(2))
        self._watched = (
            *(self.seen, self.cells, self.goal, self._steps, self._most_steps, self._share),
            *(self._rooms, self._always),
        )
        self._asked: Ints = np.zeros(count, dtype=np.int64)
        self._aimed: list[object] = [None] * count
        self.worlds = [RowWorld(fleet, row, robot) for row in range(count)]
        tables = [RouteTables(site.plan, site.movable, robot.radius) for site in fleet.sites]
        self.tasks = [
            RowTask(
                *(course, world, laser, steps_a_move),
                *(RowCoverage(fleet, row, self.seen), Routes(world, tables[fleet.where[row]])),
            )
            for row, world in enumerate(self.worlds)
        ]

    def place(self, row: int, home: Pose | None) -> None:
        """Put one robot at the beginning of an episode, which ``appear`` completes.

        Raises:
            ValueError: if home is no place for the robot.
        """
        self.worlds[row].begin(home)
        self.seen[row], self._aimed[row] = 0, None

    def appear(self, goals: Mapping[int, np.random.Generator]) -> None:
        """Begin the episodes of the robots whose first step the fleet has made.

        Args:
            goals: by row, the stream from which a robot's course draws.
        """
        for row, rng in goals.items():
            self.seen[row] += self._fleet.robots[row]["new"]
            self.tasks[row].reset(rng)
            self._begin(row)
            self._look_after(row)

    def step(self, modes: Ints) -> tuple[Array, Flags]:
        """Judge one step of the robots, which the fleet has already made.

        Args:
            modes: (N,), what each robot did; those that neither moved nor declared are left alone.

        Returns:
            (N,) rewards, 0 for those left alone, and whether all phases are over.
        """
        fleet = self._fleet
        self.mark.fill(0)
        for row in self.changed:
            self.events[row] = ()
        self.changed.clear()
        rewards, over = np.empty(fleet.count), np.zeros(fleet.count, dtype=np.bool_)
        count = judge_steps(
            modes, fleet.robots, fleet.entered, self._watched, rewards, self._asked
        )  # fmt: skip
        for row in self._asked[:count].tolist():
            rewards[row], over[row] = self._judge(row, declared=bool(modes[row] == DECLARE))
        return rewards, over

    def _judge(self, row: int, *, declared: bool) -> tuple[float, bool]:
        """Ask the task of one robot about its step."""
        task, fleet, robot = self.tasks[row], self._fleet, self._fleet.robots[row]
        names = task.rooms
        entered = [names[k] for k in fleet.entered[row, 1 : fleet.entered[row, 0] + 1]]
        pose = Pose(*(float(robot[f"before_{name}"]) for name in ("x", "y", "theta")))
        length, steps = float(robot["length"]), int(self._steps[row]) - 1
        done = len(task.results)
        reward, over = task.step_from(pose, steps, length, entered, declared=declared)
        if len(task.results) > done:
            self._begin(row)
        self._look_after(row)
        return reward, over

    def _begin(self, row: int) -> None:
        """A new phase has begun."""
        task, robot = self.tasks[row], self._fleet.robots[row]
        last = task.last_room
        robot["last"] = task.rooms.index(last) if last else NOWHERE
        self._steps[row] = 0

    def _look_after(self, row: int) -> None:
        """Write down what the task of one robot says and waits for."""
        task, fleet, watch = self.tasks[row], self._fleet, self.tasks[row].watch()
        self.goal[row], self.mark[row], self.phase[row] = task.goal, task.mark, len(task.results)
        self.is_success[row], self.events[row] = task.succeeded, task.events
        (self.changed.add if task.events else self.changed.discard)(row)
        self.scores[:, row] = task.scores
        self._most_steps[row], self._share[row] = watch.steps, watch.share
        self._rooms[row], self._always[row] = watch.rooms, watch.always
        open_marks = task.open_marks
        wanted = [name in open_marks for name in task.rooms]
        fleet.wanted[row, : len(wanted)] = wanted
        aim = task.goal, self.worlds[row].shut_doors, self.worlds[row].present_barriers
        if self._aimed[row] == aim:
            return
        self._aimed[row] = aim
        fleet.robots[row]["goal"] = 0
        if task.goal:
            fleet.aim(row, task.goal, task.way(task.goal), task.marks[task.goal].position)
            fleet.robots[row]["to_goal"] = task.distance(task.goal)
