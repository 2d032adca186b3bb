"""Going home and to other marks: exit by exit over the network, then a beacon (thesis 4.2.4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.driving import Action, drive_through, drive_to
from agents.cogmap.exploration import explore
from agents.cogmap.memory import MARK, Intent, Mark, Memory
from agents.cogmap.params import Params
from agents.cogmap.places import route
from agents.cogmap.view import View
from agents.cogmap.wandering import straight
from cogmap_gym.observation import RobotSpec


def travel(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """One step of a journey to a mark.

    Departs from thesis 4.2.4, where home is a beacon from anywhere: straight home works from the
    nearest rooms alone (FINDINGS 5). The exits on the way are the beacons, then the mark.

    Args:
        memory: after perception.
        mark: where to go.
        view: the present view, in the robot's frame.
        robot: limits of a move.
        params: all thresholds.
    """
    at = memory.pose.position
    if params.journeys.literal:
        return _beacon(memory, mark, view, robot, params)
    blocked = frozenset(e.id for e in memory.book if e.failures >= params.exploration.max_failures)
    way = route(memory.book, at, memory.stay.place, mark.point, mark.place, blocked)
    if way is None:
        memory = replace(memory, route=None, status=f"no known way to mark {mark.id}")
        return explore(memory, view, robot, params)
    memory = replace(memory, route=tuple(way), status=f"to mark {mark.id}")
    if not way:
        return _beacon(memory, mark, view, robot, params)
    target = memory.exit(way[0])
    last = memory.intent
    steps = last.steps + 1 if last is not None and last.exit == target.id else 0
    memory = replace(memory, intent=Intent(MARK, target.middle, target.id, steps))
    side = float(target.side_of(memory.stay.place))
    action = drive_through(memory, target, side, robot, params)
    if action is not None and steps <= params.journeys.patience:
        return memory, action
    book = tuple(
        replace(e, failures=e.failures + 1) if e.id == target.id else e for e in memory.book
    )
    return explore(replace(memory, book=book, intent=None), view, robot, params)


def _beacon(
    memory: Memory, mark: Mark, view: View, robot: RobotSpec, params: Params
) -> tuple[Memory, Action]:
    """Straight towards the mark, and declare once there."""
    if float(np.hypot(*(mark.point - memory.pose.position))) < params.journeys.arrival:
        return replace(memory, intent=None, status=f"at mark {mark.id}"), robot.declare()
    memory = replace(memory, intent=Intent(MARK, mark.point))
    if params.journeys.literal:
        return memory, straight(memory, memory.pose.inverse().apply(mark.point), robot, params)
    action = drive_to(memory, mark.point, robot, params)
    if action is None:
        return explore(replace(memory, intent=None), view, robot, params)
    return memory, action
