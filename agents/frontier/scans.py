"""What a scan is evidence of."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import LaserSpec

NO_EVIDENCE = 0.0
"""The range of a beam that tells nothing [m]."""


def clean_ranges(scan: NDArray[np.float32], laser: LaserSpec) -> Array:
    """Ranges (beams,) [m]; ``NO_EVIDENCE`` where a beam is not finite or returned nothing."""
    ranges = np.asarray(scan, dtype=np.float64)
    good = np.isfinite(ranges) & (ranges > 0.0) & (ranges < np.float32(laser.range_max))
    return np.where(good, ranges, NO_EVIDENCE)


def hits_in_robot(ranges: Array, laser: LaserSpec) -> Points:
    """Where the beams with evidence ended, (H, 2) in the robot's frame [m], in their order."""
    good = ranges > NO_EVIDENCE
    angles = laser.angles[good]
    points = ranges[good, None] * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    return laser.robot_from_laser.apply(points)


def free_way(hits: Points, turn: float, radius: float) -> float:
    """How far a disc of ``radius`` gets in the direction ``turn`` before it touches a hit [m]."""
    ahead = Pose(0.0, 0.0, -turn).apply(hits)
    ahead = ahead[(ahead[:, 0] > 0.0) & (np.abs(ahead[:, 1]) < radius)]
    if len(ahead) == 0:
        return math.inf
    return float(np.min(ahead[:, 0] - np.sqrt(radius**2 - ahead[:, 1] ** 2)))
