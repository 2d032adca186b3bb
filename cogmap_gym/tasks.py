"""Tasks: start, goals, rewards, events and ends of an episode, over the true world.

A *course* says which phases an episode consists of; the ``Task`` runs them: it watches
the true world, gives marks and goals, counts rewards and scores, fires events, and knows
when all is over. The environment has no rules of its own.

Rewards (version 0): under goal 0 the newly seen free area over the total; under a goal
the decrease of the shortest true distance [m], +10 on success and -10 on a wrong
declaration; -0.01 a step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from cogmap_gym.body import Motion
from cogmap_gym.coverage import Coverage
from cogmap_gym.events import EventQueue
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import MARKS, LaserSpec
from cogmap_gym.phases import MARK_GAP_M, Course, Phase, PhaseResult
from cogmap_gym.routes import Routes
from cogmap_gym.scores import SCORES, path_share, shortest_lengths
from cogmap_gym.trail import Trail
from cogmap_gym.world import World

ARRIVED_M = 1.0
"""A declaration within this distance of the mark is right [m]. Thesis 4.2.4."""
FOUND_REWARD = 10.0
"""For a right declaration; a wrong one costs as much [-]."""
STEP_REWARD = -0.01
"""For each step [-]."""
HOME = 1
"""The mark of home."""


class Task:
    """Runs the phases of a course in a world and keeps the score.

    Args:
        course: what the episodes consist of.
        world: the truth, which the task's events change.
        laser: what the robot sees with, for coverage.
        steps_a_move: how many steps count as one move of a budget; 1 but for velocity control.
        coverage: what has been seen, where another keeps count of it.
        routes: the shortest ways, where others share their tables.
    """

    def __init__(
        self,
        course: Course,
        world: World,
        laser: LaserSpec,
        steps_a_move: int = 1,
        coverage: Coverage | None = None,
        routes: Routes | None = None,
    ) -> None:
        """Check the plan; an episode begins with ``reset``.

        Raises:
            ValueError: if the plan lacks what the course needs.
        """
        course.check(world.plan)
        self._course, self._world, self._steps_a_move = course, world, steps_a_move
        self._range_max = laser.range_max
        self._coverage = Coverage(world, laser) if coverage is None else coverage
        self._routes = Routes(world) if routes is None else routes
        self._phases: tuple[Phase, ...] = ()
        self._events: tuple[str, ...] = ()
        self._trail = Trail(world.plan, world.pose)
        self._steps = 0
        self.results: list[PhaseResult] = []
        """How the phases that are over came out, in order."""
        self.path_length = 0.0
        """True length of the way of this episode [m]."""
        self.mark = 0
        """What ``observation["mark"]`` says now."""

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode with the robot where it stands, which becomes home."""
        world = self._world
        itinerary = self._course.itinerary(world.plan, rng)
        self._phases, self._mark_rooms = itinerary.phases, itinerary.mark_rooms
        self._marks: dict[int, Pose] = {HOME: world.pose}
        self._queue = EventQueue(world)
        self._scores = {name: np.full(MARKS, -1.0) for name in SCORES}
        self.results = []
        self.mark, self.path_length, self._pose = HOME, 0.0, world.pose
        self._coverage.forget()
        self._coverage.look(world.pose)
        self._begin()

    @property
    def phase(self) -> Phase | None:
        """The phase that runs now; None when all are over."""
        done = len(self.results)
        return self._phases[done] if done < len(self._phases) else None

    @property
    def goal(self) -> int:
        """What the robot shall do now: 0 explore, k go to mark k."""
        return 0 if self.phase is None else self.phase.goal

    @property
    def goals(self) -> tuple[int, ...]:
        """The marks of all goals of this episode, in order, those to come included."""
        return tuple(phase.goal for phase in self._phases if phase.goal)

    @property
    def marks(self) -> Mapping[int, Pose]:
        """True poses of the marks given so far."""
        return self._marks

    @property
    def mark_rooms(self) -> Mapping[int, str]:
        """The room in which each mark other than home is given."""
        return self._mark_rooms

    @property
    def succeeded(self) -> bool:
        """Whether all phases are over and each came out well."""
        return self.phase is None and all(result.success for result in self.results)

    def step(self, motion: Motion | None, *, declared: bool) -> tuple[float, bool]:
        """Judge one step of the robot, which the world has already made.

        Args:
            motion: what the body did; None if it declared.
            declared: whether the robot said "I am there".

        Returns:
            The reward, and whether all phases are over.
        """
        phase, before = self.phase, self._pose
        self._pose, self._steps = self._world.pose, self._steps + 1
        if motion is not None:
            self.path_length += motion.length
            self._trail.follow(motion.path)
        self.mark = self._new_mark()
        seen = self._coverage.look(self._pose)
        if phase is None:
            self._events = ()
            return STEP_REWARD, True
        reward = STEP_REWARD + (self._approach(phase, before) if phase.goal else seen)
        verdict = self._verdict(phase, declared=declared)
        if verdict is None:
            self._events = self._queue.fire(self._trail.rooms)
            return reward, False
        self._close(phase, success=verdict)
        if declared and phase.goal:
            reward += FOUND_REWARD if verdict else -FOUND_REWARD
        return reward, self.phase is None

    def info(self) -> dict[str, Any]:
        """The truth for ``info``; fresh arrays on every call."""
        pose = self._world.pose
        return {
            "pose": np.array((pose.x, pose.y, pose.theta)),
            "room": self._world.plan.room_at(pose.x, pose.y) or "",
            "coverage": self._coverage.share,
            "path_length": self.path_length,
            "phase": len(self.results),
            "events": self._events,
            "is_success": self.succeeded,
            **{name: scores.copy() for name, scores in self._scores.items()},
        }

    def _new_mark(self) -> int:
        """The mark that is given where the robot stands now; 0 for none."""
        if len(self._marks) > len(self._mark_rooms):
            return 0
        x, y = self._pose.x, self._pose.y
        room = self._world.plan.room_at(x, y)
        for mark, where in self._mark_rooms.items():
            if mark not in self._marks and where == room and self._trail.gap((x, y)) >= MARK_GAP_M:
                self._marks[mark] = self._pose
                return mark
        return 0

    def _approach(self, phase: Phase, before: Pose) -> float:
        """By how much the shortest true distance to the goal went down [m]."""
        mark = self._marks[phase.goal]
        was, now = (self._routes.distance(pose, mark) for pose in (before, self._pose))
        return was - now if math.isfinite(was) and math.isfinite(now) else 0.0

    def _verdict(self, phase: Phase, *, declared: bool) -> bool | None:
        """True: the phase ends well; False: it fails; None: it goes on."""
        if phase.goal and declared:
            return self._is_right(phase)
        rooms, seen, ready = self._trail.rooms, self._coverage.share, self._is_ready()
        if not phase.goal and phase.is_over(rooms, seen, self._world, marks_ready=ready):
            return True
        if self._steps >= phase.budget * self._steps_a_move:
            return phase.budget_is_success
        return None

    def _is_ready(self) -> bool:
        """Whether all marks have been given, and the next one asked for is in another room."""
        later = self._phases[len(self.results) + 1 :]
        room = self._mark_rooms.get(later[0].goal) if later else None
        if not set(self._mark_rooms) <= set(self._marks):
            return False
        return room is None or room != self._world.plan.room_at(self._pose.x, self._pose.y)

    def _is_right(self, phase: Phase) -> bool:
        """Whether "I am there", said here, is true."""
        mark, room_at = self._marks[phase.goal], self._world.plan.room_at
        if not math.isfinite(self._routes.distance(self._pose, mark)):
            return True
        if phase.in_room:
            return room_at(self._pose.x, self._pose.y) == self._mark_rooms.get(phase.goal)
        return self._pose.distance(mark) <= ARRIVED_M

    def _close(self, phase: Phase, *, success: bool) -> None:
        """Write down how the phase came out, and begin the next."""
        driven, (oracle, learning) = self.path_length - self._phase_start, self._lengths
        moves = math.ceil(self._steps / self._steps_a_move)
        self.results.append(PhaseResult(phase.task, success, moves, driven, oracle))
        scores, goal = self._scores, phase.goal
        scores["success"][goal] = float(success)
        if goal:
            scores["oracle_length"][goal], scores["learning_length"][goal] = oracle, learning
            scores["final_distance"][goal] = self._pose.distance(self._marks[goal])
            scores["spl"][goal] = path_share(oracle, driven, success=success)
            scores["spl_learning"][goal] = path_share(learning, driven, success=success)
        self._queue.call(phase.closing)
        self._begin()

    def _begin(self) -> None:
        """Begin the next phase; a goal whose mark was never given fails at once."""
        while (phase := self.phase) is not None and phase.goal not in (0, *self._marks):
            self.results.append(PhaseResult(phase.task, False, 0, 0.0, -1.0))
            self._scores["success"][phase.goal] = 0.0
        self._steps, self._phase_start = 0, self.path_length
        self._trail = Trail(self._world.plan, self._pose)
        self._lengths = -1.0, -1.0
        if phase is not None and phase.goal:
            phase = phase.arranged(self._world, self._routes, self._marks[phase.goal])
            done = len(self.results)
            self._phases = (*self._phases[:done], phase, *self._phases[done + 1 :])
        self._queue.expect(() if phase is None else phase.events)
        if phase is not None and phase.goal:
            mark, far = self._marks[phase.goal], self._range_max
            self._lengths = shortest_lengths(self._world, self._routes, self._queue, mark, far)
        self._events = self._queue.fire(self._trail.rooms)
