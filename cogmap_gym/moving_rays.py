"""Laser beams on what moves: people, and boxes that are pushed."""

from __future__ import annotations

import math

import numpy as np

from cogmap_gym.geometry import NO_SEGMENTS, Array, Pose, Segments
from cogmap_gym.raycast import Fan, RayCaster
from cogmap_gym.raycast_kernel import compiled


class MovingCaster(RayCaster):
    """A caster that also sees segments which change their places.

    They are few, and each is looked at by the beams towards it alone.
    """

    moving: Segments = NO_SEGMENTS
    """Where they are now, (M, 2, 2) [m]; assign a new array to move them."""

    def ranges(self, laser_pose: Pose, laser: Fan) -> Array:
        """As ``RayCaster.ranges``, with what moves in the way too."""
        ranges = super().ranges(laser_pose, laser)
        first, step = laser_pose.theta + laser.first_angle, float(laser.step)
        if len(self.moving):
            segments = np.ascontiguousarray(self.moving)
            _cut_short(ranges, segments, float(laser_pose.x), float(laser_pose.y), first, step)
        return ranges


@compiled
def _cut_short(
    ranges: Array, segments: Segments, x: float, y: float, first: float, step: float
) -> None:
    """End beams (B,) at the segments (M, 2, 2) that they meet, in place.

    Args:
        ranges: how far each beam goes [m].
        segments: what is in the way [m].
        x: of the laser [m].
        y: of the laser [m].
        first: direction of beam 0 [rad].
        step: angle from one beam to the next [rad].
    """
    tau = 2.0 * math.pi
    for n in range(segments.shape[0]):
        px, py = segments[n, 0, 0] - x, segments[n, 0, 1] - y
        qx, qy = segments[n, 1, 0] - x, segments[n, 1, 1] - y
        ex, ey = qx - px, qy - py
        start = math.atan2(py, px)
        sweep = math.atan2(px * qy - py * qx, px * qx + py * qy)
        if sweep < 0.0:
            start, sweep = start + sweep, -sweep
        offset = (start - first) % tau
        for turn in range(2):
            low = math.floor((offset - turn * tau) / step)
            high = math.ceil((offset - turn * tau + sweep) / step)
            for b in range(max(low, 0), min(high + 1, ranges.shape[0])):
                dx, dy = math.cos(first + b * step), math.sin(first + b * step)
                across = dx * ey - dy * ex
                if across != 0.0:
                    reach = (px * ey - py * ex) / across
                    along = (px * dy - py * dx) / across
                    if 0.0 <= along <= 1.0 and 0.0 <= reach < ranges[b]:
                        ranges[b] = reach
