"""Doorways of a view: openings in line with a wall that separate two spaces.

Ours, in place of the width alone that makes an exit in thesis 3.3: a gap of 0.6 to 1.2 m
between furniture and a wall is no exit. Along the line of each wall the beams say where
it stops them and where they pass; a doorway is a stretch where they pass, held between
two jambs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Gaps
from agents.cogmap.view import View
from agents.cogmap.wall_line import ON, Ints, WallLine, wall_line
from cogmap_gym.geometry import NO_SEGMENTS, Array, Points, Segments, cross, lengths, midpoints

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Jambs:
    """An opening on a wall's line: between ``near`` and ``far`` [m], held by wall ``other``."""

    near: float
    far: float
    other: int
    in_line: bool
    run: Ints
    """The beams that pass."""


def doorways(view: View, params: Gaps, origin: Points) -> Segments:
    """Find the doorways of a view.

    Args:
        view: in the robot's frame.
        params: widths and tests.
        origin: (2,), where the laser sits in that frame.

    Returns:
        (E, 2, 2), each across its passage in the middle of the wall, from the jamb seen at
        the right to the jamb seen at the left, in the order of the walls that hold them.
    """
    length = lengths(view.surfaces)
    found: list[Segments] = []
    weight: list[float] = []
    for wall in np.flatnonzero(length >= params.wall_length):
        for step in (1, -1):
            line = wall_line(view, int(wall), step, params, origin)
            jambs = _jambs(line, view, params)
            if jambs is not None and _is_doorway(line, jambs, view, params):
                found.append(_across(line, jambs, params))
                weight.append(float(length[wall]))
    if not found:
        return NO_SEGMENTS
    return _without_doubles(np.stack(found), np.array(weight), params)


def _jambs(line: WallLine, view: View, params: Gaps) -> _Jambs | None:
    """The opening that begins where this wall ends, if a jamb closes it at a door's width."""
    beams, begin, stop = line.passing_beams(view, line.wall)
    if begin == stop or stop == len(beams):
        return None
    span = float(lengths(view.surfaces[line.wall][None])[0])
    last_on = float(line.along[beams[begin - 1]]) if begin else span
    near = (max(last_on, span) + line.crossing[beams[begin]]) / 2
    if near - last_on > params.jamb_distance or near - span > params.edge_slip:
        return None
    run = beams[begin:stop]
    far_crossing = float(line.crossing[run[-1]])
    held = _closing_wall(line, view, int(beams[stop]), far_crossing, params)
    if held is None:
        return None
    far, other, in_line = held
    if not params.min_width <= far - near <= params.max_exit_width:
        return None
    return _Jambs(float(near), far, other, in_line, run)


def _closing_wall(
    line: WallLine, view: View, beam: int, crossing: float, params: Gaps
) -> tuple[float, int, bool] | None:
    """The wall that ends the opening: where on the line, which one, and whether in line."""
    rows = view.surfaces if line.step == 1 else view.surfaces[:, ::-1]
    along = (rows - line.origin) @ line.direction
    height = cross(line.direction, rows - line.origin) * line.step
    span = lengths(rows)
    edge = float(line.along[beam])
    if line.code[beam] == ON and abs(edge - crossing) <= params.edge_slip:
        in_line = _longest(_goes_on(along, height, span, crossing, params), span)
        if in_line is not None:
            return (edge + crossing) / 2, in_line, True
    foot = _foot(along, height)
    square = _longest(_stands_at(along, height, span, foot, crossing, params), span)
    return None if square is None else (float(foot[square]), square, False)


def _goes_on(along: Array, height: Array, span: Array, crossing: float, params: Gaps) -> Flags:
    """Surfaces (N,) that begin at the far jamb, on the line, and go on along it."""
    off = params.line_distance + params.line_spread * np.maximum(along[:, 0], 0.0)
    return np.asarray(
        (np.abs(height[:, 1] - height[:, 0]) <= params.line_turn * span)
        & (along[:, 1] > along[:, 0])
        & (np.abs(height).min(axis=1) <= off)
        & (np.abs(along[:, 0] - crossing) <= params.edge_slip)
    )


def _stands_at(
    along: Array, height: Array, span: Array, foot: Array, crossing: float, params: Gaps
) -> Flags:
    """Surfaces (N,) square to the line that reach it from the robot's side, at the far jamb."""
    return np.asarray(
        (np.abs(along[:, 1] - along[:, 0]) <= params.square_turn * span)
        & (height.max(axis=1) > params.edge_slip)
        & (height.min(axis=1) <= params.edge_slip)
        & (np.abs(foot - crossing) <= params.jamb_distance)
    )


def _foot(along: Array, height: Array) -> Array:
    """Where each surface's own line meets the wall's line, NaN if parallel."""
    rise = height[:, 1] - height[:, 0]
    share = -height[:, 0] / np.where(rise == 0.0, np.nan, rise)
    return np.asarray(along[:, 0] + share * (along[:, 1] - along[:, 0]))


def _longest(which: Flags, span: Array) -> int | None:
    rows = np.flatnonzero(which)
    return int(rows[span[rows].argmax()]) if len(rows) else None


def _is_doorway(line: WallLine, jambs: _Jambs, view: View, params: Gaps) -> bool:
    """Whether the opening is free, leads on, and is held by walls rather than furniture."""
    near, far, run = jambs.near, jambs.far, jambs.run
    sight = math.hypot((near + far) / 2 - line.robot_along, line.robot_height)
    if line.robot_height < params.min_sight_sine * sight:
        return False
    depth, hit = -line.height[run], line.along[run]
    deep = depth >= params.beyond
    at_jamb = np.minimum(np.abs(hit - near), np.abs(hit - far)) <= params.jamb_distance
    if np.count_nonzero(~deep & ~at_jamb) > params.blocked_share * len(run):
        return False
    if not deep.any() or np.ptp(line.crossing[run][deep]) < params.clear_share * (far - near):
        return False
    if np.mean(depth[deep] >= params.room_beyond) < params.room_share:
        return False
    return _held_by_walls(line, jambs, view, params)


def _held_by_walls(line: WallLine, jambs: _Jambs, view: View, params: Gaps) -> bool:
    """Furniture ends freely at its other end; a wall goes on to a corner or out of sight."""
    span = lengths(view.surfaces)
    near, far = float(span[line.wall]), float(span[jambs.other])
    behind = line.reversed()
    if not jambs.in_line:
        corner = _anchored(behind, view, line.wall, 0.0, params)
        return corner and min(near, far) >= params.corner_wall
    near_anchored = _anchored(behind, view, line.wall, params.long_wall, params)
    far_anchored = _anchored(line, view, jambs.other, params.long_wall, params)
    if near_anchored and far_anchored:
        return near + far >= params.corner_wall
    return (near_anchored or far_anchored) and near + far >= params.long_wall


def _anchored(line: WallLine, view: View, wall: int, reach: float, params: Gaps) -> bool:
    """Whether a wall on the line does not end freely, going on in the sense of travel.

    It meets something, leaves the view, or goes on behind an opening no wider than ``reach``.
    """
    beams, begin, stop = line.passing_beams(view, wall)
    if begin == stop:
        return True
    if stop == len(beams):
        return False
    last = float(line.crossing[beams[stop - 1]])
    opening = abs(last - line.crossing[beams[begin]])
    closing = _closing_wall(line, view, int(beams[stop]), last, params)
    goes_on = closing is not None and closing[2]
    return bool(opening <= (reach if goes_on else params.jamb_distance))


def _across(line: WallLine, jambs: _Jambs, params: Gaps) -> Segments:
    """The exit in the middle of the wall's thickness, as far as a jamb face shows it."""
    hit, depth = line.along[jambs.run], -line.height[jambs.run]
    on_face = np.abs(hit - jambs.near) <= params.face_distance
    if jambs.in_line:
        on_face |= np.abs(hit - jambs.far) <= params.face_distance
    faces = np.sort(depth[on_face & (depth <= params.max_thickness)])
    thickness = float(faces[-1]) if len(faces) else 0.0
    left = np.array((-line.direction[1], line.direction[0])) * line.step
    ends = line.origin + np.outer((jambs.near, jambs.far), line.direction) - left * thickness / 2
    return np.asarray(ends if line.step == 1 else ends[::-1])


def _without_doubles(exits: Segments, weight: Array, params: Gaps) -> Segments:
    """One exit a doorway: of those whose middles are close, that of the longest wall."""
    middle = midpoints(exits)
    kept: list[int] = []
    for row in np.argsort(-weight, kind="stable"):
        gap = np.hypot(*(middle[kept] - middle[row]).T)
        if not (gap < params.min_width).any():
            kept.append(int(row))
    return np.asarray(exits[np.sort(kept)])
