"""What the robot must not touch: points of the last scans, near it, in the MFIS.

The MFIS leaves out small things and keeps shut doors for ever; this short memory holds
every point seen nearby until a later beam goes through where it was.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Obstacles
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.observation import LaserSpec


def remember_obstacles(
    known: Points, points: Points, mfis_from_robot: Pose, laser: LaserSpec, params: Obstacles
) -> Points:
    """Forget what is far or seen through, and add what this view shows.

    Args:
        known: (P, 2) in the MFIS.
        points: (beams, 2) where each beam ended, in the robot's frame; NaN without evidence.
        mfis_from_robot: where the robot is.
        laser: to find the beams that pass a point.
        params: distances.

    Returns:
        (Q, 2) in the MFIS.
    """
    in_robot = mfis_from_robot.inverse().apply(known)
    keep = np.hypot(in_robot[:, 0], in_robot[:, 1]) < params.radius
    keep &= ~_seen_through(in_robot, points, laser, params.seen_through)
    with np.errstate(invalid="ignore"):
        new = points[np.hypot(points[:, 0], points[:, 1]) < params.radius]
    together = np.concatenate((known[keep], mfis_from_robot.apply(new)))
    cells = np.floor(together / params.cell).astype(np.int64)
    # The newest point of each cell stays.
    key = (cells[:, 0] << 32) + cells[:, 1]
    _, last = np.unique(key[::-1], return_index=True)
    return np.asarray(together[len(together) - 1 - last])


def _seen_through(
    in_robot: Points, points: Points, laser: LaserSpec, margin: float
) -> NDArray[np.bool_]:
    """Which points (P, 2) lie on beams that end well behind them, (P,)."""
    if len(points) != laser.beams:
        return np.zeros(len(in_robot), dtype=np.bool_)
    laser_from_robot = laser.robot_from_laser.inverse()
    at, ends = laser_from_robot.apply(in_robot), laser_from_robot.apply(points)
    bearing = (np.arctan2(at[:, 1], at[:, 0]) - laser.first_angle) % (2.0 * np.pi)
    beam = np.floor(bearing / laser.step).astype(np.int64)
    inside = beam + 1 < laser.beams
    beam = np.where(inside, beam, 0)
    ranges = np.hypot(ends[:, 0], ends[:, 1])
    distance = np.hypot(at[:, 0], at[:, 1]) + margin
    following = np.minimum(beam + 1, laser.beams - 1)
    with np.errstate(invalid="ignore"):
        return np.asarray(inside & (ranges[beam] > distance) & (ranges[following] > distance))
