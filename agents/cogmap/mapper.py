"""Algorithm 3: from each view and the odometry of one move to the MFIS (thesis 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.lines import extract_view
from agents.cogmap.locate import NO_PAIRS, Search, by_consensus, by_nearest, near
from agents.cogmap.mfis import (
    EMPTY_MFIS,
    MFIS,
    Edit,
    enter,
    normalise,
    recognise,
    transfer,
    without_dead,
)
from agents.cogmap.params import Frame, Params
from agents.cogmap.view import EMPTY_VIEW, View
from cogmap_gym.geometry import Pose, Segments
from cogmap_gym.observation import LaserSpec

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Mapping:
    """The state of the mapping robot between two views."""

    mfis: MFIS
    mfis_from_robot: Pose
    view: View
    """V_n: the view of this step, the next step's V_{n-1}."""
    ids: Ints
    """(N,): ids of the view's surfaces, 0 where it has none."""
    pairs: Ints
    """(K, 2): the landmarks of this step, rows of view and MFIS."""
    matched: float
    """Share of this step's beams that end on a known surface."""
    step: int
    disagreement: float
    """How far odometry and landmarks lately lay apart, in sds of the prior, at least 1."""


BLANK = Mapping(EMPTY_MFIS, Pose(), EMPTY_VIEW, np.zeros(0, np.int64), NO_PAIRS, 1.0, -1, 1.0)


def update(
    last: Mapping, view: View, odometry: Pose, params: Params, allowed: Bools | None = None
) -> tuple[Mapping, Sequence[Edit]]:
    """Algorithm 3: compute the MFIS.

    Args:
        last: the state after the last view; ``BLANK`` before the first.
        view: V_n, in the robot's frame.
        odometry: motion since the last view, in the robot's previous frame.
        params: all thresholds.
        allowed: (M,) which surfaces of the MFIS may be recognised; all when None. A robot that
            does not know the place it is in allows only what it has just seen.

    Returns:
        The new state, and the edits made to the MFIS.
    """
    p, step = params.frame, last.step + 1
    # Steps 1 and 2: V_{n-1} from the new position, without what cannot be seen
    predicted = last.mfis_from_robot @ odometry
    allowed = np.ones(len(last.mfis), dtype=np.bool_) if allowed is None else allowed
    if p.kind == "odometry":
        allowed = np.zeros(len(last.mfis), dtype=np.bool_)
    recent = allowed & (last.mfis.seen > last.step - p.recent)
    prior_sd = _prior_sd(odometry, last.disagreement, p)
    search = Search(view, last.mfis, recent, allowed, predicted, prior_sd)
    # Step 3: identify landmarks and normalise them
    if p.kind == "nearest":
        found, frames = by_nearest(*_named(last), search, odometry, params)
    else:
        found = by_consensus(search, params)
        frames = [found.mfis_from_robot] * len(view.surfaces)
    pose = found.mfis_from_robot
    mfis = recognise(last.mfis, found.pairs[:, 1], step)
    mfis, lengthened = normalise(view, mfis, found.pairs, pose, step, params.transfer)
    # Step 4: transfer what is not a landmark
    ids = np.zeros(len(view.surfaces), dtype=np.int64)
    ids[found.pairs[::-1, 0]] = mfis.ids[found.pairs[::-1, 1]]
    rows = np.flatnonzero(allowed & near(mfis, view, pose, p.near))
    mfis, ids = transfer(view, mfis, ids, frames, rows, step, params.transfer, params.landmarks)
    mfis, entered = enter(view, mfis, found.pairs, pose, step, params.transfer)
    # Step 5: V_n becomes the next V_{n-1}
    apart = _disagreement(last.disagreement, predicted, pose, prior_sd, p)
    if len(found.pairs) == 0:
        apart = last.disagreement
    tidy = without_dead(mfis, ids, params.transfer.most_forgotten)
    pairs = np.stack((found.pairs[:, 0], tidy.rows_of(mfis.ids[found.pairs[:, 1]])), axis=-1)
    mapping = Mapping(tidy, pose, view, ids, pairs, found.matched, step, apart)
    return mapping, [*lengthened, *entered]


def _named(last: Mapping) -> tuple[Segments, Ints]:
    """Surfaces of V_{n-1} that have an id, made as long as those of the MFIS, and their ids."""
    ids = last.ids[last.ids > 0]
    seen = last.view.surfaces[last.ids > 0]
    known = last.mfis_from_robot.inverse().apply(last.mfis.surfaces[last.mfis.rows_of(ids)])
    along = seen[:, 1] - seen[:, 0]
    u = (along / np.hypot(along[:, 0], along[:, 1])[:, None])[:, None]
    feet = ((known - seen[:, :1]) * u).sum(-1)
    return seen[:, :1] + feet[..., None] * u, ids


def _prior_sd(odometry: Pose, disagreement: float, p: Frame) -> tuple[float, float]:
    """How far the odometry of one move is trusted, metres and radians."""
    distance = float(np.hypot(odometry.x, odometry.y))
    return (
        disagreement * (p.prior_base[0] + p.prior_distance * distance),
        disagreement * (p.prior_base[1] + p.prior_turn * abs(odometry.theta)),
    )


def _disagreement(
    last: float, predicted: Pose, found: Pose, prior_sd: tuple[float, float], p: Frame
) -> float:
    """The memory of how far odometry and landmarks lay apart (FINDINGS 8 d)."""
    off = predicted.inverse() @ found
    now = last * max(float(np.hypot(off.x, off.y)) / prior_sd[0], abs(off.theta) / prior_sd[1])
    return float(np.clip(max(now, p.forgetting * last), 1.0, p.max_disagreement))


class Mapper:
    """Algorithm 3 as a small machine: feed it scans and odometry, read the map."""

    def __init__(self, params: Params, laser: LaserSpec) -> None:
        """Begin with an empty MFIS."""
        self.params, self.laser = params, laser
        self.mapping = BLANK

    def observe(self, ranges: NDArray[np.floating], odometry: Pose) -> Sequence[Edit]:
        """Take in one scan (beams,) [m] and the motion since the last; return the edits."""
        view = extract_view(ranges, self.laser, self.params.lines)
        self.mapping, edits = update(self.mapping, view, odometry, self.params)
        return edits

    @property
    def pose(self) -> Pose:
        """``mfis_from_robot``."""
        return self.mapping.mfis_from_robot

    @property
    def surfaces(self) -> Segments:
        """Surfaces of the MFIS, (N, 2, 2)."""
        return self.mapping.mfis.surfaces

    @property
    def landmark_count(self) -> int:
        """Landmarks of the last step."""
        return len(np.unique(self.mapping.pairs[:, 0]))
