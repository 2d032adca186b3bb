"""Looking for new exits where the way is shut (thesis 4.4.2; FINDINGS 5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.curiosity import wall_pieces
from agents.cogmap.driving import Action, drive_before, drive_to, turn
from agents.cogmap.exits import Exit
from agents.cogmap.memory import CHECK, GAP, LOOK, Intent, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import exits_of
from cogmap_gym.geometry import Points
from cogmap_gym.observation import RobotSpec


def search_place(memory: Memory, robot: RobotSpec, params: Params) -> tuple[Memory, Action | None]:
    """One step of looking for new exits in the present place.

    The robot looks round where it noticed the block, then walks by every wall of the place that it
    has not seen squarely since, in short steps; an exit seen once is looked at again.

    Args:
        memory: on a journey, something on the way here being shut.
        robot: limits of a move.
        params: all thresholds.

    Returns:
        The memory and the move; no move, and the place noted as searched, when that is done.
    """
    if memory.stay.searching < 0:
        memory = _begun(memory, params)
    memory = memory.with_stay(searching=memory.stay.searching + 1)
    stay = memory.stay
    if stay.searching > params.curiosity.search_steps:
        return searched(memory), None
    if not stay.looked:
        return _look(memory, robot, params)
    doubtful = _doubtful(memory, params)
    if doubtful is not None:
        return _check(memory, doubtful, robot, params)
    while len(memory.stay.search):
        target = _nearest(memory, params)
        memory = replace(memory, intent=Intent(GAP, target))
        action = drive_to(memory, target, robot, params)
        near = float(np.hypot(*(target - memory.pose.position))) < params.exploration.arrival
        if action is not None and not near:
            return memory, _short(action, robot, params)
        memory = _passed(memory, target, params)
    return searched(memory), None


def _begun(memory: Memory, params: Params) -> Memory:
    mfis = memory.mapping.mfis
    walls = wall_pieces(mfis.surfaces[mfis.asr == memory.stay.place], params.curiosity)
    return replace(
        memory.with_stay(search=walls, searching=0, looked=False, turned=0.0), intent=None
    )


def searched(memory: Memory) -> Memory:
    """The memory with the present place noted as searched on this journey."""
    journey = memory.journey
    assert journey is not None, "exits are looked for on a journey"
    done = replace(journey, searched=journey.searched | {memory.stay.place})
    cleared = memory.with_stay(search=memory.stay.search[:0], searching=-1, looked=True)
    return replace(cleared, journey=done, intent=None)


def _look(memory: Memory, robot: RobotSpec, params: Params) -> tuple[Memory, Action]:
    """Turn on, until all around was seen."""
    step = min(robot.max_turn, params.exploration.look_turn - memory.stay.turned)
    turned = memory.stay.turned + step
    done = turned >= params.exploration.look_turn - 1e-9
    memory = replace(memory, intent=Intent(LOOK, memory.pose.position))
    return memory.with_stay(turned=0.0 if done else turned, looked=done), turn(step, robot)


def _doubtful(memory: Memory, params: Params) -> Exit | None:
    """An exit seen too seldom to count, not yet given up."""
    return next(
        (
            e
            for e in exits_of(memory.book, memory.stay.place)
            if not e.trusted(params.exits)
            and not e.false
            and e.failures < params.exploration.max_failures
        ),
        None,
    )


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
        book = tuple(
            replace(e, failures=params.exploration.max_failures) if e.id == doubtful.id else e
            for e in memory.book
        )
        memory = replace(memory, book=book)
    return memory, action if action is not None else turn(robot.max_turn, robot)


def _nearest(memory: Memory, params: Params) -> Points:
    """The nearest spot (2,) in the MFIS from which a wall not yet searched is seen."""
    pieces = memory.stay.search
    d = pieces[:, 1] - pieces[:, 0]
    left = np.stack((-d[:, 1], d[:, 0]), axis=-1) / np.hypot(d[:, 0], d[:, 1])[:, None]
    spots = pieces.mean(axis=1) + params.curiosity.stand * left
    gaps = np.hypot(*(spots - memory.pose.position).T)
    return np.asarray(spots[int(gaps.argmin())])


def _passed(memory: Memory, target: Points, params: Params) -> Memory:
    """The memory without the walls that this spot (2,) was for."""
    pieces = memory.stay.search
    far = np.hypot(*(pieces.mean(axis=1) - target).T) > params.curiosity.stand + 0.5 * (
        params.curiosity.piece
    )
    return memory.with_stay(search=pieces[far])


def _short(action: Action, robot: RobotSpec, params: Params) -> Action:
    """The same move with a drive no longer than a search allows."""
    longest = np.float32(2.0 * params.curiosity.search_step / robot.max_forward - 1.0)
    out = action.copy()
    out[1] = min(out[1], longest)
    return out
