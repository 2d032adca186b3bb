"""Events: doors that shut or open and barriers that come and go during an episode."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from cogmap_gym.geometry import Pose, Segments, point_segment_distances
from cogmap_gym.observation import RobotSpec

CLEAR_OF_EVENTS_M = 0.5
"""An event waits while the robot's body is nearer to it than this [m]. DESIGN 4."""
KINDS = ("shut", "open", "place", "remove")
"""What an event can do: the first two to a door, the others to a barrier."""


class Changeable(Protocol):
    """What events change and ask: the world, or what stands for it on an imagined walk."""

    @property
    def robot(self) -> RobotSpec:
        """The size of the body."""

    @property
    def pose(self) -> Pose:
        """Where the robot is."""

    @property
    def shut_doors(self) -> frozenset[str]:
        """Names of the doors that are shut."""

    @property
    def present_barriers(self) -> frozenset[str]:
        """Names of the barriers that stand."""

    def segment(self, name: str) -> Segments:
        """Where a door or a barrier is when it is in the way, (1, 2, 2)."""

    def set_door(self, name: str, shut: bool) -> None:
        """Shut or open a door."""

    def set_barrier(self, name: str, present: bool) -> None:
        """Place a barrier or take it away."""


@dataclass(frozen=True, slots=True)
class Event:
    """A change of the world: at once, or when the robot comes into a room."""

    kind: str
    """One of ``KINDS``."""
    name: str
    """Which door or barrier."""
    room: str = ""
    """Fires once the robot is in this room; empty: when its phase begins."""
    after: str = ""
    """Only when the robot came from this room; empty: from anywhere."""

    def is_due(self, trail: tuple[str, ...]) -> bool:
        """Whether the rooms visited in this phase, in order, call for the event."""
        if not self.room:
            return True
        came_from = trail[-2] if len(trail) > 1 else ""
        return trail[-1:] == (self.room,) and self.after in ("", came_from)

    def is_clear(self, world: Changeable) -> bool:
        """Whether the robot's body is far enough away for the event to fire."""
        at = world.pose.position[None]
        gap = point_segment_distances(at, world.segment(self.name))[0, 0] - world.robot.radius
        return bool(gap >= CLEAR_OF_EVENTS_M)

    def is_done(self, world: Changeable) -> bool:
        """Whether the world already is as the event would make it."""
        there = self.name in world.shut_doors or self.name in world.present_barriers
        return there == (self.kind in ("shut", "place"))

    def fire(self, world: Changeable) -> str:
        """Change the world; answer what ``info["events"]`` tells."""
        change = world.set_door if self.kind in ("shut", "open") else world.set_barrier
        change(self.name, self.kind in ("shut", "place"))
        return f"{self.kind} {self.name}"


def after(solid: frozenset[str], events: Iterable[Event]) -> frozenset[str]:
    """The names of what is shut or in the way once some events have happened, in order."""
    for event in events:
        added = event.kind in ("shut", "place")
        solid = solid | {event.name} if added else solid - {event.name}
    return solid


class EventQueue:
    """Holds events until they are due and the robot is out of their way."""

    def __init__(self, world: Changeable) -> None:
        """No events yet."""
        self._world = world
        self._waiting: tuple[Event, ...] = ()
        self._due: tuple[Event, ...] = ()

    def expect(self, events: tuple[Event, ...]) -> None:
        """Wait for these events from now on, and for no others."""
        self._waiting = events

    def call(self, events: tuple[Event, ...]) -> None:
        """These events are due; each takes the place of one that is due at the same thing."""
        names = {event.name for event in events}
        self._due = (*(event for event in self._due if event.name not in names), *events)

    def copy_for(self, world: Changeable) -> EventQueue:
        """A queue that expects the same of another world."""
        queue = EventQueue(world)
        queue._waiting, queue._due = self._waiting, self._due
        return queue

    def outcome(self) -> frozenset[str]:
        """What will be shut or in the way once all that is waited for has happened."""
        return after(self._world.shut_doors | self._world.present_barriers, self.pending)

    @property
    def pending(self) -> tuple[Event, ...]:
        """All that has not happened yet, what is due first."""
        return (*self._due, *self._waiting)

    @property
    def has_due(self) -> bool:
        """Whether something waits for nothing but the robot's leaving."""
        return bool(self._due)

    def fire(self, trail: tuple[str, ...]) -> tuple[str, ...]:
        """Fire what is due and clear of the robot.

        Args:
            trail: the rooms visited in this phase, in order.

        Returns:
            What happened, such as ``"shut E6"``.
        """
        for event in self._waiting:
            if event.is_due(trail):
                self.call((event,))
        self._waiting = tuple(event for event in self._waiting if event not in self._due)
        changes = tuple(event for event in self._due if not event.is_done(self._world))
        clear = tuple(event for event in changes if event.is_clear(self._world))
        self._due = tuple(event for event in changes if event not in clear)
        return tuple(event.fire(self._world) for event in clear)
