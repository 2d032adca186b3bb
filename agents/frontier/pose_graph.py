"""The pose graph: key scans as nodes, measured motions between them as edges, gtsam as solver.

F. Dellaert and GTSAM contributors, borglab/gtsam. Needs the extra ``slam``.
"""

from __future__ import annotations

from typing import Any

import gtsam
import numpy as np

from cogmap_gym.geometry import Array, Pose

ANCHOR_SD = 1e-4
"""The first node stays where it is [m, rad]."""
CAUCHY = 1.0
"""An edge that closes a loop and is off by more sds than this weighs less and less [1]."""


class PoseGraph:
    """Nodes numbered from 0, each with a pose.

    Args:
        first: the pose of node 0, which stays.
    """

    def __init__(self, first: Pose) -> None:
        """Node 0, fixed."""
        self._graph = gtsam.NonlinearFactorGraph()
        fixed = gtsam.noiseModel.Isotropic.Sigma(3, ANCHOR_SD)
        self._graph.add(gtsam.PriorFactorPose2(0, _pose2(first), fixed))

    def add(self, a: int, b: int, a_from_b: Pose, covariance: Array, *, closes: bool) -> None:
        """An edge: b as measured from a.

        Args:
            a: a node.
            b: another.
            a_from_b: the measurement.
            covariance: (3, 3) of x, y and heading in the frame of b [m^2, rad^2].
            closes: whether it closes a loop, and may be wrong.
        """
        noise: Any = gtsam.noiseModel.Gaussian.Covariance(covariance)
        if closes:
            cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(CAUCHY)
            noise = gtsam.noiseModel.Robust.Create(cauchy, noise)
        self._graph.add(gtsam.BetweenFactorPose2(a, b, _pose2(a_from_b), noise))

    def solve(self, poses: list[Pose]) -> list[Pose]:
        """The poses of all nodes that agree best with all edges.

        Args:
            poses: where to start from, one a node.
        """
        values = gtsam.Values()
        for node, pose in enumerate(poses):
            values.insert(node, _pose2(pose))
        solved = gtsam.LevenbergMarquardtOptimizer(self._graph, values).optimize()
        found = (solved.atPose2(node) for node in range(len(poses)))
        return [Pose(p.x(), p.y(), p.theta()) for p in found]


def covariance_of(information: Array, sds: Array, floor: Array) -> Array:
    """The covariance (3, 3) of an edge.

    Args:
        information: (3, 3) of the scans.
        sds: (3,) of what else is known.
        floor: (3,) no edge is more exact than this.
    """
    known = np.linalg.inv(information + np.diag(1.0 / sds**2))
    return np.asarray(known + np.diag(floor**2))


def _pose2(pose: Pose) -> Any:
    return gtsam.Pose2(pose.x, pose.y, pose.theta)
