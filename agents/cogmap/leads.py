"""What other places still hide, and the way to the nearest of it."""

from __future__ import annotations

import numpy as np

from agents.cogmap.curiosity import lead_points
from agents.cogmap.exits import Exit
from agents.cogmap.memory import Memory
from agents.cogmap.params import Params
from agents.cogmap.places import Route, exits_of, route
from cogmap_gym.geometry import Points


def way_to_leads(memory: Memory, params: Params) -> Exit | None:
    """The first exit on the way to the nearest lead in another place, or None when all is known.

    Leads are exits never crossed, and gaps and walls left unexplored. For an exit a robot turns
    back where it came in; for the others only if it cannot go on, or a lap would lose its sense.
    """
    at, here = memory.pose.position, memory.stay.place
    recent = memory.mapping.step - params.exploration.shut_for
    failed = frozenset(
        e.id
        for e in memory.book
        if e.failures >= params.exploration.max_failures
        or (e.given_up >= 0 and e.given_up > recent)
    )
    best: Route | None = None
    for place, spot, new_exit in _spots(memory, params):
        way = route(memory.book, at, here, spot, place, failed)
        if way is None or not way.exits or (not new_exit and _turns_back(memory, way, params)):
            continue
        if best is None or way.length < best.length:
            best = way
    return memory.exit(best.exits[0]) if best is not None else None


def _turns_back(memory: Memory, way: Route, params: Params) -> bool:
    """Whether a way leads out where the robot came in, and it might go on instead."""
    entry = memory.stay.entry
    others = [
        e
        for e in exits_of(memory.book, memory.stay.place)
        if e.id != entry and e.crossed >= 0 and e.trusted(params.exits)
    ]
    return way.exits[0] == entry and len(others) > 0


def unexplored(memory: Memory, params: Params) -> bool:
    """Whether anything is left to explore, here or in a place that can be reached."""
    here = len(lead_points(memory.stay.leads, params)) > 0
    return here or way_to_leads(memory, params) is not None


def _spots(memory: Memory, params: Params) -> list[tuple[int, Points, bool]]:
    """(place, a lead (2,) in it, whether that is an exit) of every other place that has any."""
    at = memory.pose.position
    spots: list[tuple[int, Points, bool]] = []
    for e in memory.book:
        if e.crossed < 0 and e.failures < params.exploration.max_failures and _real(e):
            spots.extend((p, e.middle, True) for p in {e.left, e.right} if _known(memory, p))
    for place, leads in memory.leads:
        points = lead_points(leads, params)
        if len(points) and _known(memory, place):
            spots.append((place, points[int(np.hypot(*(points - at).T).argmin())], False))
    return spots


def _real(e: Exit) -> bool:
    return e.sightings > 0 and not e.false and e.left != e.right


def _known(memory: Memory, place: int) -> bool:
    return place != memory.stay.place and any(
        e.crossed >= 0 and place in (e.left, e.right) for e in memory.book
    )
