"""What an episode consists of: phases, how each ends, and how each came out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from cogmap_gym.events import Event
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.routes import Routes
from cogmap_gym.world import World

BEYOND_DOOR_M = 1.0
"""A lap ends this far from its last door [m]. DESIGN 4."""
MARK_GAP_M = 1.0
"""Marks other than home are given this far from any door, or farther [m]. DESIGN 3."""
UNLIMITED = 1_000_000_000
"""The budget of a phase that only the limit of the whole episode ends [moves]."""


@dataclass(frozen=True, slots=True)
class Lap:
    """A round through all of some rooms that ends beyond a door of the first of them."""

    rooms: tuple[str, ...]
    """All rooms to visit; the first is where the lap begins and ends."""
    last: str
    """The room from which the robot must come back."""
    door: str
    """The door between ``last`` and the first room."""

    def is_over(self, trail: tuple[str, ...], pose: Pose, world: World) -> bool:
        """Whether the trail of rooms makes the round and the pose is beyond the door."""
        if trail[-2:] != (self.last, self.rooms[0]) or not set(self.rooms) <= set(trail):
            return False
        gap = point_segment_distances(pose.position[None], world.segment(self.door))[0, 0]
        return bool(gap >= BEYOND_DOOR_M)


class Hindrance(Protocol):
    """Events that depend on where the robot is when its goal is given."""

    def arrange(
        self, world: World, routes: Routes, mark: Pose
    ) -> tuple[tuple[Event, ...], tuple[Event, ...]]:
        """The events of a phase that begins now, and those that put things right."""


@dataclass(frozen=True, slots=True)
class Phase:
    """One stretch of an episode with one goal, which ends in success or failure."""

    task: str
    """``"explore"``, ``"home"`` or ``"goto:k"``."""
    goal: int
    """What ``observation["goal"]`` says meanwhile: 0 explore, k go to mark k."""
    budget: int = UNLIMITED
    """After this many moves the phase is over."""
    budget_is_success: bool = False
    """Whether running out of the budget is a good end."""
    coverage: float | None = None
    """Under goal 0: the phase ends well once this share has been seen."""
    all_marks: bool = False
    """With ``coverage``: all marks must have been given, too, and the robot have left the room
    of the one that is asked for next."""
    lap: Lap | None = None
    """Under goal 0: the phase ends well once this lap is made."""
    in_room: bool = False
    """A declaration succeeds anywhere in the true room of the mark, not within 1.0 m of it."""
    events: tuple[Event, ...] = ()
    """What happens in this phase, each once, in this order for each door."""
    closing: tuple[Event, ...] = ()
    """What is put right when the phase ends."""
    hindrance: Hindrance | None = None
    """Adds events when the phase begins."""

    def is_over(
        self, trail: tuple[str, ...], coverage: float, world: World, *, marks_ready: bool
    ) -> bool:
        """Whether a phase of goal 0 has met its end."""
        if self.lap is not None:
            return self.lap.is_over(trail, world.pose, world)
        seen = self.coverage is not None and coverage >= self.coverage
        return seen and (marks_ready or not self.all_marks)

    def arranged(self, world: World, routes: Routes, mark: Pose) -> Phase:
        """The phase as it begins now: with the events of its hindrance, and without that."""
        if self.hindrance is None:
            return self
        events, closing = self.hindrance.arrange(world, routes, mark)
        return replace(
            self,
            events=(*self.events, *events),
            closing=(*self.closing, *closing),
            hindrance=None,
        )


@dataclass(frozen=True, slots=True)
class PhaseResult:
    """How a phase came out, in the terms of ``result.json``."""

    task: str
    success: bool
    moves: int
    path_length: float
    """True length driven [m]."""
    oracle_length: float
    """Shortest true length from where the phase began [m]; -1 for none or no route."""


@dataclass(frozen=True, slots=True)
class Itinerary:
    """All phases of an episode, and in which room each mark other than home is given."""

    phases: tuple[Phase, ...]
    mark_rooms: Mapping[int, str] = field(default_factory=dict)


class Course(Protocol):
    """What the episodes of a task consist of."""

    def check(self, plan: FloorPlan) -> None:
        """Raise ``ValueError`` if the plan lacks what the course needs."""

    def most_moves(self, plan: FloorPlan) -> int:
        """After how many moves an episode on this plan is cut, unless told otherwise."""

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:
        """The phases of one episode."""
