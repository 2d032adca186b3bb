"""Openings in walls that the robot knows: doors that were shut when it was last here.

Ours. A view may show such a door too flatly for a doorway; but where a wall was, and beams now
pass between two stretches of it, there is an exit (thesis 4.4.2 finds new exits "nearby").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Gaps
from cogmap_gym.geometry import NO_SEGMENTS, Array, Points, Segments, cross, lengths

Bools = NDArray[np.bool_]


def wall_openings(walls: Segments, eye: Points, ends: Points, params: Gaps) -> Segments:
    """The openings of a door's width in known walls through which beams pass.

    Args:
        walls: (N, 2, 2) surfaces of the present place, free space on the left.
        eye: (2,), where the beams come from.
        ends: (B, 2), where they end.
        params: widths and distances.

    Returns:
        (E, 2, 2), the robot's space on the left; all in the MFIS.
    """
    found = [
        opening
        for wall in walls[lengths(walls) > params.long_wall]
        for opening in _in_wall(wall, eye, ends, params)
    ]
    return np.stack(found) if found else NO_SEGMENTS


def _in_wall(wall: Segments, eye: Points, ends: Points, p: Gaps) -> list[Segments]:
    """The openings (2, 2) in one wall (2, 2)."""
    size = float(np.hypot(*(wall[1] - wall[0])))
    along = (wall[1] - wall[0]) / size
    height = float(cross(along, eye - wall[0]))
    if height <= 0.0 or len(ends) == 0:
        return []  # seen from behind
    above = cross(along, ends - wall[0])
    where = (ends - wall[0]) @ along
    start = float((eye - wall[0]) @ along)
    on = np.abs(above) < p.known_wall
    through = above < -p.room_beyond
    share = height / np.where(through, height - above, 1.0)
    at = np.where(through, start + share * (where - start), where)
    rows = (on | through) & (at > 0.0) & (at < size)
    order = np.argsort(at[rows], kind="stable")
    at, passing = at[rows][order], through[rows][order]
    return [wall[0] + np.outer(span, along) for span in _spans(at, passing, p)]


def _spans(at: Array, passing: Bools, p: Gaps) -> list[tuple[float, float]]:
    """Where along a wall enough beams pass between two that end on it, at a door's width."""
    solid = np.flatnonzero(~passing)
    count = np.diff(solid) - 1
    width = np.diff(at[solid])
    doors = (count >= p.wall_beams) & (width >= p.min_width) & (width <= p.max_known_door)
    return [(float(at[solid[k]]), float(at[solid[k + 1]])) for k in np.flatnonzero(doors)]
