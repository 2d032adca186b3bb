"""The ways that the robot weighs where its way is shut, told for people (thesis 4.4.2)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from agents.cogmap.memory import Mark, Memory, place_of
from agents.cogmap.params import Params
from agents.cogmap.places import Route, exits_of, route
from cogmap_gym.geometry import Points

KNOWN, BACK, NEW = "known", "back", "new"
"""Kinds of ways: the known one that is shut, the best of those not found shut, a new exit."""


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """A way to a mark."""

    kind: str
    """``KNOWN``, ``BACK`` or ``NEW``."""
    exits: tuple[int, ...]
    """Ids of the exits to cross, in order."""
    points: Points
    """(P, 2) in the MFIS, from the robot over the exits to the mark."""
    length: float
    """Metres, in straight lines."""


def newly_chosen(memory: Memory) -> int:
    """Id of the exit never crossed that the robot is going to cross on a journey, or 0."""
    if memory.journey is None or not memory.journey.blocked or not memory.route:
        return 0
    first = memory.exit(memory.route[0])
    return first.id if first.crossed < 0 else 0


def weighed(memory: Memory, params: Params) -> tuple[Option, ...]:
    """The options of the present journey; none without a journey."""
    mark = None if memory.journey is None else memory.mark(memory.journey.mark)
    if memory.journey is None or mark is None:
        return ()
    mark = replace(mark, place=place_of(memory, mark))
    blocked, at = memory.journey.blocked, memory.pose.position
    place = memory.stay.place
    known = route(memory.book, at, place, mark.point, mark.place, frozenset())
    back = route(memory.book, at, place, mark.point, mark.place, blocked)
    found = []
    if known is not None and set(known.exits) & blocked:
        found.append(_option(memory, mark, KNOWN, known))
    if back is not None:
        found.append(_option(memory, mark, BACK, back))
    new = [
        Route((e.id,), _length(np.array((at, e.middle, mark.point))))
        for e in exits_of(memory.book, place)
        if e.trusted(params.exits) and e.crossed < 0 and e.id not in blocked
    ]
    return (*found, *(_option(memory, mark, NEW, way) for way in new))


def _option(memory: Memory, mark: Mark, kind: str, way: Route) -> Option:
    middles = [memory.exit(e).middle for e in way.exits]
    return Option(
        kind, way.exits, np.array((memory.pose.position, *middles, mark.point)), way.length
    )


def _length(points: Points) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
