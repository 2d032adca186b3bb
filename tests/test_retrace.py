"""Back along the robot's own path, where the network knows no way."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from agents.cogmap.exits import Exit
from agents.cogmap.journeys import travel
from agents.cogmap.memory import NEWBORN, TRAIL, Journey, Mark, Memory
from agents.cogmap.params import Params
from agents.cogmap.retrace import retrace, trail
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import RobotSpec

P, ROBOT = Params(), RobotSpec()
MARK = Mark(7, 2, np.array((10.0, 8.0)))
CORNER = np.array(((10.0, 8.0), (10.0, 4.0), (10.0, 0.0), (5.0, 0.0), (0.0, 0.0)))
"""A path from the mark round a corner to the origin, in legs longer than a move."""


def walked(corners: Points, carried: bool = False) -> Memory:
    """At the end of a path (K, 2), in a place from which the network knows no way."""
    legs = [np.linspace(a, b, 9)[:-1] for a, b in pairwise(corners)]
    points = np.concatenate((*legs, corners[-1:]))
    if carried:
        points = np.delete(points, slice(8, 24), axis=0)
    path = np.column_stack((points, np.zeros(len(points))))
    x, y = corners[-1].tolist()
    return replace(
        NEWBORN,
        path=path,
        mapping=replace(NEWBORN.mapping, mfis_from_robot=Pose(x, y, 0.0)),
        marks=(MARK,),
        stay=replace(NEWBORN.stay, place=3, known=True),
        journey=Journey(7, looking=False),
    )


def test_the_robot_goes_back_along_its_path_where_no_way_is_known() -> None:
    memory, action = travel(walked(CORNER), MARK, EMPTY_VIEW, ROBOT, P)
    assert not np.array_equal(action, ROBOT.declare())
    assert memory.status == "back to mark 7"
    assert memory.intent is not None
    assert memory.intent.kind == TRAIL
    assert abs(memory.intent.target[1]) < P.curiosity.cell, "along the path, not straight"
    assert 4.0 < memory.intent.target[0] < P.curiosity.leg + P.curiosity.cell
    again, _ = travel(memory, MARK, EMPTY_VIEW, ROBOT, P)
    assert again.intent is not None
    assert np.array_equal(again.intent.target, memory.intent.target)
    assert again.intent.steps == 1


def test_a_path_through_what_was_found_shut_does_not_lead_back() -> None:
    line = np.array(((4.5, -0.5), (4.5, 0.5)))
    memory = replace(walked(CORNER), book=(Exit(1, line, 3, 2, 2, 1),))
    assert retrace(memory, MARK, ROBOT, P)[1] is not None
    shut = replace(memory, journey=Journey(7, frozenset({1}), looking=False))
    assert retrace(shut, MARK, ROBOT, P)[1] is None


def test_a_spot_that_is_out_of_reach_is_cut_out_and_another_stretch_is_tried() -> None:
    loop = np.concatenate((np.array(((0.0, 0.0), (0.0, 8.0), (10.0, 8.0))), CORNER))
    memory, _ = retrace(walked(loop), MARK, ROBOT, P)
    assert memory.intent is not None
    first = memory.intent.target
    tired = replace(memory, intent=replace(memory.intent, steps=P.journeys.patience))
    memory, action = retrace(tired, MARK, ROBOT, P)
    assert action is not None
    assert memory.journey is not None
    assert memory.intent is not None
    assert memory.journey.cut == (tuple(first.tolist()),)
    assert np.hypot(*(memory.intent.target - first)) > 5.0
    tired = replace(memory, intent=replace(memory.intent, steps=P.journeys.patience))
    assert retrace(tired, MARK, ROBOT, P)[1] is None, "both ways round are cut"


def test_where_the_robot_was_carried_its_path_does_not_hang_together() -> None:
    assert len(trail(walked(CORNER), ROBOT, P)) > len(trail(walked(CORNER, True), ROBOT, P)) > 0
    assert retrace(walked(CORNER, True), MARK, ROBOT, P)[1] is None


def test_at_the_mark_it_is_declared() -> None:
    memory, action = retrace(walked(CORNER[:1].repeat(2, axis=0)), MARK, ROBOT, P)
    assert action is not None
    assert np.array_equal(action, ROBOT.declare())
    assert memory.status == "at mark 7"


def test_no_more_steps_are_spent_than_it_took_to_come() -> None:
    memory = walked(CORNER)
    late = Journey(7, retraced=len(memory.path) + 1, looking=False)
    assert retrace(replace(memory, journey=late), MARK, ROBOT, P)[1] is None
