"""A driver that knows the truth: it takes the shortest ways through the true world."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
from shapely.geometry import LineString, Point, Polygon

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, wrap_angle
from cogmap_gym.routes import Routes


def middle(plan: FloorPlan, room: str) -> Pose:
    """A point of a room far from its walls, furniture and doors."""
    free = Polygon(plan.rooms[room]).intersection(plan.free_space())
    doors = [LineString(leaf) for leaf in plan.doors.values()]
    best, at = 0.0, (0.0, 0.0)
    x0, y0, x1, y1 = free.bounds
    for x in np.arange(x0, x1, 0.2):
        for y in np.arange(y0, y1, 0.2):
            point = Point(x, y)
            if free.contains(point):
                size = float(free.boundary.distance(point))
                size = min([size, *(d.distance(point) - 0.76 for d in doors)])
                if size > best:
                    best, at = size, (float(x), float(y))
    assert best > 0.25, room
    return Pose(*at)


class Driver:
    """Drives a robot in an environment, and notes through which open doors it comes."""

    def __init__(self, env: gym.Env[Any, Any], seed: int) -> None:
        self.env: Any = env.unwrapped
        self.env.reset(seed=seed)
        self.routes = Routes(self.env.world)
        self.over = False
        self.info = self.env.task.info()
        self.doors: list[str] = []
        self.events: list[str] = list(self.info["events"])

    @property
    def task(self) -> Any:
        return self.env.task

    def step(self, action: np.ndarray) -> None:
        was = self.env.world.pose.position
        *_, terminated, truncated, self.info = self.env.step(action)
        now = self.env.world.pose.position
        move = LineString((was, now)) if (was != now).any() else Point(was)
        for name, leaf in self.env.plan.doors.items():
            if move.intersects(LineString(leaf)):
                self.doors.append(name)
        self.events += self.info["events"]
        self.over = terminated or truncated

    def go(self, goal: Pose, until: Callable[[], bool] = lambda: False) -> None:
        """Drive to a place by the ways that are open at each moment."""
        robot = self.env.robot
        for _ in range(400):
            pose = self.env.world.pose
            if self.over or until() or pose.distance(goal) < 0.05:
                return
            way = self.routes.way(pose, goal)
            assert way is not None, f"no way to {goal}"
            ahead = way[1:][np.hypot(*(way[1:] - pose.position).T) > 1e-6][0] - pose.position
            turn = wrap_angle(math.atan2(ahead[1], ahead[0]) - pose.theta)
            aligned = abs(turn) <= robot.max_turn
            turn = turn if aligned else math.copysign(robot.max_turn, turn)
            self.step(robot.move(turn, float(np.hypot(*ahead)) if aligned else 0.0))
        raise AssertionError(f"never came to {goal}")

    def look_round(self, until: Callable[[], bool]) -> None:
        for _ in range(12):
            if not (self.over or until()):
                self.step(self.env.robot.move(math.radians(30.0), 0.0))

    def reach_goal(self) -> list[str]:
        """Go to the mark that is asked for and declare; answer the doors on the way."""
        before, phase = len(self.doors), len(self.task.results)
        mark = self.task.marks[self.task.goal]
        if self.routes.distance(self.env.world.pose, mark) < math.inf:
            self.go(mark)
        assert len(self.task.results) == phase
        self.step(self.env.robot.declare())
        return self.doors[before:]

    def explore(self, rooms: tuple[str, ...]) -> None:
        """Visit rooms in turn and look round in each, until the phase is over.

        Where that is not enough, go home and turn there until the budget runs out.
        """
        phase = len(self.task.results)

        def done() -> bool:
            return len(self.task.results) > phase

        for room in rooms:
            self.go(middle(self.env.plan, room), done)
            self.look_round(done)
        self.go(self.env.plan.home, done)
        for _ in range(3000):
            if self.over or done():
                return
            self.step(self.env.robot.move(math.radians(30.0), 0.0))
        raise AssertionError("the phase has no end")
