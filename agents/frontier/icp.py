"""Scan matching: point-to-line ICP with odometry as a prior.

A. Censi, An ICP variant using a point-to-line metric, ICRA 2008; the prior is one more term of
the least squares, so that what the walls do not tell, odometry decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from agents.frontier import params
from agents.frontier.surfels import Surfels
from cogmap_gym.geometry import Array, Pose, wrap_angle

MOST_SHIFT = 0.5
"""No iteration corrects by more than this [m, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """How a scan lies on a map."""

    pose: Pose
    """Map from robot."""
    information: Array
    """(3, 3) of x, y and heading in the robot's frame, without the prior [1/m^2, 1/rad^2]."""
    share: float
    """Of the scan's points that lie on the map [1]."""


class PointMap:
    """Surfels that scans are matched with.

    Args:
        surfels: in the frame of the map.
    """

    def __init__(self, surfels: Surfels) -> None:
        """Build the search tree."""
        self.surfels = surfels
        self.tree = cKDTree(surfels.points)


def odometry_sds(motion: Pose, numbers: params.Matching) -> Array:
    """Standard deviations of a measured motion: x, y, heading, (3,) [m, m, rad]."""
    drive, turn = math.hypot(motion.x, motion.y), abs(motion.theta)
    constant, share = numbers.position_sd
    position = constant + share * drive
    fixed, of_turn, of_drive = numbers.heading_sd
    return np.array((position, position, fixed + of_turn * turn + of_drive * drive))


def match(
    scan: Surfels, point_map: PointMap, guess: Pose, sds: Array, numbers: params.Matching
) -> Match:
    """Lay a scan on a map.

    Args:
        scan: in the robot's frame.
        point_map: not empty.
        guess: map from robot, as odometry has it.
        sds: how exact the guess is: x, y, heading, (3,) [m, m, rad].
        numbers: of the matching.
    """
    found = _iterate(scan, point_map, guess, guess, sds, numbers)
    if found.share >= numbers.good:
        return found
    others = [
        _iterate(scan, point_map, guess @ Pose(theta=turn), guess, sds, numbers)
        for turn in numbers.headings
    ]
    return max((found, *others), key=lambda m: m.share)


def _iterate(
    scan: Surfels,
    point_map: PointMap,
    start: Pose,
    guess: Pose,
    sds: Array,
    numbers: params.Matching,
) -> Match:
    """Match points and solve, in turn, from a start; the prior draws towards the guess."""
    pose, found = start, Match(start, np.zeros((3, 3)), 0.0)
    for gate in numbers.gates:
        found, gradient = _normal_equations(scan, point_map, pose, gate, numbers)
        off = guess.inverse() @ pose
        weights = 1.0 / sds**2
        # The prior's error and shift are both in the robot's frame, alike for small turns.
        error = Pose(0.0, 0.0, -off.theta).apply(np.array((off.x, off.y)))
        prior = weights * np.array((error[0], error[1], off.theta))
        shift = -np.linalg.solve(found.information + np.diag(weights), gradient + prior)
        shift = np.clip(shift, -MOST_SHIFT, MOST_SHIFT)
        pose = pose @ Pose(float(shift[0]), float(shift[1]), wrap_angle(float(shift[2])))
        if np.abs(shift).max() < numbers.still and gate == numbers.gates[-1]:
            break
    return replace(found, pose=pose)


def _normal_equations(
    scan: Surfels, point_map: PointMap, pose: Pose, gate: float, numbers: params.Matching
) -> tuple[Match, Array]:
    """The least squares at a pose: what it is worth, and its gradient (3,), robot's frame."""
    placed = scan.moved(pose)
    found = point_map.tree.query(placed.points, distance_upper_bound=gate)
    gaps, nearest = (np.asarray(column) for column in found)
    near = np.isfinite(gaps)
    rows = nearest[near]
    normals = point_map.surfels.normals[rows]
    alike = (normals * placed.normals[near]).sum(axis=1) > numbers.alike
    normals, points = normals[alike], scan.points[near][alike]
    offsets = placed.points[near][alike] - point_map.surfels.points[rows[alike]]
    error = (offsets * normals).sum(axis=1)
    weight = 1.0 / (numbers.sd**2 * (1.0 + (error / numbers.scale) ** 2))
    in_robot = Pose(0.0, 0.0, -pose.theta).apply(normals)
    lever = points[:, 0] * in_robot[:, 1] - points[:, 1] * in_robot[:, 0]
    jacobian = np.column_stack((in_robot, lever))
    information = (jacobian * weight[:, None]).T @ jacobian
    share = float((np.abs(error) < numbers.near).sum()) / max(1, len(scan))
    return Match(pose, information, share), jacobian.T @ (weight * error)
