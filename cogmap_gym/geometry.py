"""Planar poses and line segments, as the world and the robots share them.

Frames follow ROS REP-103: x forward, y left, angles counter-clockwise positive, in
radians in (-pi, pi]. A pose is named ``a_from_b`` and maps points of frame b into
frame a, so that neighbours cancel: ``a_from_c = a_from_b @ b_from_c``.

``Segments`` are plain arrays of shape (N, 2, 2): (row, start/end, x/y), in metres.
A surface is directed: free space lies on its left, going from start to end. No
segments is ``(0, 2, 2)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Points = NDArray[np.float64]
"""Points, shape (..., 2), metres."""
Segments = NDArray[np.float64]
"""Line segments, shape (N, 2, 2): (row, start/end, x/y), metres."""

NO_SEGMENTS: Segments = np.zeros((0, 2, 2))
NO_SEGMENTS.setflags(write=False)


def wrap_angle(angle: float) -> float:
    """Bring an angle in radians into (-pi, pi]."""
    return math.pi - (math.pi - angle) % math.tau


def wrap_angles(angles: Array) -> Array:
    """Bring angles in radians into (-pi, pi], element by element."""
    return np.asarray(math.pi - (math.pi - angles) % math.tau)


@dataclass(frozen=True, slots=True)
class Pose:
    """A rigid motion of the plane: turn by ``theta`` [rad], then shift by (x, y) [m]."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: ``a_from_b @ b_from_c`` is ``a_from_c``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> Pose:
        """``b_from_a`` of an ``a_from_b``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose(-(c * self.x + s * self.y), s * self.x - c * self.y, wrap_angle(-self.theta))

    def apply(self, points: Points) -> Points:
        """Map points (..., 2) of frame b into frame a; Segments are points too."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        out = np.empty_like(points, dtype=np.float64)
        out[..., 0] = c * points[..., 0] - s * points[..., 1] + self.x
        out[..., 1] = s * points[..., 0] + c * points[..., 1] + self.y
        return out

    @property
    def position(self) -> Points:
        """The origin of frame b in frame a, shape (2,)."""
        return np.array((self.x, self.y))

    def distance(self, other: Pose) -> float:
        """Metres between the two origins."""
        return math.hypot(self.x - other.x, self.y - other.y)


def relative_poses(a: Array, b: Array) -> Array:
    """The poses ``inverse(a[i]) @ b[i]``, row by row.

    Args:
        a: (N, 3) poses x, y [m], theta [rad].
        b: (N, 3) poses in the same frame.

    Returns:
        (N, 3): where b stands as seen from a, angles in (-pi, pi].
    """
    d = b[:, :2] - a[:, :2]
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    turn = wrap_angles(b[:, 2] - a[:, 2])
    return np.column_stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], turn))


def lengths(segments: Segments) -> Array:
    """Lengths in metres, shape (N,)."""
    d = segments[:, 1] - segments[:, 0]
    return np.asarray(np.hypot(d[:, 0], d[:, 1]))


def headings(segments: Segments) -> Array:
    """Headings from start to end, radians in (-pi, pi], shape (N,)."""
    d = segments[:, 1] - segments[:, 0]
    return np.asarray(np.arctan2(d[:, 1], d[:, 0]))


def midpoints(segments: Segments) -> Points:
    """Midpoints, shape (N, 2)."""
    return np.asarray(0.5 * (segments[:, 0] + segments[:, 1]))


def cross(a: Points, b: Points) -> Array:
    """The z component of the cross product of vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def point_segment_distances(points: Points, segments: Segments) -> Array:
    """Distances from each point to each segment.

    Args:
        points: (P, 2).
        segments: (N, 2, 2); a segment of no length counts as a point.

    Returns:
        (P, N), metres.
    """
    # Coordinate by coordinate: sums over an axis of two cost three times as much.
    ax, ay = segments[:, 0, 0], segments[:, 0, 1]
    ux, uy = segments[:, 1, 0] - ax, segments[:, 1, 1] - ay
    dx, dy = points[:, :1] - ax, points[:, 1:] - ay
    squared = ux**2 + uy**2
    t = (dx * ux + dy * uy) / np.where(squared > 0.0, squared, 1.0)
    np.clip(t, 0.0, 1.0, out=t)
    dx -= t * ux
    dy -= t * uy
    return np.asarray(np.sqrt(dx * dx + dy * dy))


def segments_cross(a: Segments, b: Segments) -> NDArray[np.bool_]:
    """Whether each segment of ``a`` properly crosses each of ``b``.

    A shared end or a touching end is not a crossing; nor are collinear overlaps.

    Args:
        a: (N, 2, 2).
        b: (M, 2, 2).

    Returns:
        (N, M).
    """
    p, r = a[:, None, 0], a[:, None, 1] - a[:, None, 0]
    q, s = b[None, :, 0], b[None, :, 1] - b[None, :, 0]
    b0, b1 = cross(r, q - p), cross(r, q + s - p)
    a0, a1 = cross(s, p - q), cross(s, p + r - q)
    return np.asarray((b0 * b1 < 0.0) & (a0 * a1 < 0.0))


def intersection_points(a: Segments, b: Segments) -> Points:
    """Where the infinite lines through a[i] and b[i] meet, shape (N, 2); NaN if parallel."""
    r, s = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0]
    denominator = cross(r, s)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = cross(b[:, 0] - a[:, 0], s) / np.where(denominator == 0.0, np.nan, denominator)
    return np.asarray(a[:, 0] + t[:, None] * r)
