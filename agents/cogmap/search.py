"""Looking for new exits where the way is shut (thesis 4.4.2; FINDINGS 5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.choices import doubtful_exits
from agents.cogmap.curiosity import before_walls, wall_pieces
from agents.cogmap.driving import Action, drive_before, drive_to, turn
from agents.cogmap.exits import Exit, give_up_exit
from agents.cogmap.exploration import explore
from agents.cogmap.memory import CHECK, EXIT, GAP, LOOK, Intent, Mark, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import Route, exits_of, linked
from agents.cogmap.view import View
from cogmap_gym.geometry import (
    NO_SEGMENTS,
    Points,
    Segments,
    midpoints,
    point_segment_distances,
)
from cogmap_gym.observation import RobotSpec


def search_place(
    memory: Memory, mark: Mark, known: Route | None, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action | None]:
    """One step of looking for new exits in the present place.

    In a place of the network the robot looks round where it noticed the block, then walks by the
    walls in which an exit would be worth having, in short steps; an exit seen once is looked at
    again. A new place it explores, as far as its first exit.

    Args:
        memory: on a journey, something on the way here being shut.
        mark: the goal.
        known: the best way over known links not found shut, if any.
        view: the present view, in the robot's frame.
        robot: limits of a move.
        params: all thresholds.

    Returns:
        The memory and the move; no move, and the place noted as searched, when that is done.
    """
    if memory.stay.searching < 0:
        memory = _begun(memory, mark, known, params)
    memory = memory.with_stay(searching=memory.stay.searching + 1)
    stay = memory.stay
    checking = memory.intent is not None and memory.intent.kind == CHECK
    over = stay.looked and stay.known and not checking and memory.travelled > stay.search_end
    if over or stay.searching > params.curiosity.search_steps:
        return searched(memory), None
    if not stay.known:
        memory, step = explore(memory, view, robot, params)
        onward = memory.intent is not None and memory.intent.kind == EXIT
        return (searched(memory), None) if onward else (memory, step)
    if not stay.looked:
        return look_round(memory, robot, params)
    doubtful = next(iter(doubtful_exits(memory, params)), None)
    if doubtful is not None:
        return _check(memory, doubtful, robot, params)
    while len(memory.stay.search):
        target = _nearest(memory, params)
        memory = replace(memory, intent=Intent(GAP, target))
        action = drive_to(memory, target, robot, params, leaving=False)
        near = float(np.hypot(*(target - memory.pose.position))) < params.exploration.arrival
        if near:
            action = _face(memory, target, robot, params)
        if action is not None:
            return memory, _short(action, robot, params)
        memory = _passed(memory, target, params)
    return searched(memory), None


def unsearched(memory: Memory, mark: Mark, params: Params) -> dict[int, Points]:
    """Places within reach in which a door to the goal may be, not yet searched on this journey.

    Returns:
        By place, the spot (2,) in the MFIS on such a wall that is nearest to the goal.
    """
    journey = memory.journey
    assert journey is not None, "exits are looked for on a journey"
    near = linked(memory.book, memory.stay.place, journey.blocked) - journey.searched
    spots: dict[int, Points] = {}
    for place in sorted(near):
        middle = midpoints(_shared_walls(memory, place, mark, params))
        if len(middle):
            spots[place] = middle[int(np.hypot(*(middle - mark.point).T).argmin())]
    return spots


def _begun(memory: Memory, mark: Mark, known: Route | None, params: Params) -> Memory:
    """The memory with the walls of this place that are worth looking at, and for how long."""
    place, at = memory.stay.place, memory.pose.position
    if known is None:
        walls, worth = _shared_walls(memory, place, mark, params), np.inf
    else:
        walls = _walls(memory, place, params)
        middle = midpoints(walls)
        promise = np.hypot(*(middle - at).T) + np.hypot(*(mark.point - middle).T)
        walls = walls[promise < known.length]
        gain = known.length - float(np.hypot(*(mark.point - at)))
        worth = params.journeys.search_worth * gain
    changed = memory.with_stay(
        search=walls,
        searching=0,
        search_end=memory.travelled + worth,
        looked=memory.stay.looked and not memory.stay.known,
        turned=0.0,
    )
    return replace(changed, intent=None)


def _walls(memory: Memory, place: int, params: Params) -> Segments:
    """The walls of a place but its known exits, in pieces, free space on the left, (P, 2, 2)."""
    asr = memory.network.asr(place)
    if asr is None or not asr.closed:
        return NO_SEGMENTS
    pieces = wall_pieces(_ring(asr.boundary), params.curiosity)
    known = [e.line for e in exits_of(memory.book, place) if e.trusted(params.exits)]
    if not known:
        return pieces
    gaps = point_segment_distances(midpoints(pieces), np.stack(known))
    return np.asarray(pieces[gaps.min(axis=1) > 0.5 * params.curiosity.piece])


def _ring(boundary: Points) -> Segments:
    """The sides of a closed polygon (K, 2), (K, 2, 2)."""
    return np.stack((boundary, np.roll(boundary, -1, axis=0)), axis=1)


def _shared_walls(memory: Memory, place: int, mark: Mark, params: Params) -> Segments:
    """The walls of a place behind which the goal may be entered, (P, 2, 2).

    That is beside the goal's place, or one from which it can be reached.
    """
    journey = memory.journey
    assert journey is not None, "exits are looked for on a journey"
    beyond = linked(memory.book, mark.place, journey.blocked)
    edges = [
        shapely.Polygon(a.boundary) for a in memory.network.asrs if a.id in beyond and a.closed
    ]
    walls = _walls(memory, place, params)
    if not edges or not len(walls):
        return NO_SEGMENTS
    gaps = shapely.distance(shapely.union_all(edges), shapely.points(midpoints(walls)))
    return np.asarray(walls[gaps < params.journeys.shared_wall])


def searched(memory: Memory) -> Memory:
    """The memory with the present place noted as searched on this journey."""
    journey = memory.journey
    assert journey is not None, "exits are looked for on a journey"
    done = replace(journey, searched=journey.searched | {memory.stay.place})
    cleared = memory.with_stay(search=memory.stay.search[:0], searching=-1, looked=True)
    return replace(cleared, journey=done, intent=None)


def look_round(memory: Memory, robot: RobotSpec, params: Params) -> tuple[Memory, Action]:
    """Turn on, until all around was seen."""
    step = min(robot.max_turn, params.exploration.look_turn - memory.stay.turned)
    turned = memory.stay.turned + step
    done = turned >= params.exploration.look_turn - 1e-9
    memory = replace(memory, intent=Intent(LOOK, memory.pose.position))
    return memory.with_stay(turned=0.0 if done else turned, looked=done), turn(step, robot)


def _check(
    memory: Memory, doubtful: Exit, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """Go before a doubtful exit and face it; give it up after some steps."""
    last = memory.intent
    same = last is not None and last.kind == CHECK and last.exit == doubtful.id
    steps = last.steps + 1 if last is not None and same else 0
    memory = replace(memory, intent=Intent(CHECK, doubtful.middle, doubtful.id, steps))
    side = float(doubtful.side_of(memory.stay.place))
    action = drive_before(memory, doubtful, side, robot, params)
    if action is None or steps > params.exploration.patience:
        times, step = params.exploration.max_failures, memory.mapping.step
        memory = replace(memory, book=give_up_exit(memory.book, doubtful.id, step, times))
    return memory, action if action is not None else turn(robot.max_turn, robot)


def _nearest(memory: Memory, params: Params) -> Points:
    """The nearest spot (2,) in the MFIS from which a wall not yet searched is seen."""
    spots = before_walls(memory.stay.search, params.curiosity)
    gaps = np.hypot(*(spots - memory.pose.position).T)
    return np.asarray(spots[int(gaps.argmin())])


def _passed(memory: Memory, target: Points, params: Params) -> Memory:
    """The memory without the walls that this spot (2,) was for."""
    pieces = memory.stay.search
    return memory.with_stay(search=pieces[~_seen_from(pieces, target, params)])


def _face(memory: Memory, target: Points, robot: RobotSpec, params: Params) -> Action | None:
    """The turn towards the walls that this spot (2,) is for; None when the robot faces them."""
    pieces = memory.stay.search
    near = _seen_from(pieces, target, params)
    to = memory.pose.inverse().apply(midpoints(pieces[near]).mean(axis=0)[None])[0]
    bearing = float(np.arctan2(to[1], to[0]))
    return turn(bearing, robot) if abs(bearing) > params.curiosity.facing else None


def _seen_from(pieces: Segments, target: Points, params: Params) -> NDArray[np.bool_]:
    """The pieces of wall (P, 2, 2) that a spot (2,) is for, (P,)."""
    reach = params.curiosity.stand + 0.5 * params.curiosity.piece
    return np.asarray(np.hypot(*(midpoints(pieces) - target).T) <= reach)


def _short(action: Action, robot: RobotSpec, params: Params) -> Action:
    """The same move with a drive no longer than a search allows."""
    longest = np.float32(2.0 * params.curiosity.search_step / robot.max_forward - 1.0)
    out = action.copy()
    out[1] = min(out[1], longest)
    return out
