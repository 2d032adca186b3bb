"""What exits part from view: what lies behind one is another place's (thesis 3.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.exits import Book, exit_lines
from agents.cogmap.params import Exits
from cogmap_gym.geometry import Points, Segments, cross, segments_cross


def seen_through_exit(
    book: Book, robot: Points, points: Points, beside: float
) -> NDArray[np.bool_]:
    """Which points (P, 2) lie behind, or in, an exit as seen from the robot (2,), (P,).

    Args:
        book: all exits.
        robot: (2,) in the MFIS.
        points: (P, 2) in the MFIS.
        beside: an exit covers this much more than itself at both ends [m].
    """
    lines = _parting(book)
    d = lines[:, 1] - lines[:, 0]
    width = np.hypot(d[:, 0], d[:, 1])
    wide = d / width[:, None] * beside
    covers = np.stack((lines[:, 0] - wide, lines[:, 1] + wide), axis=1)
    sights = np.stack((np.broadcast_to(robot, points.shape), points), axis=1)
    gap = points[:, None] - lines.mean(axis=1)
    inside = np.hypot(gap[..., 0], gap[..., 1]) < 0.5 * width + beside
    return np.asarray((segments_cross(sights, covers) | inside).any(axis=1))


def reach_to_exits(book: Book, eye: Points, ends: Points, params: Exits) -> NDArray[np.float64]:
    """How far one sees towards each of some points (P, 2) before an exit begins [m], (P,).

    Args:
        book: all exits.
        eye: (2,) in the MFIS.
        ends: (P, 2) in the MFIS.
        params: an exit covers ``slack`` more than itself at both ends.
    """
    lines = _parting(book)
    along = lines[:, 1] - lines[:, 0]
    share = params.slack / np.hypot(along[:, 0], along[:, 1])
    rays = (ends - eye)[:, None]
    from_eye = lines[:, 0] - eye
    with np.errstate(divide="ignore", invalid="ignore"):
        t = cross(from_eye, along) / cross(rays, along)
        u = cross(from_eye, rays) / cross(rays, along)
    meets = (t > 0.0) & (u > -share) & (u < 1.0 + share)
    size = np.hypot(*(ends - eye).T)
    return np.asarray(np.where(meets, t, np.inf).min(axis=1, initial=np.inf) * size)


def _parting(book: Book) -> Segments:
    """The lines of the exits that were seen and part two places, (E, 2, 2)."""
    seen = (e for e in book if e.sightings > 0 and e.left != e.right and not e.false)
    return exit_lines(tuple(seen))
