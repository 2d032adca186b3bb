"""Going home and to other marks: over the network, round what is shut (thesis 4.2.4, 4.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.driving import Action, doorway_is_clear, drive_through, drive_to
from agents.cogmap.exits import NOWHERE, Exit
from agents.cogmap.exploration import explore
from agents.cogmap.memory import EXIT, MARK, Intent, Journey, Mark, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import Route, exits_of, route
from agents.cogmap.search import search_place, searched
from agents.cogmap.view import View
from agents.cogmap.wandering import straight
from cogmap_gym.observation import RobotSpec


def travel(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """One step of a journey to a mark.

    Departs from thesis 4.2.4, where home is a beacon from anywhere: straight home works from the
    nearest rooms alone (FINDINGS 5). The exits on the way are the beacons, as in 4.4.2, then the
    mark. Where the way is shut the robot looks round, and weighs each new exit against going
    back by the distance to the goal (4.4.2, 4.4.3).

    Args:
        memory: after perception.
        mark: where to go.
        view: the present view, in the robot's frame.
        robot: limits of a move.
        params: all thresholds.
    """
    if params.journeys.literal:
        return _beacon(memory, mark, view, robot, params)
    memory = _on_the_way(memory, mark, params)
    assert memory.journey is not None, "a journey has begun"
    known = _known_way(memory, mark)
    new = _new_exit(memory, mark, known, params)
    if new is not None:
        memory = replace(memory, route=(new.id,), status=f"to mark {mark.id} by a new exit")
        return _by_exit(memory, new, mark, view, robot, params)
    if _should_search(memory, mark):
        memory = replace(memory, status="looking for a new exit")
        memory, action = _search(memory, view, robot, params)
        return (memory, action) if action is not None else travel(memory, mark, view, robot, params)
    if known is None:
        memory = replace(memory, route=None, status=f"no known way to mark {mark.id}")
        return explore(memory, view, robot, params)
    memory = replace(memory, route=known.exits, status=f"to mark {mark.id}")
    if not known.exits:
        return _beacon(memory, mark, view, robot, params)
    return _by_exit(memory, memory.exit(known.exits[0]), mark, view, robot, params)


def _on_the_way(memory: Memory, mark: Mark, params: Params) -> Memory:
    """The memory with this journey begun, and with what is seen to be shut noted."""
    journey = memory.journey
    if journey is None or journey.mark != mark.id:
        journey = Journey(mark.id)
        memory = replace(memory, intent=None)
    shut = {
        e.id
        for e in exits_of(memory.book, memory.stay.place)
        if memory.stay.settled
        and e.trusted(params.exits)
        and not doorway_is_clear(memory, e, params)
    }
    return replace(memory, journey=replace(journey, blocked=journey.blocked | shut))


def _should_search(memory: Memory, mark: Mark) -> bool:
    """Whether to look for new exits here: the way is shut here, or the place is new on a detour."""
    journey, stay = memory.journey, memory.stay
    assert journey is not None, "a journey has begun"
    if not journey.blocked or stay.place in journey.searched or stay.place == mark.place:
        return False
    here = {e.id for e in exits_of(memory.book, stay.place)}
    return not stay.known or bool(here & journey.blocked)


def _search(
    memory: Memory, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action | None]:
    """Look for new exits: wall by wall in a known place, by exploring a new one."""
    if memory.stay.known:
        return search_place(memory, robot, params)
    memory, action = explore(memory, view, robot, params)
    intent = memory.intent
    if intent is not None and intent.kind == EXIT and intent.exit == memory.stay.entry:
        return searched(memory), None
    return memory, action


def _known_way(memory: Memory, mark: Mark) -> Route | None:
    """The shortest way over links not found shut."""
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    at = memory.pose.position
    return route(memory.book, at, memory.stay.place, mark.point, mark.place, journey.blocked)


def _new_exit(memory: Memory, mark: Mark, known: Route | None, params: Params) -> Exit | None:
    """A new exit that promises a shorter way than the known one, once the best way is shut.

    "The robot weighs its options by measuring the possible distances to the goal with either
    move" (thesis 4.4.2).
    """
    journey, at = memory.journey, memory.pose.position
    assert journey is not None, "a journey has begun"
    if not journey.blocked or memory.stay.place == mark.place:
        return None
    options = [
        e
        for e in exits_of(memory.book, memory.stay.place)
        if e.trusted(params.exits) and e.crossed < 0 and e.id not in journey.blocked
    ]
    if not options:
        return None

    def promise(e: Exit) -> float:
        return float(np.hypot(*(e.middle - at)) + np.hypot(*(mark.point - e.middle)))

    best = min(options, key=promise)
    return best if known is None or promise(best) < known.length else None


def _by_exit(
    memory: Memory, target: Exit, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """Towards the next exit; where it cannot be reached, it is out of this journey."""
    last = memory.intent
    same = last is not None and last.kind == MARK and last.exit == target.id
    steps = last.steps + 1 if last is not None and same else 0
    memory = replace(memory, intent=Intent(MARK, target.middle, target.id, steps))
    side = float(target.side_of(memory.stay.place))
    action = drive_through(memory, target, side, robot, params)
    if action is not None and steps <= params.journeys.patience:
        return memory, action
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    blocked = replace(journey, blocked=journey.blocked | {target.id})
    return travel(replace(memory, journey=blocked, intent=None), mark, view, robot, params)


def _beacon(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """Straight towards the mark, and declare once there."""
    if float(np.hypot(*(mark.point - memory.pose.position))) < params.journeys.arrival:
        return replace(memory, intent=None, status=f"at mark {mark.id}"), robot.declare()
    memory = replace(memory, intent=Intent(MARK, mark.point, NOWHERE))
    if params.journeys.literal:
        return memory, straight(memory, memory.pose.inverse().apply(mark.point), robot, params)
    action = drive_to(memory, mark.point, robot, params)
    if action is None:
        return explore(replace(memory, intent=None), view, robot, params)
    return memory, action
