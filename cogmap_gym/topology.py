"""Places and doors: which true room a believed place is, and which links are right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Pose, cross, point_segment_distances
from cogmap_gym.trail import ENTERED_M

BEYOND_M = 0.35
"""A door is crossed once the robot is so far beyond its line [m]. FINDINGS 2."""
DOOR_SIDE_M = 0.3
"""The rooms of a door hold the points so far to its sides [m]. Ours: over a wall's thickness."""
NOTICE_STEPS = 3
"""A crossing is noticed by a belief at most so many steps away [-]. Ours: two looks round."""

Link = tuple[frozenset[str], str]
"""The two rooms that a door joins, and the door."""


@dataclass(frozen=True, slots=True)
class Visit:
    """A true stay in one room."""

    room: str
    first: int
    """The first step clearly inside."""
    last: int
    """The last step before the robot is clearly in another room."""


def visits(plan: FloorPlan, poses: Array) -> list[Visit]:
    """The true stays of a path, in order.

    A room is entered once the robot is in it and 0.3 m or more from every door, as for
    ``cogmap_gym.trail``; a robot that stands in a doorway is still where it came from.

    Args:
        plan: the truth.
        poses: (T, 3) true poses.
    """
    gaps = point_segment_distances(poses[:, :2], plan.door_segments()).min(axis=1, initial=np.inf)
    out: list[Visit] = []
    for step, (x, y) in enumerate(poses[:, :2].tolist()):
        room = plan.room_at(x, y)
        if room and (not out or (room != out[-1].room and gaps[step] >= ENTERED_M)):
            out.append(Visit(room, step, step))
        elif out:
            out[-1] = Visit(out[-1].room, out[-1].first, step)
    return out


@dataclass(frozen=True, slots=True)
class Crossing:
    """The moment at which a robot has gone through a door."""

    step: int
    door: str


def true_crossings(plan: FloorPlan, poses: Array) -> list[Crossing]:
    """The doors that a path goes through, each when the robot is 0.35 m beyond its line.

    A robot that turns back before that has crossed nothing.

    Args:
        plan: the truth.
        poses: (T, 3) true poses.
    """
    found: list[Crossing] = []
    for name, door in plan.doors.items():
        along = door[1] - door[0]
        width = float(np.hypot(*along))
        from_jamb = poses[:, :2] - door[0]
        side = cross(along, from_jamb) / width
        at = from_jamb @ along / width
        under_way = False
        for step in range(1, len(poses)):
            a, b = side[step - 1], side[step]
            if (a < 0.0) != (b < 0.0):
                meets = at[step - 1] + a / (a - b) * (at[step] - at[step - 1])
                under_way ^= 0.0 <= meets <= width
            if under_way and abs(b) >= BEYOND_M:
                found.append(Crossing(step, name))
                under_way = False
    return sorted(found, key=lambda crossing: crossing.step)


@dataclass(frozen=True, slots=True)
class Notices:
    """Which crossings a robot noticed."""

    pairs: tuple[tuple[int, int], ...]
    """Rows of true and of believed crossings that are one."""
    true: int
    """How many doors it truly crossed."""
    false: int
    """How many crossings it believed that were none."""


def noticed(true: Sequence[Crossing], believed: Sequence[int]) -> Notices:
    """Pair true crossings with believed ones, at most three steps apart, in order of time.

    Args:
        true: in order of time.
        believed: the steps at which the robot thought it had crossed an exit, in order.
    """
    pairs: list[tuple[int, int]] = []
    free = list(range(len(believed)))
    for row, crossing in enumerate(true):
        near = [k for k in free if abs(believed[k] - crossing.step) <= NOTICE_STEPS]
        if near:
            best = min(near, key=lambda k: abs(believed[k] - crossing.step))
            free.remove(best)
            pairs.append((row, best))
    return Notices(tuple(pairs), len(true), len(free))


def true_links(plan: FloorPlan, rooms: Iterable[str]) -> frozenset[Link]:
    """The doors between these rooms, each with the two it joins."""
    wanted, links = set(rooms), set()
    for name, door in plan.doors.items():
        along = door[1] - door[0]
        aside = DOOR_SIDE_M * np.array((-along[1], along[0])) / np.hypot(*along)
        middle = door.mean(axis=0)
        sides = frozenset(str(plan.room_at(*(middle + k * aside))) for k in (-1.0, 1.0))
        if len(sides) == 2 and sides <= wanted:
            links.add((sides, name))
    return frozenset(links)


def rooms_of_places(places: Sequence[int], rooms: Sequence[str], until: int) -> dict[int, str]:
    """For each believed place the true room in which most of its steps were spent.

    Args:
        places: at each step the place the robot believed to be in.
        rooms: at each step the true room.
        until: the last step that counts.
    """
    votes: dict[int, Counter[str]] = {}
    for place, room in zip(places[: until + 1], rooms[: until + 1], strict=True):
        votes.setdefault(place, Counter())[room] += 1
    return {place: counter.most_common(1)[0][0] for place, counter in votes.items()}


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong with a network of places."""

    kind: str
    """What kind of fault, such as ``"place doubled"``."""
    about: str
    """Which room or link."""
    text: str
    """The same in words."""


def topology_faults(
    places: Iterable[int],
    links: Iterable[tuple[int, int, int]],
    room_of: Mapping[int, str],
    door_of: Mapping[int, str],
    wanted: frozenset[Link],
) -> list[Fault]:
    """What is wrong with a network of places; nothing where it is the true one.

    Args:
        places: ids of the places the robot believes in, with the one where it is.
        links: (place, exit, place).
        room_of: the true room of each place.
        door_of: the true door of each exit that was crossed.
        wanted: the true links; their rooms are those to be found, each once.
    """
    known = sorted(set(places))
    named = Counter(room_of.get(place, "nowhere") for place in known)
    rooms = {room for sides, _ in wanted for room in sides}
    faults = [_count_fault(room, named[room]) for room in sorted(rooms) if named[room] != 1]
    others = sorted(set(named) - rooms)
    faults += [Fault("place of no room", room, f"a place is {room}") for room in others]
    found = Counter(
        (frozenset(room_of.get(p, "nowhere") for p in (a, b)), door_of.get(e, f"exit {e}"))
        for a, e, b in links
    )
    missing = sorted(_say(link) for link in wanted - set(found))
    faults += [Fault("link missing", name, f"no link {name}") for name in missing]
    faults += [
        Fault("link doubled" if k in wanted else "link wrong", _say(k), f"link {_say(k)} {n}x")
        for k, n in found.items()
        if k not in wanted or n > 1
    ]
    return faults


def _count_fault(room: str, count: int) -> Fault:
    return Fault(f"place {'doubled' if count else 'missing'}", room, f"{room} is {count} places")


def _say(link: Link) -> str:
    return f"{'-'.join(sorted(link[0]))} by {link[1]}"


def boundary_ious(
    boundaries: Mapping[int, Points],
    room_of: Mapping[int, str],
    plan_from_map: Pose,
    plan: FloorPlan,
) -> dict[int, float]:
    """How well each closed boundary agrees with the free space of its true room.

    Intersection over union of areas; furniture and whatever else stands in the room is
    taken out of both.

    Args:
        boundaries: of each place, (K, 2) in the map's frame; the open ones, (0, 2), are left out.
        room_of: the true room of each place.
        plan_from_map: the one rigid fit of the run.
        plan: the truth.
    """
    out: dict[int, float] = {}
    for place, boundary in boundaries.items():
        if len(boundary) and room_of.get(place, "") in plan.rooms:
            free = plan.room_free_space(room_of[place])
            solid = shapely.Polygon(plan.rooms[room_of[place]]).difference(free)
            drawn = shapely.make_valid(shapely.Polygon(plan_from_map.apply(boundary)))
            drawn = drawn.difference(solid)
            out[place] = float(drawn.intersection(free).area / drawn.union(free).area)
    return out
