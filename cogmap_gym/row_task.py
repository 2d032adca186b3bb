"""The worlds and tasks of single robots of a fleet.

The rules are those of ``tasks``, asked only when they can matter.

In nearly every step of a robot nothing happens but a small reward, which the compiled step has
the numbers for. ``RowTask`` says what to wait for: a declaration, a share seen, a budget used
up, a room entered. Only then is its ``Task`` asked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cogmap_gym.coverage import Coverage
from cogmap_gym.fleet import Fleet
from cogmap_gym.geometry import Array, Points, Pose, point_segment_distances, wrap_angle
from cogmap_gym.observation import RobotSpec
from cogmap_gym.raycast_kernel import Ints
from cogmap_gym.scores import SCORES
from cogmap_gym.tasks import Task
from cogmap_gym.world import World

NO_LIMIT = int(np.iinfo(np.int64).max)
"""Of the steps of a phase."""


@dataclass(frozen=True, slots=True)
class Watch:
    """What a robot's task waits for."""

    steps: int
    """So many steps of the phase."""
    share: float
    """So much seen, 0 to 1; more than 1 for nothing of the kind."""
    rooms: bool
    """Any room entered."""
    always: bool
    """Any step."""


class RowBody:
    """The body of one robot of a fleet, as a world asks for it."""

    def __init__(self, world: RowWorld, fleet: Fleet, row: int) -> None:
        """Somewhere."""
        self._world, self._fleet, self._row = world, fleet, row

    @property
    def pose(self) -> Pose:
        """The true pose."""
        robot = self._fleet.robots[self._row]
        return Pose(float(robot["x"]), float(robot["y"]), float(robot["theta"]))

    @pose.setter
    def pose(self, pose: Pose) -> None:
        self._fleet.place(self._row, pose.x, pose.y, wrap_angle(pose.theta))

    def clearance(self, point: tuple[float, float]) -> float:
        """Metres between the disc, were it centred at ``point``, and the nearest solid thing."""
        world = self._world
        gaps = point_segment_distances(np.array((point,)), world.solid_segments)
        return float(gaps.min()) - world.robot.radius

    def set_solid(self, row: int, *, solid: bool) -> None:
        """Put a segment in the way, or let the disc pass through it."""
        self._fleet.solid[self._row, row - len(self._world.fixed_segments)] = solid


class RowWorld(World):
    """The world of one robot of a fleet, whose arrays hold its truth. It does not move here."""

    def __init__(self, fleet: Fleet, row: int, robot: RobotSpec) -> None:
        """With the doors as the plan has them at first."""
        site = fleet.sites[fleet.where[row]]
        self.plan, self.robot = site.plan, robot
        names = (*self.plan.door_names, *self.plan.barrier_names)
        self._rows = {name: k for k, name in enumerate(names)}
        self._fixed, self.movable_segments = site.fixed, site.movable
        self._body = RowBody(self, fleet, row)  # type: ignore[assignment]
        self._checked = False
        self.begin(None)

    def begin(self, home: Pose | None) -> None:
        """Put the robot at ``home``, or the plan's, and the doors as the plan has them.

        Raises:
            ValueError: if home is no place for the robot.
        """
        self._shut, self._present = frozenset(self.plan.closed), frozenset()
        for name in self._rows:
            self._set_solid(name, name in self._shut)
        if home is None and self._checked:
            self._body.pose = self.plan.home
        else:
            self.place(self.plan.home if home is None else home)
        self._checked = self._checked or home is None

    def __getstate__(self) -> dict[str, Any]:
        """All of it: nothing here is pymunk's."""
        return self.__dict__

    def __setstate__(self, state: dict[str, Any]) -> None:
        """As it was."""
        self.__dict__.update(state)

    def _set_solid(self, name: str, solid: bool) -> None:
        self._body.set_solid(len(self._fixed) + self._rows[name], solid=solid)


class RowCoverage(Coverage):
    """What one robot of a fleet has seen, of which the compiled step keeps count."""

    def __init__(self, fleet: Fleet, row: int, seen: Ints) -> None:
        """Nothing seen yet; ``seen`` (N,) counts the cells that every robot has seen."""
        self._fleet, self._row, self._counts = fleet, row, seen
        self._total = fleet.sites[fleet.where[row]].cells

    @property
    def share(self) -> float:
        """Seen free area over all reachable free area, 0 to 1."""
        return float(self._counts[self._row] / self._total)

    def forget(self) -> None:
        """What was seen is forgotten as the robot is placed."""

    def look(self, pose: Pose) -> float:  # noqa: ARG002 - the step has looked from there
        """The share that was new in the last step."""
        return float(self._fleet.robots[self._row]["new"] / self._total)


class RowTask(Task):
    """The task of one robot of a fleet."""

    def step_from(
        self, before: Pose, steps: int, length: float, entered: list[str], *, declared: bool
    ) -> tuple[float, bool]:
        """Judge one step, after steps of which the task was not told.

        Args:
            before: where the robot stood before the step.
            steps: how many of this phase came before it.
            length: of the robot's way in this episode, the step included [m].
            entered: the rooms it entered in this phase since it was told last.
            declared: whether the robot said "I am there".
        """
        self._pose, self._steps, self.path_length = before, steps, length
        self._trail.rooms = (*self._trail.rooms, *entered)
        return self.step(None, declared=declared)

    @property
    def rooms(self) -> tuple[str, ...]:
        """The names of the plan's rooms."""
        return self._world.plan.room_names

    @property
    def last_room(self) -> str:
        """The room that was entered last in this phase; empty text for none."""
        return self._trail.rooms[-1] if self._trail.rooms else ""

    @property
    def events(self) -> tuple[str, ...]:
        """What happened to doors and barriers in the last step."""
        return self._events

    @property
    def scores(self) -> list[Array]:
        """The scores by mark, in the order of ``SCORES``, each (MARKS,)."""
        return [self._scores[name] for name in SCORES]

    @property
    def open_marks(self) -> set[str]:
        """The rooms in which a mark is still to be given."""
        return {room for mark, room in self._mark_rooms.items() if mark not in self._marks}

    def way(self, goal: int) -> tuple[Points, Array, float]:
        """What ``Routes.lengths_to`` says of a mark."""
        return self._routes.lengths_to(self._marks[goal])

    def distance(self, goal: int) -> float:
        """From the robot to a mark by the shortest way [m]."""
        return self._routes.distance(self._world.pose, self._marks[goal])

    def watch(self) -> Watch:
        """What must be waited for."""
        phase = self.phase
        if phase is None:
            return Watch(NO_LIMIT, 2.0, rooms=False, always=False)
        always, rooms = self._queue.has_due, bool(self._queue.pending) or phase.lap is not None
        if phase.lap is not None:
            ends = phase.lap.last, phase.lap.rooms[0]
            always = always or self._trail.rooms[-2:] == ends
        share = 2.0
        if phase.goal == 0 and phase.coverage is not None:
            share = 2.0 if phase.all_marks and self.open_marks else phase.coverage
        return Watch(phase.budget * self._steps_a_move, share, rooms=rooms, always=always)
