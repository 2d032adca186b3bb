"""A view: what one scan shows, as surfaces in the robot's frame (thesis 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import NO_SEGMENTS, Points, Segments


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """The surfaces of one scan, in the robot's frame, ordered counter-clockwise.

    Rows of ``surfaces``, ``physical``, ``spacing``, ``beams`` and ``hits`` belong together.
    """

    points: Points
    """Where each beam ended, in beam order, shape (B, 2); NaN where there is no evidence."""
    surfaces: Segments
    """(N, 2, 2), free space on the left: the start is seen at the right, the end at the left."""
    physical: NDArray[np.bool_]
    """(N, 2): the end is an end of the wall itself, not made by occlusion or the field of view."""
    spacing: NDArray[np.float64]
    """(N, 2): distance between neighbouring beams on the surface at each end [m]."""
    beams: NDArray[np.int64]
    """(N, 2): first and last beam of each surface."""
    hits: NDArray[np.int64]
    """(N,): how many beams support each surface."""


EMPTY_VIEW = View(
    np.zeros((0, 2)),
    NO_SEGMENTS,
    np.zeros((0, 2), dtype=np.bool_),
    np.zeros((0, 2)),
    np.zeros((0, 2), dtype=np.int64),
    np.zeros(0, dtype=np.int64),
)
