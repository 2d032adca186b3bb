"""Back along the robot's own path, where its network knows no way. Ours: the thesis has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from agents.cogmap.driving import Action, drive_to
from agents.cogmap.free_space import Cells, cells_of, middles_of, spot_on_the_way
from agents.cogmap.memory import NO_CELLS, TRAIL, Intent, Mark, Memory
from agents.cogmap.params import Params
from cogmap_gym.geometry import point_segment_distances
from cogmap_gym.observation import RobotSpec


def retrace(
    memory: Memory, mark: Mark, robot: RobotSpec, params: Params
) -> tuple[Memory, Action | None]:
    """One step back along the remembered path, as far as nothing on it was found shut.

    What the robot went through leads back, even where the network has lost a place or a link of
    it. A spot that cannot be reached is cut out of the path for the rest of the journey, so that
    another stretch of it is tried, or none.

    Args:
        memory: on a journey.
        mark: the goal; the robot was there once.
        robot: limits of a move.
        params: all thresholds.

    Returns:
        The memory and the move; no move where the path does not lead to the mark.
    """
    p, journey, at = params.journeys, memory.journey, memory.pose.position
    assert journey is not None, "a journey has begun"
    if journey.retraced > len(memory.path):
        return memory, None
    if float(np.hypot(*(mark.point - at))) < p.arrival:
        return replace(memory, intent=None, status=f"at mark {mark.id}"), robot.declare()
    last = memory.intent
    steps = last.steps + 1 if last is not None and last.kind == TRAIL else 0
    if last is None or last.kind != TRAIL or float(np.hypot(*(last.target - at))) < p.arrival:
        spot = spot_on_the_way(trail(memory, robot, params), at, mark.point, params.curiosity)
        if spot is None:
            return memory, None
        last, steps = Intent(TRAIL, spot), 0
    memory = replace(memory, intent=Intent(TRAIL, last.target, steps=steps))
    action = drive_to(memory, last.target, robot, params)
    if action is not None and steps <= p.patience:
        onward = replace(journey, retraced=journey.retraced + 1)
        return replace(memory, journey=onward, status=f"back to mark {mark.id}"), action
    x, y = last.target.tolist()
    cut = replace(journey, cut=(*journey.cut, (x, y)))
    return retrace(replace(memory, journey=cut, intent=None), mark, robot, params)


def trail(memory: Memory, robot: RobotSpec, params: Params) -> Cells:
    """The cells of the MFIS that the robot's path runs through, without what was found shut.

    Args:
        memory: on a journey.
        robot: two poses farther apart than it moves are not joined: it was carried.
        params: sizes.
    """
    journey, path = memory.journey, memory.path[:, :2]
    assert journey is not None, "a journey has begun"
    step = np.diff(path, axis=0)
    joined = np.hypot(*step.T) < robot.max_forward + params.journeys.trail_jump
    if not joined.any():
        return NO_CELLS
    # Three samples a cell, and no cell on the way is left out.
    share = np.arange(0.0, 1.0, params.curiosity.cell / (3.0 * robot.max_forward))
    points = (path[:-1][joined, None] + share[:, None] * step[joined, None]).reshape(-1, 2)
    cells = np.unique(cells_of(points, params.curiosity))
    lines = [memory.exit(e).line for e in sorted(journey.blocked - journey.failed)]
    lines += [np.array((spot, spot)) for spot in journey.cut]
    if not lines:
        return cells
    gaps = point_segment_distances(middles_of(cells, params.curiosity), np.stack(lines)).min(axis=1)
    return np.asarray(cells[gaps > params.journeys.trail_cut])
