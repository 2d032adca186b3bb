"""What to go for next in a place: Algorithm 1, step 3 (thesis 3.3)."""

from __future__ import annotations

import numpy as np
import shapely

from agents.cogmap.curiosity import lead_points
from agents.cogmap.exit_sight import reach_to_exits
from agents.cogmap.exits import Exit
from agents.cogmap.leads import way_to_leads
from agents.cogmap.memory import CHECK, EXIT, GAP, LOOK, SPOT, Intent, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import exits_of
from agents.cogmap.view import View
from cogmap_gym.geometry import Points


def choose(memory: Memory, view: View, params: Params) -> Intent:
    """Step 3: select what to go for next."""
    stay, at = memory.stay, memory.pose.position
    if not stay.looked:
        spot = _well_inside(memory, _middle(memory, view, params), params)
        tried = memory.intent is not None and memory.intent.kind == SPOT
        if tried or not stay.entry or np.hypot(*(spot - at)) < params.exploration.arrival:
            return Intent(LOOK, at)
        return Intent(SPOT, spot)
    new = new_exit(memory, params)
    if new is not None:
        return Intent(EXIT, new.middle, new.id)
    doubtful = _nearest_doubtful(memory, params)
    if doubtful is not None:
        return Intent(CHECK, doubtful.middle, doubtful.id)
    gap = _best_gap(memory, lead_points(memory.stay.leads, params))
    if gap is not None:
        return Intent(GAP, gap)
    return _onward(memory, params)


def _onward(memory: Memory, params: Params) -> Intent:
    """Out of an explored place: to what others hide, else by the exit crossed longest ago."""
    stay = memory.stay
    onward = way_to_leads(memory, params) or _oldest_exit(memory, params)
    if onward is not None and onward.id == stay.entry and not _was_inside(memory, params):
        return Intent(SPOT, _well_inside(memory, onward.middle, params))
    if onward is not None:
        return Intent(EXIT, onward.middle, onward.id)
    if stay.entry and memory.exit(stay.entry).failures < params.exploration.max_failures:
        entry = memory.exit(stay.entry)  # a dead end
        return Intent(EXIT, entry.middle, entry.id)
    return Intent(LOOK, memory.pose.position)


def new_exit(memory: Memory, params: Params) -> Exit | None:
    """The exit of this place never crossed that is furthest away.

    "The robot is programmed to choose a potential exit that is furthest away" (thesis 3.3).
    """
    at = memory.pose.position
    options = [e for e in _usable(memory, params) if e.crossed < 0]
    return max(options, key=lambda e: float(np.hypot(*(e.middle - at))), default=None)


def _oldest_exit(memory: Memory, params: Params) -> Exit | None:
    """When all is known, the exit crossed longest ago, but not the entry."""
    options = [e for e in _usable(memory, params) if e.id != memory.stay.entry]
    return min(options, key=lambda e: e.crossed, default=None)


def _usable(memory: Memory, params: Params) -> list[Exit]:
    return [
        e
        for e in exits_of(memory.book, memory.stay.place)
        if e.trusted(params.exits) and e.failures < params.exploration.max_failures
    ]


def doubtful_exits(memory: Memory, params: Params) -> list[Exit]:
    """The exits of this place seen too seldom to count, not yet given up."""
    return [
        e
        for e in exits_of(memory.book, memory.stay.place)
        if not e.trusted(params.exits)
        and not e.false
        and e.failures < params.exploration.max_failures
    ]


def _nearest_doubtful(memory: Memory, params: Params) -> Exit | None:
    """The nearest exit seen too seldom to count."""
    at, options = memory.pose.position, doubtful_exits(memory, params)
    return min(options, key=lambda e: float(np.hypot(*(e.middle - at))), default=None)


def _best_gap(memory: Memory, gaps: Points) -> Points | None:
    """The gap to take: ahead and near."""
    if not len(gaps):
        return None
    seen = memory.pose.inverse().apply(gaps)
    cost = np.hypot(seen[:, 0], seen[:, 1]) + 2.0 * np.abs(np.arctan2(seen[:, 1], seen[:, 0]))
    return np.asarray(gaps[int(cost.argmin())])


def _middle(memory: Memory, view: View, params: Params) -> Points:
    """The most open spot (2,) in the MFIS of the free space in view, this side of all exits."""
    points = view.points[np.isfinite(view.points).all(axis=1)]
    if len(points) < 3:
        return memory.pose.position
    ends = memory.pose.apply(points)
    reach = np.minimum(params.exploration.survey_reach, np.hypot(points[:, 0], points[:, 1]))
    reach = np.minimum(reach, reach_to_exits(memory.book, memory.pose.position, ends, params.exits))
    rays = ends - memory.pose.position
    cut = rays * (reach / np.maximum(np.hypot(rays[:, 0], rays[:, 1]), 1e-9))[:, None]
    space = shapely.make_valid(shapely.Polygon(np.concatenate((np.zeros((1, 2)), cut))))
    radius = shapely.maximum_inscribed_circle(space, params.exploration.spot_tolerance)
    return np.asarray(memory.pose.position + shapely.get_coordinates(radius)[0])


def _was_inside(memory: Memory, params: Params) -> bool:
    """Whether the robot has gone well into this place since its entry, or tried to."""
    if memory.intent is not None and memory.intent.kind == SPOT:
        return True
    entry, path = memory.exit(memory.stay.entry), memory.stay.path
    away = np.hypot(*(path - entry.middle).T).max(initial=0.0)
    return bool(away > params.exploration.inside - params.exploration.arrival)


def _well_inside(memory: Memory, spot: Points, params: Params) -> Points:
    """The spot (2,), or one farther from the entry where it is too near to that."""
    if not memory.stay.entry:
        return spot
    entry, least = memory.exit(memory.stay.entry), params.exploration.inside
    if float(np.hypot(*(spot - entry.middle))) >= least:
        return spot
    return np.asarray(entry.middle + least * entry.side_of(memory.stay.place) * entry.normal)
