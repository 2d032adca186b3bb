"""Places recognised and not: merges judged against the truth.

A robot that goes through an exit it has no link for is in a place it takes for unknown, until
it recognises it (a merge), or leaves it and so cuts it as a new place.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from cogmap_gym.office_record import Moment
from cogmap_gym.topology import rooms_of_places

RIGHT, WRONG, MISSED, NEW, SPLIT = "right", "wrong", "missed", "new", "split"
"""Verdicts: merged with a place of the true room; with one of another room; not merged in a room
that has a place; a room without one; the room it came from, cut in two by an exit that is none."""
REENTRIES = (RIGHT, WRONG, MISSED)
"""The verdicts of stays that were, or were taken for, a room known before."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A stay that began beyond an exit without a link, once it was decided what it was."""

    step: int
    """When that was decided."""
    room: str
    """Where the robot truly was."""
    taken_for: str
    """The true room of the place it merged with; empty where it did not."""
    verdict: str
    """One of the words above."""


def entries(moments: Sequence[Moment], rooms: Sequence[str]) -> list[Entry]:
    """All stays that began in an unlinked place and were decided, in order.

    Args:
        moments: of one episode.
        rooms: at each of them the true room.
    """
    firsts = [t for t, m in enumerate(moments) if t and m.began != moments[t - 1].began]
    cut: set[int] = set()
    found = []
    for first, after in pairwise([*firsts, len(moments)]):
        cut.add(moments[first].came_from)
        entry = _entry(moments, rooms, first, after, cut)
        found += [entry] if entry is not None else []
    return found


def _entry(
    moments: Sequence[Moment], rooms: Sequence[str], first: int, after: int, cut: set[int]
) -> Entry | None:
    """What became of the stay of rows ``first`` to ``after``; None for a linked or an open one."""
    start = moments[first]
    if start.known:
        return None
    room_of = rooms_of_places([m.place for m in moments], list(rooms), first - 1)
    came_from = room_of.get(start.came_from, "")
    at = next((t for t in range(first, after) if moments[t].place != start.place), after)
    most = Counter(rooms[first:at]).most_common(1)[0][0]
    if at < after:  # recognised in the middle of the stay
        return _merged(at, rooms[at], room_of.get(moments[at].place, ""))
    if after == len(moments):
        return None
    if moments[after].came_from != start.place:  # recognised as it was left
        return _merged(after, most, room_of.get(moments[after].came_from, ""))
    if most == came_from:
        return Entry(after, most, "", SPLIT)
    known = {room_of[place] for place in cut if place in room_of}
    return Entry(after, most, "", MISSED if most in known else NEW)


def _merged(step: int, room: str, taken_for: str) -> Entry:
    return Entry(step, room, taken_for, RIGHT if room == taken_for else WRONG)
