"""What one observation adds to the memory, before any decision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.association import Beams
from agents.cogmap.bounded_space import Openings
from agents.cogmap.curiosity import (
    follow_gaps,
    follow_walls,
    not_yet_squarely,
    see_free,
    worth_coming_back,
)
from agents.cogmap.exits import Book, in_doorway, remember_exits, remember_passages
from agents.cogmap.mapper import update
from agents.cogmap.memory import Memory, Stay
from agents.cogmap.mfis import FORGOTTEN, UNTAGGED, Edit
from agents.cogmap.obstacles import remember_obstacles
from agents.cogmap.params import Params
from agents.cogmap.passages import passages
from agents.cogmap.places import seen_from
from agents.cogmap.view import View
from agents.cogmap.wall_openings import wall_openings
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments
from cogmap_gym.observation import LaserSpec


def perceive(
    memory: Memory, view: View, odometry: Pose, laser: LaserSpec, params: Params
) -> tuple[Memory, Sequence[Edit]]:
    """Bring the MFIS, the obstacles and the path up to date with one view.

    Args:
        memory: before the view.
        view: surfaces in the robot's frame.
        odometry: motion since the last view, in the robot's previous frame.
        laser: the laser.
        params: all thresholds.

    Returns:
        The new memory, with the doorways that were gone through unseen, and the edits made to
        the MFIS.
    """
    mapping, edits = update(memory.mapping, view, odometry, params, _allowed(memory, params))
    pose = mapping.mfis_from_robot
    obstacles = remember_obstacles(memory.obstacles, view.points, pose, laser, params.obstacles)
    book = memory.book
    here = np.array([[pose.x, pose.y]])
    path = np.concatenate((memory.stay.path, here))
    if not params.passages.literal:
        gone_through = passages(path, obstacles, params.passages)
        book = remember_passages(book, gone_through, memory.stay.place, params.exits)
    stay = replace(
        memory.stay,
        path=path,
        beams=(*memory.stay.beams, _beams(view, pose))[-params.association.views :],
        views=memory.stay.views + 1,
    )
    return (
        replace(
            memory,
            mapping=mapping,
            obstacles=obstacles,
            book=book,
            stay=stay,
            path=_lengthened(memory.path, pose, params.passages.path_kept),
            travelled=memory.travelled + float(np.hypot(odometry.x, odometry.y)),
        ),
        edits,
    )


def _lengthened(path: Points, pose: Pose, kept: int) -> Points:
    """The last poses (T, 3) of the path, with this one."""
    return np.concatenate((path[1 - kept :], np.array([[pose.x, pose.y, pose.theta]])))


def survey(memory: Memory, view: View, seen: Openings, laser: LaserSpec, params: Params) -> Memory:
    """Note the exits and the gaps of a view, as those of the place the robot is now known to be in.

    In an exit, and until the robot has found itself in a known place, only what is free is noted:
    what is not looked for may not count as looked at either.

    Args:
        memory: after the view was laid into the MFIS, and a crossing noticed.
        view: surfaces in the robot's frame.
        seen: gaps and exits in the robot's frame (Algorithm 2).
        laser: the laser.
        params: all thresholds.
    """
    book, stay, pose = memory.book, memory.stay, memory.pose
    sure = stay.settled or not stay.known
    sure = sure and not in_doorway(book, pose.position, params.exits)
    if sure:
        found = np.concatenate((pose.apply(seen.exits), _opened(memory, view, laser, params)))
        step = memory.mapping.step
        book = remember_exits(book, found, stay.place, pose, step, params.exits)
    leads = see_free(stay.leads, view, pose, laser, params.curiosity)
    stay = replace(stay, leads=leads)
    if sure:
        stay = _curious(stay, view, seen, pose, laser, book, params)
    return replace(memory, book=book, stay=stay)


def _opened(memory: Memory, view: View, laser: LaserSpec, params: Params) -> Segments:
    """Openings of the view in walls of a known place, (E, 2, 2) in the MFIS."""
    if not memory.stay.known or params.gaps.literal:
        return NO_SEGMENTS
    pose, mfis = memory.pose, memory.mapping.mfis
    eye = (pose @ laser.robot_from_laser).position
    ends = pose.apply(view.points[np.isfinite(view.points).all(axis=1)])
    walls = mfis.surfaces[mfis.asr == memory.stay.place]
    return wall_openings(walls, eye, ends, params.gaps)


def _curious(
    stay: Stay,
    view: View,
    seen: Openings,
    pose: Pose,
    laser: LaserSpec,
    book: Book,
    params: Params,
) -> Stay:
    """The stay with what the place still hides brought up to date."""
    p = params.curiosity
    new = pose.apply(seen.gaps)
    if stay.known:
        new = worth_coming_back(new, p)
    leads = follow_gaps(stay.leads, new, pose, book, p)
    leads = follow_walls(leads, view, pose, laser, book, p)
    return replace(stay, leads=leads, search=not_yet_squarely(stay.search, pose, laser, p))


def _allowed(memory: Memory, params: Params) -> NDArray[np.bool_]:
    """Which surfaces may be recognised here: those of this place and its neighbours, and untagged.

    Until the robot has found itself in a place, surfaces of known places would draw it to where it
    is not: there it recognises only what it has just seen (FINDINGS 5).
    """
    asr, stay = memory.mapping.mfis.asr, memory.stay
    if params.association.literal:
        return np.asarray(asr != FORGOTTEN)
    # Departs from Algorithm 5, step 5, which looks everywhere.
    places = {UNTAGGED, stay.came_from}
    if stay.settled:
        places = {UNTAGGED, stay.place} | seen_from(memory.book, stay.place)
    return np.isin(asr, list(places))


def _beams(view: View, pose: Pose) -> Beams:
    points = view.points[np.isfinite(view.points).all(axis=1)]
    ends = pose.apply(points)
    return Beams(np.broadcast_to(pose.position, ends.shape), ends)
