"""What a place still hides: gaps not gone through, and walls seen too sparsely to show a door."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.exit_sight import seen_through_exit
from agents.cogmap.exits import Book
from agents.cogmap.free_space import Cells, cells_of, free_cells
from agents.cogmap.memory import Leads
from agents.cogmap.params import Curiosity, Params
from agents.cogmap.view import View
from cogmap_gym.geometry import Points, Pose, Segments, cross, lengths, midpoints
from cogmap_gym.observation import LaserSpec

Bools = NDArray[np.bool_]


def see_free(leads: Leads, view: View, pose: Pose, laser: LaserSpec, params: Curiosity) -> Leads:
    """Note what the beams of a view show to be free."""
    new = free_cells(view, pose, laser, params)
    known = leads.seen
    at = np.searchsorted(known, new)
    fresh = new[known[np.minimum(at, len(known) - 1)] != new] if len(known) else new
    return replace(leads, seen=np.union1d(known, fresh)) if len(fresh) else leads


def follow_gaps(leads: Leads, new: Segments, pose: Pose, book: Book, params: Curiosity) -> Leads:
    """Gaps that wait to be explored, brought up to date with a view.

    Args:
        leads: of this place, with the view's free cells.
        new: (N, 2, 2) gaps of the view in the MFIS, what they hide on the right.
        pose: ``mfis_from_robot``.
        book: exits; what lies behind one is another place's.
        params: distances.

    Returns:
        The leads without the gaps that the robot is near to and faces, which are done, and without
        those behind which most has been seen by now.
    """
    at, robot_from_mfis = pose.position, pose.inverse()
    new = new[~seen_through_exit(book, at, midpoints(new), params.beside_exit)]
    new = new[~_near(midpoints(new), leads.done, params.visited)]
    together = np.concatenate((leads.gaps, new))
    together = together[_hides(together, leads.seen, params)]
    near = np.hypot(*(midpoints(together) - at).T) <= params.visited
    near &= robot_from_mfis.apply(midpoints(together))[:, 0] >= 0.0
    done = _thinned_points(np.concatenate((leads.done, midpoints(together[near]))), 0.1)
    return replace(leads, gaps=_thinned(together[~near], params.visited), done=done)


def _hides(gaps: Segments, seen: Cells, params: Curiosity) -> Bools:
    """Behind which gaps (G, 2, 2) most is still unseen, (G,)."""
    d = gaps[:, 1] - gaps[:, 0]
    right = np.stack((d[:, 1], -d[:, 0]), axis=-1) / np.maximum(lengths(gaps), 1e-9)[:, None]
    across = gaps[:, None, 0] + np.array(params.behind_shares)[:, None] * d[:, None]
    depth = np.array(params.behind)[:, None] * right[:, None]
    cells = cells_of(across[:, :, None] + depth[:, None], params)
    return np.asarray((~np.isin(cells, seen)).mean(axis=(1, 2)) >= params.hidden_share)


def worth_coming_back(gaps: Segments, params: Curiosity) -> Segments:
    """Those gaps (G, 2, 2) that are worth a visit to a place once explored, (H, 2, 2)."""
    return np.asarray(gaps[lengths(gaps) > params.lead_width])


def follow_walls(
    leads: Leads, view: View, pose: Pose, laser: LaserSpec, book: Book, params: Curiosity
) -> Leads:
    """Pieces of wall seen only sparsely or at a glance, where a doorway may go unnoticed.

    Args:
        leads: of this place.
        view: the view.
        pose: ``mfis_from_robot``.
        laser: the laser.
        book: exits; what lies behind one is another place's.
        params: distances.
    """
    pieces = _pieces(view.surfaces, params.piece)
    laid = pose.apply(pieces)
    dense = (_spacing(pieces, laser) <= params.max_spacing) & (_sine(pieces) > params.lit_sine)
    bright = midpoints(laid[dense])
    lit = np.concatenate((leads.lit, bright[~_near(bright, leads.lit, 0.5 * params.piece)]))
    dark = laid[~dense]
    dark = dark[~seen_through_exit(book, pose.position, midpoints(dark), params.beside_exit)]
    together = np.concatenate((leads.dim, dark))
    dim = together[_nearly(together, len(leads.dim), params.piece)]
    return replace(leads, dim=dim[~_near(midpoints(dim), lit, params.piece)], lit=lit)


def lead_points(leads: Leads, params: Params) -> Points:
    """Where to go to see more of a place, (K, 2) in the MFIS: gaps, and spots before walls.

    Without what was reached or given up.
    """
    points = np.concatenate((midpoints(leads.gaps), before_walls(leads.dim, params.curiosity)))
    return points[~_near(points, leads.done, params.exploration.same_target)]


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


def before_walls(pieces: Segments, params: Curiosity) -> Points:
    """Where to stand to look at pieces of wall (P, 2, 2), free space on the left, (P, 2)."""
    d = pieces[:, 1] - pieces[:, 0]
    left = np.stack((-d[:, 1], d[:, 0]), axis=-1) / np.hypot(d[:, 0], d[:, 1])[:, None]
    return np.asarray(pieces.mean(axis=1) + params.stand * left)


def wall_pieces(walls: Segments, params: Curiosity) -> Segments:
    """Walls (N, 2, 2) cut into pieces about as long as a door is wide, (P, 2, 2).

    One shorter than that is a piece of its own, but not what is shorter than its half.
    """
    size = lengths(walls)
    short = (size >= 0.5 * params.piece) & (size < params.piece)
    return np.concatenate((_pieces(walls, params.piece), walls[short]))


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
    distance = np.hypot(*midpoints(seen).T)
    along = (seen[:, 1] - seen[:, 0]) / np.maximum(lengths(seen), 1e-9)[:, None]
    # A door's other jamb must be in view, too.
    ends = seen + params.jamb_aside * np.stack((-along, along), axis=1)
    bearing = np.arctan2(ends[..., 1], ends[..., 0])
    last = laser.first_angle + laser.step * (laser.beams - 1)
    in_view = ((bearing > laser.first_angle) & (bearing < last)).all(axis=1)
    square = (_sine(seen) > params.square_sine) & (distance < params.square_reach)
    return np.asarray(pieces[~(square & in_view)])


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


def _thinned(gaps: Segments, apart: float) -> Segments:
    """Gaps no two of whose middles are nearer than ``apart``; the first ones stay."""
    kept: list[int] = []
    middle = midpoints(gaps)
    for k in range(len(gaps)):
        if not (np.hypot(*(middle[kept] - middle[k]).T) < apart).any():
            kept.append(k)
    return gaps[kept]


def _thinned_points(points: Points, apart: float) -> Points:
    """Points no two of which are nearer than ``apart``; the first ones stay."""
    gap = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    return np.asarray(points[~np.tril(gap < apart, -1).any(axis=1)])
