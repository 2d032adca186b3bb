"""Events: doors that shut or open and barriers that come and go during an episode."""

from __future__ import annotations

from dataclasses import dataclass

from cogmap_gym.geometry import point_segment_distances
from cogmap_gym.world import World

CLEAR_OF_EVENTS_M = 0.5
"""An event waits while the robot's body is nearer to it than this [m]. DESIGN 4."""
KINDS = ("shut", "open", "place", "remove")
"""What an event can do: the first two to a door, the others to a barrier."""


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

    def is_clear(self, world: World) -> bool:
        """Whether the robot's body is far enough away for the event to fire."""
        at = world.pose.position[None]
        gap = point_segment_distances(at, world.segment(self.name))[0, 0] - world.robot.radius
        return bool(gap >= CLEAR_OF_EVENTS_M)

    def is_done(self, world: World) -> bool:
        """Whether the world already is as the event would make it."""
        there = self.name in world.shut_doors or self.name in world.present_barriers
        return there == (self.kind in ("shut", "place"))

    def fire(self, world: World) -> str:
        """Change the world; answer what ``info["events"]`` tells."""
        change = world.set_door if self.kind in ("shut", "open") else world.set_barrier
        change(self.name, self.kind in ("shut", "place"))
        return f"{self.kind} {self.name}"


class EventQueue:
    """Holds events until they are due and the robot is out of their way."""

    def __init__(self, world: World) -> None:
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
