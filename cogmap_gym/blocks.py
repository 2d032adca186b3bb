"""Blocks: a door shut on the way that a robot knows, and a chord opened for it.

What is drawn is drawn when the episode begins, so that trials pair across robots; which
door that means depends on where the robot is when the goal is given.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from shapely.geometry import LineString

from cogmap_gym.chords import chords, doors_of, sides_of
from cogmap_gym.events import Event
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.routes import Routes, Solid
from cogmap_gym.world import World

PAYS_M = 0.01
"""A chord pays when it makes the way shorter by more than this [m]."""
Events = tuple[Event, ...]


@dataclass(frozen=True, slots=True)
class Crossed:
    """A door on a way."""

    door: str
    room: str
    """From which room the way comes to it; empty text for none."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A door to shut and a chord to open."""

    crossed: Crossed
    chord: tuple[str, ...]
    pays: bool
    """Whether the way by the chord is shorter than going back."""


@dataclass(frozen=True, slots=True)
class Block:
    """Shuts a door on the shortest way over the doors open at first, and opens a chord.

    The goal stays within reach, unless ``cut_off``. Where no door can be shut so, the goal is
    given without a block.
    """

    pick: float
    """Drawn in [0, 1): which of the choices."""
    entered: bool
    """Shut once the robot is in the room before the door; otherwise when the goal is given."""
    pays: bool = True
    """Prefer chords that make the way shorter than going back; otherwise those that do not."""
    cut_off: bool = False
    """Shut all doors of the goal's room instead, so that no way is left."""

    def arrange(self, world: World, routes: Routes, mark: Pose) -> tuple[Events, Events]:
        """The events for a goal given now, and those that open the door again after it."""
        if self.cut_off:
            return _cut_off(world, routes, mark)
        choices = _choices(world, routes, mark)
        choices = [choice for choice in choices if choice.pays == self.pays] or choices
        if not choices:
            return (), ()
        choice = choices[int(self.pick * len(choices))]
        crossed = choice.crossed
        opened = tuple(Event("open", door) for door in choice.chord)
        shut = Event("shut", crossed.door, crossed.room if self.entered else "")
        return (*opened, shut), (Event("open", crossed.door),)


def doors_on(world: World, way: Points) -> tuple[Crossed, ...]:
    """The doors that a way (K, 2) goes through, in order."""
    line, found = LineString(way), []
    for name, leaf in world.plan.doors.items():
        met = line.intersection(LineString(leaf))
        if not met.is_empty:
            found.append((line.project(met.centroid), name))
    rooms = [world.plan.room_at(*way[0]) or ""]
    crossed = []
    for _, name in sorted(found):
        one, other = sides_of(world.plan, name)
        crossed.append(Crossed(name, rooms[-1] if rooms[-1] in (one, other) else one))
        rooms.append(other if crossed[-1].room == one else one)
    return tuple(crossed)


def _choices(world: World, routes: Routes, mark: Pose) -> list[Choice]:
    """All doors that may be shut, each with all chords that may be opened."""
    plan, here, solid = world.plan, world.pose, routes.solid
    way = routes.way(here, mark, frozenset(plan.closed))
    if way is None:
        return []
    shut = [group for group in chords(plan) if solid & set(group)] or [()]
    found = []
    for crossed in doors_on(world, way):
        blocked = solid | {crossed.door}
        back = routes.distance(here, mark, blocked)
        for chord in shut:
            length = routes.distance(here, mark, blocked - set(chord))
            pays = length < back - PAYS_M or _leads_through(world, routes, mark, blocked, chord)
            if math.isfinite(length):
                found.append(Choice(crossed, chord, pays))
    return found


def _leads_through(
    world: World, routes: Routes, mark: Pose, solid: Solid, chord: tuple[str, ...]
) -> bool:
    """Whether, no chord being left to open, the shortest way takes one opened before."""
    way = None if chord else routes.way(world.pose, mark, solid)
    return way is not None and any(
        crossed.door in world.plan.closed for crossed in doors_on(world, way)
    )


def _cut_off(world: World, routes: Routes, mark: Pose) -> tuple[Events, Events]:
    """Shut the goal's room, if the robot is elsewhere and that leaves it no way."""
    room = world.plan.room_at(mark.x, mark.y)
    if room is None:
        return (), ()
    doors = tuple(door for door in doors_of(world.plan, room) if door not in world.shut_doors)
    if math.isfinite(routes.distance(world.pose, mark, routes.solid | set(doors))):
        return (), ()
    return tuple(Event("shut", d) for d in doors), tuple(Event("open", d) for d in doors)


def drawn_block(rng: np.random.Generator, dearer: float, unreachable: float) -> Block:
    """A block with all that chance decides.

    Args:
        rng: the stream of the goals.
        dearer: share of blocks whose chord is, where possible, no shorter than going back.
        unreachable: share of goals that are cut off.
    """
    pick, entered, pays, cut = rng.random(4).tolist()
    return Block(pick, entered < 0.5, pays=pays >= dearer, cut_off=cut < unreachable)
