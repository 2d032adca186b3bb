"""What a place still hides: gaps not gone through, and walls seen too sparsely to show a door."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.exits import Book, seen_through_exit
from agents.cogmap.params import Curiosity
from agents.cogmap.view import View
from cogmap_gym.geometry import Points, Pose, Segments, cross, lengths, midpoints
from cogmap_gym.observation import LaserSpec

Bools = NDArray[np.bool_]


def open_gaps(
    gaps: Segments,
    seen: Segments,
    view: View,
    pose: Pose,
    laser: LaserSpec,
    book: Book,
    params: Curiosity,
) -> Segments:
    """Gaps that wait to be explored, brought up to date with a view.

    Args:
        gaps: (G, 2, 2) in the MFIS, from earlier views of this place, what they hide on the right.
        seen: (N, 2, 2) gaps of the view, in the robot's frame.
        view: the view.
        pose: ``mfis_from_robot``.
        laser: the laser.
        book: exits; what lies behind one is another place's.
        params: distances.

    Returns:
        (H, 2, 2): without those that the robot was near, those around which all is seen to be
        open, and those that it sees from behind.
    """
    new = pose.apply(seen)
    new = new[~seen_through_exit(book, pose.position, midpoints(new), params.beside_exit)]
    in_robot = pose.inverse().apply(gaps)
    middle = midpoints(in_robot)
    distance = np.hypot(middle[:, 0], middle[:, 1])
    reach, covered = _beams_around(middle, distance, view, laser, params)
    opened = covered & (reach > distance + params.open_radius)
    d = in_robot[:, 1] - in_robot[:, 0]
    beyond = cross(d, middle) / np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)
    from_behind = covered & (beyond > params.behind) & (reach > distance - params.open_radius)
    together = np.concatenate((gaps[~(opened | from_behind)], new))
    far = np.hypot(*(midpoints(together) - pose.position).T) > params.visited
    return _thinned(together[far], params.visited)


def dim_walls(
    dim: Segments, lit: Points, view: View, pose: Pose, laser: LaserSpec, params: Curiosity
) -> tuple[Segments, Points]:
    """Pieces of wall seen only sparsely or at a glance, where a doorway may go unnoticed.

    Args:
        dim: (D, 2, 2) in the MFIS, from earlier views of this place, free space on the left.
        lit: (L, 2) in the MFIS, middles of pieces once seen densely.
        view: the view.
        pose: ``mfis_from_robot``.
        laser: the laser.
        params: distances.

    Returns:
        The dim pieces (E, 2, 2) and the lit middles (M, 2), brought up to date.
    """
    pieces = _pieces(view.surfaces, params.piece)
    laid = pose.apply(pieces)
    dense = (_spacing(pieces, laser) <= params.max_spacing) & (_sine(pieces) > params.lit_sine)
    bright = midpoints(laid[dense])
    lit = np.concatenate((lit, bright[~_near(bright, lit, 0.5 * params.piece)]))
    together = np.concatenate((dim, laid[~dense]))
    old = _nearly(together, len(dim), params.piece)
    dark = ~_near(midpoints(together), lit, params.piece) & old
    return together[dark], lit


def _near(points: Points, others: Points, distance: float) -> Bools:
    """Which points (P, 2) are nearer than ``distance`` to any of the others (Q, 2), (P,)."""
    gap = points[:, None] - others[None]
    squared = (gap**2).sum(axis=-1)
    return np.asarray((squared < distance**2).any(axis=1))


def _nearly(pieces: Segments, kept: int, apart: float) -> Bools:
    """The first ``kept`` pieces, and those of the rest that are not near one of them, (P,)."""
    middle = midpoints(pieces)
    out = np.ones(len(pieces), dtype=np.bool_)
    out[kept:] = ~_near(middle[kept:], middle[:kept], apart)
    return out


def wall_pieces(surfaces: Segments, params: Curiosity) -> Segments:
    """Surfaces (N, 2, 2) cut into pieces about as long as a door is wide, (P, 2, 2)."""
    return _pieces(surfaces, params.piece)


def not_yet_squarely(pieces: Segments, pose: Pose, laser: LaserSpec, params: Curiosity) -> Segments:
    """Pieces of wall not seen squarely enough from here to see a door open in them.

    Args:
        pieces: (P, 2, 2) in the MFIS, free space on the left.
        pose: ``mfis_from_robot``.
        laser: the laser.
        params: distances and angles.

    Returns:
        (Q, 2, 2) likewise.
    """
    if not len(pieces):
        return pieces
    seen = pose.inverse().apply(pieces)
    middle = seen.mean(axis=1)
    distance = np.hypot(middle[:, 0], middle[:, 1])
    bearing = np.arctan2(middle[:, 1], middle[:, 0])
    last = laser.first_angle + laser.step * (laser.beams - 1)
    square = (_sine(seen) > params.square_sine) & (distance < params.square_reach)
    return np.asarray(pieces[~(square & (bearing > laser.first_angle) & (bearing < last))])


def _pieces(surfaces: Segments, size: float) -> Segments:
    """Long surfaces cut into pieces of about ``size``, (P, 2, 2)."""
    counts = np.floor(lengths(surfaces) / size).astype(np.int64)
    rows = np.repeat(np.arange(len(surfaces)), counts)
    k = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    along = surfaces[rows, 1] - surfaces[rows, 0]
    ends = np.stack((k / counts[rows], (k + 1) / counts[rows]), axis=-1)
    return np.asarray(surfaces[rows, :1] + ends[..., None] * along[:, None])


def _sine(pieces: Segments) -> NDArray[np.float64]:
    """Sine of the angle between each piece and the sight from the robot to its middle, (P,)."""
    middle, d = midpoints(pieces), pieces[:, 1] - pieces[:, 0]
    size = np.hypot(d[:, 0], d[:, 1]) * np.hypot(middle[:, 0], middle[:, 1])
    return np.asarray(np.abs(cross(d, middle)) / np.maximum(size, 1e-9))


def _spacing(pieces: Segments, laser: LaserSpec) -> NDArray[np.float64]:
    """Distance between neighbouring beams on each piece [m], seen from the robot, (P,)."""
    d = pieces[:, 1] - pieces[:, 0]
    size = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)
    across = np.abs(d[:, 0] * pieces[:, 0, 1] - d[:, 1] * pieces[:, 0, 0]) / size
    squared = (pieces.mean(axis=1) ** 2).sum(axis=-1)
    return np.asarray(squared * laser.step / np.maximum(across, 1e-3))


def _beams_around(
    points: Points, distance: NDArray[np.float64], view: View, laser: LaserSpec, params: Curiosity
) -> tuple[NDArray[np.float64], Bools]:
    """The shortest beam within ``open_radius`` of each point (P, 2), and whether all are seen."""
    ranges = np.hypot(view.points[:, 0], view.points[:, 1])
    bearing = np.arctan2(points[:, 1], points[:, 0])
    half = np.maximum(params.open_radius / np.maximum(distance, 1e-9), laser.step)
    first = np.floor((bearing - half - laser.first_angle) / laser.step).astype(np.int64)
    last = np.ceil((bearing + half - laser.first_angle) / laser.step).astype(np.int64)
    covered = (first >= 0) & (last < len(ranges))
    reach = np.array(
        [np.min(ranges[a : b + 1]) if c else np.nan
         for a, b, c in zip(first, last, covered, strict=True)]
    ).reshape(len(points))  # fmt: skip
    return reach, covered & np.isfinite(reach)


def _thinned(gaps: Segments, apart: float) -> Segments:
    """Gaps no two of whose middles are nearer than ``apart``; the first ones stay."""
    kept: list[int] = []
    middle = midpoints(gaps)
    for k in range(len(gaps)):
        if not (np.hypot(*(middle[kept] - middle[k]).T) < apart).any():
            kept.append(k)
    return gaps[kept]
