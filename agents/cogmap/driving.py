"""From a target in the MFIS to the next move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.exits import Exit
from agents.cogmap.free_space import spot_on_the_way
from agents.cogmap.memory import Memory
from agents.cogmap.navigator import plan_path, sample_surfaces, steer
from agents.cogmap.params import Params
from agents.cogmap.places import exits_of
from cogmap_gym.geometry import Points, point_segment_distances
from cogmap_gym.observation import RobotSpec

Action = NDArray[np.float32]


def drive_to(
    memory: Memory, target: Points, robot: RobotSpec, params: Params, *, leaving: bool = True
) -> Action | None:
    """The next move towards a point (2,) in the MFIS, or None without a way.

    Args:
        memory: where the robot is.
        target: the point.
        robot: limits of a move.
        params: distances.
        leaving: whether the way may lead through an exit where there is no other.
    """
    path = _way(memory, target, (), robot, params, leaving=leaving)
    return None if path is None else _move(memory, path, robot, params)


def drive_through(
    memory: Memory, target: Exit, side: float, robot: RobotSpec, params: Params
) -> Action | None:
    """The next move through an exit: line up before it, then straight through its middle.

    Args:
        memory: where the robot is.
        target: the exit.
        side: 1 if the robot's place lies on the exit's left, else -1.
        robot: limits of a move.
        params: distances.
    """
    p, at = params.exploration, memory.pose.position
    before = target.middle + side * p.standoff * target.normal
    beyond = target.middle - side * p.through * target.normal
    offset = float((at - target.middle) @ target.normal) * side
    aside = abs(float((at - target.middle) @ np.array((target.normal[1], -target.normal[0]))))
    if offset < p.standoff + p.arrival and aside < 0.5 * p.arrival + max(offset, 0.0) * 0.5:
        path = _way(memory, beyond, (target.id,), robot, params)
    else:
        path = _way(memory, before, (), robot, params)
        if path is not None and np.array_equal(path[-1], before):
            path = np.concatenate((path, beyond[None]))
    return None if path is None else _move(memory, path, robot, params)


def _way(
    memory: Memory,
    target: Points,
    through: tuple[int, ...],
    robot: RobotSpec,
    params: Params,
    *,
    leaving: bool = True,
) -> Points | None:
    """A way (K, 2) in the MFIS to a point (2,) of the present place, or to a spot on the way.

    It leads through no exit but those of ``through``, unless there is no other way and it may
    leave. Where the point is beyond what a local plan can reach, the way goes over what was seen
    to be free.
    """
    at, nav = memory.pose.position, params.navigation
    shut = np.concatenate((memory.obstacles, _shut_doors(memory, through, params)))
    path = plan_path(shut, at, target, nav, robot)
    if path is None:
        spot = spot_on_the_way(memory.stay.leads.seen, at, target, params.curiosity)
        path = None if spot is None else plan_path(shut, at, spot, nav, robot)
    if path is None and leaving:
        return plan_path(memory.obstacles, at, target, nav, robot)
    return path


def _shut_doors(memory: Memory, through: tuple[int, ...], params: Params) -> Points:
    """Points (P, 2) on the exits of this place that the way shall not lead through."""
    at = memory.pose.position
    lines = [
        e.line
        for e in exits_of(memory.book, memory.stay.place)
        if e.id not in through
        and e.trusted(params.exits)
        and float(np.hypot(*(e.middle - at))) > params.exploration.standoff
    ]
    return sample_surfaces(np.array(lines).reshape(-1, 2, 2), params.navigation.cell)


def doorway_is_clear(memory: Memory, target: Exit, params: Params) -> bool:
    """Whether nothing seen stands in the middle of an exit; True from too far away to tell.

    What this view or the last shows as an exit is open.
    """
    p = params.journeys
    if target.seen >= memory.mapping.step - 1:
        return True
    if float(np.hypot(*(target.middle - memory.pose.position))) > p.near_exit:
        return True
    reach = p.doorway_depth * target.normal
    line = np.stack((target.middle - reach, target.middle + reach))[None]
    gaps = point_segment_distances(memory.obstacles, line)
    return bool(gaps.min(initial=np.inf) > p.doorway_free)


def drive_before(
    memory: Memory, target: Exit, side: float, robot: RobotSpec, params: Params
) -> Action | None:
    """The next move to stand squarely before an exit and face it; None without a way.

    Args:
        memory: where the robot is.
        target: the exit.
        side: 1 if the robot's place lies on the exit's left, else -1.
        robot: limits of a move.
        params: distances.
    """
    before = target.middle + side * params.exploration.lookout * target.normal
    if float(np.hypot(*(before - memory.pose.position))) > params.exploration.arrival:
        return drive_to(memory, before, robot, params)
    ahead = memory.pose.inverse().apply(target.middle)
    return turn(float(np.arctan2(ahead[1], ahead[0])), robot)


def turn(angle: float, robot: RobotSpec) -> Action:
    """Turn on the spot by at most one move's turn [rad]."""
    return robot.move(float(np.clip(angle, -robot.max_turn, robot.max_turn)), 0.0)


def _move(memory: Memory, path: Points, robot: RobotSpec, params: Params) -> Action:
    robot_from_mfis = memory.pose.inverse()
    angle, forward = steer(
        robot_from_mfis.apply(path),
        robot_from_mfis.apply(memory.obstacles),
        params.navigation,
        robot,
    )
    return robot.move(angle, forward)
