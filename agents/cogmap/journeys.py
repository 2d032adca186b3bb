"""Going home and to other marks: over the network, round what is shut (thesis 4.2.4, 4.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.driving import Action, doorway_is_clear, drive_through, drive_to
from agents.cogmap.exits import NOWHERE, Exit
from agents.cogmap.exploration import explore
from agents.cogmap.leads import unexplored
from agents.cogmap.memory import MARK, NO_POINTS, Intent, Journey, Mark, Memory, place_of
from agents.cogmap.params import Params
from agents.cogmap.places import Route, exits_of, linked, route
from agents.cogmap.retrace import retrace
from agents.cogmap.search import look_round, search_place, unsearched
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
    mark = replace(mark, place=place_of(memory, mark))
    assert memory.journey is not None, "a journey has begun"
    elsewhere = memory.stay.place != mark.place
    if memory.journey.looking and elsewhere and not memory.stay.looked:
        return look_round(replace(memory, status="looking round"), robot, params)
    memory = replace(memory, journey=replace(memory.journey, looking=False))
    known = _known_way(memory, mark)
    if known is None:
        memory, back = retrace(memory, mark, robot, params)
        if back is not None:
            return replace(memory, route=None), back
        memory = _lost(memory)
    new = _new_exit(memory, mark, known, params)
    if new is not None:
        memory = replace(memory, route=(new.id,), status=f"to mark {mark.id} by a new exit")
        return _by_exit(memory, new, mark, view, robot, params)
    if _should_search(memory, mark, known, params):
        memory = replace(memory, status="looking for a new exit")
        memory, action = search_place(memory, mark, known, view, robot, params)
        return (memory, action) if action is not None else travel(memory, mark, view, robot, params)
    if known is None:
        return _without_a_way(memory, mark, view, robot, params)
    memory = replace(memory, route=known.exits, status=f"to mark {mark.id}")
    if not known.exits:
        memory = _there(memory)
        if memory.journey is not None and memory.journey.there > params.journeys.there_steps:
            memory, back = retrace(memory, mark, robot, params)
            return (memory, back) if back is not None else _no_route(memory, mark, robot)
        return _beacon(memory, mark, view, robot, params)
    return _by_exit(memory, memory.exit(known.exits[0]), mark, view, robot, params)


def _without_a_way(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """What is left to try where no known way leads to the mark; nothing left: say so, and declare.

    Exits never crossed come first, then the walls behind which the goal may be entered, then what
    was left unexplored anywhere, then the exits that could not be reached, though they were not
    seen to be shut.
    """
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    memory = replace(memory, route=None, status=f"no known way to mark {mark.id}")
    onward = None
    if journey.lost <= params.journeys.lost_steps:
        onward = _untried(memory, mark, params) or _towards_search(memory, mark, params)
    if onward is not None:
        return _by_exit(memory, onward, mark, view, robot, params)
    if journey.lost <= params.journeys.lost_steps and unexplored(memory, params):
        return explore(memory, view, robot, params)
    if not journey.retried and (_doubtful_blocks(memory) or journey.cut):
        return travel(_afresh(memory), mark, view, robot, params)
    return _no_route(memory, mark, robot)


def _afresh(memory: Memory) -> Memory:
    """The memory with one more chance for what could not be reached, and with eyes open for it.

    What stands in the way is forgotten and looked at again from one spot: seen from many, it
    smears over doorways not much wider than the robot.
    """
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    again = replace(
        journey,
        blocked=journey.blocked - _doubtful_blocks(memory),
        failed=frozenset(),
        cut=(),
        retried=True,
        looking=True,
    )
    memory = memory.with_stay(looked=False, turned=0.0)
    return replace(memory, obstacles=NO_POINTS, journey=again, intent=None)


def _no_route(memory: Memory, mark: Mark, robot: RobotSpec) -> tuple[Memory, Action]:
    """Say that the mark cannot be reached, and declare."""
    return replace(memory, intent=None, status=f"no route to mark {mark.id}"), robot.declare()


def _lost(memory: Memory) -> Memory:
    """The memory with one more step without a known way; a step counts once."""
    journey, step = memory.journey, memory.mapping.step
    assert journey is not None, "a journey has begun"
    if journey.lost_at == step:
        return memory
    return replace(memory, journey=replace(journey, lost=journey.lost + 1, lost_at=step))


def _there(memory: Memory) -> Memory:
    """The memory with one more step in the goal's place."""
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    return replace(memory, journey=replace(journey, there=journey.there + 1))


def _doubtful_blocks(memory: Memory) -> frozenset[int]:
    """The exits to try once more before giving in.

    Those that could not be reached, though not seen to be shut; all, where the robot believes to
    be shut in itself: what is shut is more likely the goal.
    """
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    near = linked(memory.book, memory.stay.place, journey.blocked)
    whole = linked(memory.book, memory.stay.place, frozenset())
    return journey.blocked if 2 * len(near) < len(whole) else journey.failed


def _untried(memory: Memory, mark: Mark, params: Params) -> Exit | None:
    """The next exit on the shortest promise by an exit never crossed, here or elsewhere."""
    journey, here, at = memory.journey, memory.stay.place, memory.pose.position
    assert journey is not None, "a journey has begun"
    best, least = None, np.inf
    for e in memory.book:
        if e.crossed >= 0 or e.id in journey.blocked or not e.trusted(params.exits):
            continue
        for place in {e.left, e.right} - {NOWHERE}:
            way = route(memory.book, at, here, e.middle, place, journey.blocked)
            if way is None:
                continue
            promise = way.length + float(np.hypot(*(mark.point - e.middle)))
            if promise < least:
                best, least = (way.exits[0] if way.exits else e.id), promise
    return None if best is None else memory.exit(best)


def _towards_search(memory: Memory, mark: Mark, params: Params) -> Exit | None:
    """The first exit on the shortest promise by a place in which a door to the goal may be."""
    journey, here, at = memory.journey, memory.stay.place, memory.pose.position
    assert journey is not None, "a journey has begun"
    best, least = None, np.inf
    for place, spot in unsearched(memory, mark, params).items():
        way = route(memory.book, at, here, spot, place, journey.blocked)
        if way is None or not way.exits:
            continue
        promise = way.length + float(np.hypot(*(mark.point - spot)))
        if promise < least:
            best, least = way.exits[0], promise
    return None if best is None else memory.exit(best)


def _on_the_way(memory: Memory, mark: Mark, params: Params) -> Memory:
    """The memory with this journey begun, and with what is seen to be shut noted."""
    journey = memory.journey
    if journey is None or journey.mark != mark.id:
        journey = Journey(mark.id)
        memory = replace(memory.with_stay(looked=False, turned=0.0), intent=None)
    shut = {
        e.id
        for e in exits_of(memory.book, memory.stay.place)
        if memory.stay.settled
        and e.trusted(params.exits)
        and not doorway_is_clear(memory, e, params)
    }
    blocked, failed = journey.blocked | shut, journey.failed - shut
    return replace(memory, journey=replace(journey, blocked=blocked, failed=failed))


def _should_search(memory: Memory, mark: Mark, known: Route | None, params: Params) -> bool:
    """Whether to look for new exits here.

    So it is where the way is shut, in a new place on a detour, and where no way is known and a
    door to the goal may be here.
    """
    journey, stay = memory.journey, memory.stay
    assert journey is not None, "a journey has begun"
    if stay.place in journey.searched or stay.place == mark.place:
        return False
    if known is None and journey.lost > params.journeys.lost_steps:
        return False
    if known is None and stay.known:
        return stay.place in unsearched(memory, mark, params)
    here = {e.id for e in exits_of(memory.book, stay.place)}
    return bool(journey.blocked) and (not stay.known or bool(here & journey.blocked))


def _known_way(memory: Memory, mark: Mark) -> Route | None:
    """The shortest way over links not found shut."""
    journey = memory.journey
    assert journey is not None, "a journey has begun"
    at = memory.pose.position
    return route(memory.book, at, memory.stay.place, mark.point, mark.place, journey.blocked)


def _new_exit(memory: Memory, mark: Mark, known: Route | None, params: Params) -> Exit | None:
    """A new exit that promises a shorter way than the known one.

    It must promise much where nothing was found shut yet.

    "The robot weighs its options by measuring the possible distances to the goal with either
    move" (thesis 4.4.2).
    """
    journey, at = memory.journey, memory.pose.position
    assert journey is not None, "a journey has begun"
    if memory.stay.place == mark.place or not (memory.stay.known or memory.stay.looked):
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
    share = 1.0 if journey.blocked else params.journeys.much_shorter
    return best if known is None or promise(best) < share * known.length else None


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
    out = replace(
        journey, blocked=journey.blocked | {target.id}, failed=journey.failed | {target.id}
    )
    return travel(replace(memory, journey=out, intent=None), mark, view, robot, params)


def _beacon(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """Straight towards the mark, and declare once there."""
    if float(np.hypot(*(mark.point - memory.pose.position))) < params.journeys.arrival:
        return replace(memory, intent=None, status=f"at mark {mark.id}"), robot.declare()
    last = memory.intent
    same = last is not None and last.kind == MARK and last.exit == NOWHERE
    steps = last.steps + 1 if last is not None and same else 0
    memory = replace(memory, intent=Intent(MARK, mark.point, NOWHERE, steps))
    if params.journeys.literal:
        return memory, straight(memory, memory.pose.inverse().apply(mark.point), robot, params)
    action = drive_to(memory, mark.point, robot, params)
    if action is not None and steps <= params.journeys.patience:
        return memory, action
    if float(np.hypot(*(mark.point - memory.pose.position))) < params.journeys.near_enough:
        return replace(memory, intent=None, status=f"near mark {mark.id}"), robot.declare()
    return explore(replace(memory, intent=None), view, robot, params)
