"""Algorithm 1: autonomous exploration, place by place (thesis 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.choices import choose, new_exit
from agents.cogmap.curiosity import lead_points
from agents.cogmap.driving import (
    Action,
    doorway_is_clear,
    drive_before,
    drive_through,
    drive_to,
    turn,
)
from agents.cogmap.exits import give_up_exit, try_again
from agents.cogmap.false_exits import doubt_exit
from agents.cogmap.memory import CHECK, EXIT, GAP, LOOK, SPOT, Intent, Memory
from agents.cogmap.params import Params
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
    if intent.kind == GAP and new_exit(memory, params) is not None:
        return None
    return intent


def _about(points: Points, target: Points, params: Params) -> NDArray[np.bool_]:
    """Which points (P, 2) mean the same target (2,), (P,)."""
    return np.asarray(np.hypot(*(points - target).T) < params.exploration.same_target)


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
