"""The frame of a step: where the view lies in the MFIS, from the landmarks it shares with it.

The thesis uses the nearest landmark's frame alone for each new surface (3.4, Algorithm 5) and
never says where the robot is. Here each landmark gives a rigid motion; ``nearest`` takes one,
``consensus`` the one that fits all landmarks of the step best (FINDINGS 3: pose error on
re-entry 1.24 m -> 0.09 m). No old surface is moved by either.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from agents.cogmap.mfis import MFIS
from agents.cogmap.params import Frame
from agents.cogmap.view import View
from cogmap_gym.geometry import Pose, Segments

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def landmark_frame(in_view: Segments, in_mfis: Segments) -> Pose:
    """The rigid motion of one landmark: lay its view line on its MFIS line.

    The pair of end points that lie nearest to each other along the line is the centre (thesis
    3.4, Fig. 3.14).

    Args:
        in_view: (2, 2), the landmark in the robot's frame.
        in_mfis: (2, 2), the landmark in the MFIS, normalised: of the same length.
    """
    d, e = in_view[1] - in_view[0], in_mfis[1] - in_mfis[0]
    theta = math.atan2(e[1], e[0]) - math.atan2(d[1], d[0])
    turn = Pose(0.0, 0.0, theta)
    shift = in_mfis[0] - turn.apply(in_view[0])
    return Pose(float(shift[0]), float(shift[1]), turn.theta)


def consensus(
    view: View,
    mfis: MFIS,
    pairs: Ints,
    predicted: Pose,
    prior_sd: tuple[float, float],
    start: Pose,
    params: Frame,
    softness: float = 0.0,
) -> Pose:
    """The pose that best lays all landmarks of the step on their MFIS lines.

    Both ends of what a landmark shares with its MFIS surface pull it across that line;
    along it pull only ends of the wall itself, since those made by occlusion or the field of
    view move with the robot.

    Args:
        view: the surfaces in the robot's frame.
        mfis: the surfaces in the MFIS.
        pairs: (K, 2) rows of view and MFIS that are one surface.
        predicted: ``mfis_from_robot`` by the odometry of the last move.
        prior_sd: standard deviations of that prediction, metres and radians.
        start: where the search begins; the landmarks were found under it.
        params: weights.
        softness: added to every standard deviation [m]; from far away the sharp weights alone
            would hold to whatever happens to lie near.

    Returns:
        ``mfis_from_robot``.
    """
    rows = [_across(view, mfis, pairs, start, params), _along(view, mfis, pairs, start, params)]
    p, q, n, sd = (np.concatenate(column) for column in zip(*rows, strict=True))
    x0 = np.array((start.x, start.y, start.theta))
    prior = np.array((predicted.x, predicted.y, predicted.theta))
    prior[2] = start.theta + math.remainder(predicted.theta - start.theta, math.tau)
    sd = np.hypot(sd, softness)
    x = _solve(p, q, n, sd, x0, prior, np.array(prior_sd), params.outlier, params.iterations)
    return Pose(float(x[0]), float(x[1]), math.remainder(float(x[2]), math.tau))


_Rows = tuple[Floats, Floats, Floats, Floats]


def _across(view: View, mfis: MFIS, pairs: Ints, start: Pose, params: Frame) -> _Rows:
    """Rows that pull the ends of the shared part across the MFIS line."""
    i, j = pairs[:, 0], pairs[:, 1]
    seen, known = view.surfaces[i], mfis.surfaces[j]
    u = _directions(known)
    normal = np.stack((-u[:, 1], u[:, 0]), axis=-1)
    laid = start.apply(seen)
    along = ((laid - known[:, :1]) * u[:, None]).sum(-1)
    span = ((known[:, 1] - known[:, 0]) * u).sum(-1)
    length = np.maximum(along[:, 1] - along[:, 0], params.min_shared)
    t = (np.clip(along, 0.0, span[:, None]) - along[:, :1]) / length[:, None]
    ends = seen[:, None, 0] + np.clip(t, 0.0, 1.0)[..., None] * (seen[:, 1] - seen[:, 0])[:, None]
    view_sd = params.range_sd / np.sqrt(np.maximum(view.hits[i], 2) / 2.0)
    lever = np.abs(along - ((mfis.anchor[j] - known[:, 0]) * u).sum(-1)[:, None])
    sd = np.sqrt(
        params.floor_sd**2
        + view_sd[:, None] ** 2
        + mfis.anchor_sd[j][:, None] ** 2
        + (mfis.heading_sd[j][:, None] * lever) ** 2
    )
    q = np.broadcast_to(known[:, :1], ends.shape)
    n = np.broadcast_to(normal[:, None], ends.shape)
    return ends.reshape(-1, 2), q.reshape(-1, 2), n.reshape(-1, 2), sd.ravel()


def _along(view: View, mfis: MFIS, pairs: Ints, start: Pose, params: Frame) -> _Rows:
    """Rows that pull ends of walls along the MFIS line, where both are ends of the wall."""
    i, j = pairs[:, 0], pairs[:, 1]
    known = mfis.surfaces[j]
    u = np.broadcast_to(_directions(known)[:, None], known.shape)
    gap = ((start.apply(view.surfaces[i]) - known) * u).sum(-1)
    use = view.physical[i] & mfis.physical[j] & (np.abs(gap) < params.end_gate)
    use &= view.spacing[i] < params.max_spacing
    sd = np.hypot(params.end_sd, view.spacing[i])
    return view.surfaces[i][use], known[use], u[use], sd[use]


def _directions(segments: Segments) -> Floats:
    d = segments[:, 1] - segments[:, 0]
    return np.asarray(d / np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)[:, None])


@njit(cache=True)
def _solve(
    p: Floats,
    q: Floats,
    n: Floats,
    sd: Floats,
    x: Floats,
    prior: Floats,
    prior_sd: Floats,
    outlier: float,
    iterations: int,
) -> Floats:
    """Gauss-Newton on (x, y, theta) with Cauchy weights and a prior."""
    x = x.copy()
    for _ in range(iterations):
        h, g = np.zeros((3, 3)), np.zeros(3)
        for a in range(3):
            w = 1.0 / prior_sd[min(a // 2, 1)] ** 2
            h[a, a] += w
            g[a] += w * (x[a] - prior[a])
        c, s = math.cos(x[2]), math.sin(x[2])
        for k in range(len(p)):
            rx, ry = c * p[k, 0] - s * p[k, 1], s * p[k, 0] + c * p[k, 1]
            r = n[k, 0] * (rx + x[0] - q[k, 0]) + n[k, 1] * (ry + x[1] - q[k, 1])
            j = np.array((n[k, 0], n[k, 1], n[k, 1] * rx - n[k, 0] * ry))
            w = 1.0 / (sd[k] ** 2 * (1.0 + (r / (outlier * sd[k])) ** 2))
            for a in range(3):
                g[a] += w * j[a] * r
                for b in range(3):
                    h[a, b] += w * j[a] * j[b]
        step = np.linalg.solve(h, g)
        x -= step
        if abs(step[0]) + abs(step[1]) + abs(step[2]) < 1e-7:
            break
    return x
