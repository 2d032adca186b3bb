"""What one observation adds to the memory, before any decision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.association import Beams
from agents.cogmap.bounded_space import Openings
from agents.cogmap.exits import remember_exits
from agents.cogmap.mapper import update
from agents.cogmap.memory import NEWBORN, Memory
from agents.cogmap.mfis import FORGOTTEN, UNTAGGED, Edit
from agents.cogmap.obstacles import remember_obstacles
from agents.cogmap.params import Params
from agents.cogmap.places import links
from agents.cogmap.view import View
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import LaserSpec


def perceive(
    memory: Memory,
    view: View,
    seen: Openings,
    odometry: Pose,
    laser: LaserSpec,
    params: Params,
) -> tuple[Memory, Sequence[Edit]]:
    """Bring the MFIS, the obstacles and the exits up to date with one view.

    Args:
        memory: before the view.
        view: surfaces in the robot's frame.
        seen: gaps and exits in the robot's frame (Algorithm 2).
        odometry: motion since the last view, in the robot's previous frame.
        laser: the laser.
        params: all thresholds.

    Returns:
        The new memory, and the edits made to the MFIS.
    """
    mapping, edits = update(memory.mapping, view, odometry, params, _allowed(memory))
    pose = mapping.mfis_from_robot
    obstacles = remember_obstacles(memory.obstacles, view.points, pose, laser, params.obstacles)
    book = remember_exits(
        memory.book, pose.apply(seen.exits), memory.stay.place, pose, params.exits
    )
    here = np.array([[pose.x, pose.y]])
    stay = replace(
        memory.stay,
        path=np.concatenate((memory.stay.path, here)),
        beams=(*memory.stay.beams, _beams(view, pose))[-params.association.views :],
        views=memory.stay.views + 1,
        gaps=_open_gaps(memory.stay.gaps, seen, view, pose, laser, params),
    )
    return (
        replace(
            memory,
            mapping=mapping,
            obstacles=obstacles,
            book=book,
            stay=stay,
            path=np.concatenate((memory.path, np.array([[pose.x, pose.y, pose.theta]]))),
            travelled=memory.travelled + float(np.hypot(odometry.x, odometry.y)),
        ),
        edits,
    )


def _allowed(memory: Memory) -> NDArray[np.bool_]:
    """Which surfaces may be recognised here: those of this place and its neighbours, and untagged.

    In a place the robot does not know, surfaces of other known places would draw it to where it is
    not: there it recognises only what it has just seen (FINDINGS 5).
    """
    asr, here = memory.mapping.mfis.asr, memory.stay.place
    places = {UNTAGGED, here, memory.stay.came_from} - {FORGOTTEN}
    if memory.stay.known:
        places |= {b if a == here else a for a, _, b in links(memory.book) if here in (a, b)}
    return np.isin(asr, list(places | {UNTAGGED}))


def _beams(view: View, pose: Pose) -> Beams:
    points = view.points[np.isfinite(view.points).all(axis=1)]
    ends = pose.apply(points)
    return Beams(np.broadcast_to(pose.position, ends.shape), ends)


def _open_gaps(
    gaps: Points, seen: Openings, view: View, pose: Pose, laser: LaserSpec, params: Params
) -> Points:
    """Middles of gaps (G, 2) in the MFIS that wait to be explored: not near, not yet in the open."""
    new = pose.apply(seen.gaps.mean(axis=1))
    together = np.concatenate((gaps, new))
    if not len(together):
        return together
    p = params.exploration
    in_robot = pose.inverse().apply(together)
    distance = np.hypot(in_robot[:, 0], in_robot[:, 1])
    bearing = np.arctan2(in_robot[:, 1], in_robot[:, 0])
    ranges = np.hypot(view.points[:, 0], view.points[:, 1])
    waits = distance > p.visited
    for k in np.flatnonzero(waits[: len(gaps)]):
        half = max(p.open_radius / distance[k], laser.step)
        first = (bearing[k] - half - laser.first_angle) / laser.step
        last = (bearing[k] + half - laser.first_angle) / laser.step
        if first < 0 or last >= len(ranges):
            continue
        beams = ranges[int(first) : int(last) + 1]
        waits[k] = not bool((beams > distance[k] + p.open_radius).all())
    kept: list[int] = []
    for k in np.flatnonzero(waits):
        apart = np.hypot(*(together[kept] - together[k]).T)
        if not (apart < p.visited).any():
            kept.append(int(k))
    return together[kept]
