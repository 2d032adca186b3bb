"""Algorithm 1: autonomous exploration, place by place (thesis 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.curiosity import lead_points
from agents.cogmap.driving import (
    Action,
    doorway_is_clear,
    drive_before,
    drive_through,
    drive_to,
    turn,
)
from agents.cogmap.exits import Exit, give_up_exit, reach_to_exits, try_again
from agents.cogmap.false_exits import doubt_exit
from agents.cogmap.leads import way_to_leads
from agents.cogmap.memory import CHECK, EXIT, GAP, LOOK, SPOT, Intent, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import exits_of
from agents.cogmap.view import View
from cogmap_gym.geometry import Points
from cogmap_gym.observation import RobotSpec


def explore(memory: Memory, view: View, robot: RobotSpec, params: Params) -> tuple[Memory, Action]:
    """Algorithm 1: autonomous exploration.

    Departs from steps 3 and 4, by which the robot never left the first room (FINDINGS 2): it stays
    with the exit or gap it chose until it is there, looks round once in each new place, does not
    go back by the exit it came in by while there is another, and lines up before a door.

    Args:
        memory: after perception (steps 1 and 2).
        view: the present view, in the robot's frame.
        robot: limits of a move.
        params: all thresholds.
    """
    for _ in range(params.exploration.patience):
        # Step 3
        if memory.intent is not None and memory.intent.steps > _patience(memory.intent, params):
            memory = give_up(memory)
        memory = _shut(_doubted(memory, params), params)
        memory = _arrived(memory, params)
        intent = _valid(memory, params) or choose(memory, view, params)
        memory = replace(memory, intent=replace(intent, steps=intent.steps + 1))
        # Step 4
        memory, action = pursue(memory, robot, params)
        if action is not None:
            return memory, action
        memory = give_up(memory)
    return memory, turn(robot.max_turn, robot)


def _patience(intent: Intent, params: Params) -> int:
    """For how many steps an intent is followed."""
    p = params.exploration
    return p.exit_patience if intent.kind == EXIT else p.patience


def _doubted(memory: Memory, params: Params) -> Memory:
    """Note the exit in hand as false if it is near and turns out to part nothing."""
    intent = memory.intent
    if intent is None or intent.kind not in (EXIT, CHECK):
        return memory
    target = memory.exit(intent.exit)
    away = float(np.hypot(*(target.middle - memory.pose.position)))
    if target.crossed >= 0 or target.false or away > params.journeys.near_exit:
        return memory
    return doubt_exit(memory, target.id, params)


def _shut(memory: Memory, params: Params) -> Memory:
    """Give up the exit in hand at once if something is seen to stand in it."""
    intent = memory.intent
    if intent is None or intent.kind != EXIT or not memory.stay.settled:
        return memory
    target = memory.exit(intent.exit)
    if doorway_is_clear(memory, target, params):
        return memory
    times = params.exploration.max_failures
    book = give_up_exit(memory.book, target.id, memory.mapping.step, times)
    return replace(memory, book=book, intent=None)


def _arrived(memory: Memory, params: Params) -> Memory:
    """Note a gap that is reached, or that no longer hides anything."""
    intent = memory.intent
    if intent is None or intent.kind != GAP:
        return memory
    near = float(np.hypot(*(intent.target - memory.pose.position))) < params.exploration.arrival
    hides = _about(lead_points(memory.stay.leads, params), intent.target, params).any()
    if hides and not near:
        return memory
    return replace(_without(memory, intent.target), intent=None)


def _valid(memory: Memory, params: Params) -> Intent | None:
    """The present intent, while there is reason to go on with it."""
    p, intent, stay = params.exploration, memory.intent, memory.stay
    if intent is None:
        return None
    if intent.kind == LOOK:
        return None if stay.looked and stay.turned == 0.0 else intent
    if intent.kind == EXIT:
        target = memory.exit(intent.exit)
        usable = (
            target.trusted(params.exits)
            and target.side_of(stay.place) != 0
            and target.failures < params.exploration.max_failures
        )
        return replace(intent, target=target.middle) if usable else None
    if intent.kind == SPOT:
        away = float(np.hypot(*(intent.target - memory.pose.position)))
        return intent if away >= p.arrival else None
    if intent.kind == CHECK:
        doubtful = memory.exit(intent.exit)
        return None if doubtful.false or doubtful.trusted(params.exits) else intent
    if intent.kind == GAP and _new_exit(memory, params) is not None:
        return None
    return intent


def choose(memory: Memory, view: View, params: Params) -> Intent:
    """Step 3: select what to go for next."""
    stay, at = memory.stay, memory.pose.position
    if not stay.looked:
        spot = _well_inside(memory, _middle(memory, view, params), params)
        tried = memory.intent is not None and memory.intent.kind == SPOT
        if tried or not stay.entry or np.hypot(*(spot - at)) < params.exploration.arrival:
            return Intent(LOOK, at)
        return Intent(SPOT, spot)
    new = _new_exit(memory, params)
    if new is not None:
        return Intent(EXIT, new.middle, new.id)
    doubtful = _doubtful_exit(memory, params)
    if doubtful is not None:
        return Intent(CHECK, doubtful.middle, doubtful.id)
    gap = _best_gap(memory, lead_points(memory.stay.leads, params))
    if gap is not None:
        return Intent(GAP, gap)
    onward = way_to_leads(memory, params) or _oldest_exit(memory, params)
    if onward is not None and onward.id == stay.entry and not _was_inside(memory, params):
        return Intent(SPOT, _well_inside(memory, onward.middle, params))
    if onward is not None:
        return Intent(EXIT, onward.middle, onward.id)
    if stay.entry and memory.exit(stay.entry).failures < params.exploration.max_failures:
        entry = memory.exit(stay.entry)  # a dead end
        return Intent(EXIT, entry.middle, entry.id)
    return Intent(LOOK, at)


def _new_exit(memory: Memory, params: Params) -> Exit | None:
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


def _doubtful_exit(memory: Memory, params: Params) -> Exit | None:
    """The nearest exit seen too seldom to count."""
    at = memory.pose.position
    options = [
        e
        for e in exits_of(memory.book, memory.stay.place)
        if not e.trusted(params.exits)
        and not e.false
        and e.failures < params.exploration.max_failures
    ]
    return min(options, key=lambda e: float(np.hypot(*(e.middle - at))), default=None)


def _about(points: Points, target: Points, params: Params) -> NDArray[np.bool_]:
    """Which points (P, 2) mean the same target (2,), (P,)."""
    return np.asarray(np.hypot(*(points - target).T) < params.exploration.same_target)


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


def pursue(memory: Memory, robot: RobotSpec, params: Params) -> tuple[Memory, Action | None]:
    """Step 4: the next move for the present intent; None without a way."""
    intent, stay = memory.intent, memory.stay
    assert intent is not None, "an intent is chosen before it is pursued"
    if intent.kind == LOOK:
        left = params.exploration.look_turn - stay.turned
        step = min(robot.max_turn, left)
        done = stay.turned + step >= params.exploration.look_turn - 1e-9
        memory = memory.with_stay(turned=0.0 if done else stay.turned + step, looked=done)
        return (_afresh(memory) if done else memory), turn(step, robot)
    if intent.kind in (EXIT, CHECK):
        target = memory.exit(intent.exit)
        side = float(target.side_of(stay.place))
        if intent.kind == CHECK:
            return memory, drive_before(memory, target, side, robot, params)
        return memory, drive_through(memory, target, side, robot, params)
    return memory, drive_to(memory, intent.target, robot, params, leaving=False)


def _afresh(memory: Memory) -> Memory:
    """After a look round, what was given up here may be tried again."""
    book = try_again(memory.book, memory.stay.place)
    return replace(memory, book=book)


def give_up(memory: Memory) -> Memory:
    """Note that the present intent cannot be reached."""
    intent = memory.intent
    assert intent is not None, "only an intent can be given up"
    if intent.kind in (EXIT, CHECK):
        book = give_up_exit(memory.book, intent.exit, memory.mapping.step, 1)
        return replace(memory, book=book, intent=None)
    if intent.kind == GAP:
        return replace(_without(memory, intent.target), intent=None)
    return (
        memory.with_stay(looked=True)
        if intent.kind == LOOK
        else replace(memory, intent=Intent(SPOT, memory.pose.position))
    )


def _without(memory: Memory, target: Points) -> Memory:
    """The memory with this target (2,) done."""
    return memory.with_leads(done=np.concatenate((memory.stay.leads.done, target[None])))
