"""Where the robot believes to be: the sources of poses that a frontier robot may have."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cogmap_gym.geometry import Array, Pose
from cogmap_gym.observation import LaserSpec, Observation


class PoseSource(Protocol):
    """Keeps the poses of the robot, one an observation, in the frame in which it began."""

    drifts: bool
    """Whether the poses drift by so much that a map made with them does not stay true."""
    corrects: bool
    """Whether poses of the past may change, so that the scans must be kept."""

    @property
    def poses(self) -> list[Pose]:
        """The pose at each observation so far, as believed now."""

    @property
    def revision(self) -> int:
        """Grows when poses of the past have changed by so much that a map must be made anew."""

    @property
    def kept_bytes(self) -> int:
        """What it keeps of what it saw."""

    def reset(self, laser: LaserSpec) -> None:
        """Begin a new life at the origin."""

    def follow(self, observation: Observation, ranges: Array) -> Pose:
        """Take in an observation, with its clean ranges (beams,), and answer the pose now."""


class DeadReckoning:
    """The sum of all measured motions."""

    drifts, corrects, kept_bytes = True, False, 0

    def __init__(self) -> None:
        """At the origin."""
        self.reset(LaserSpec())

    def reset(self, laser: LaserSpec) -> None:  # noqa: ARG002 - the protocol's
        """Begin a new life at the origin."""
        self.poses: list[Pose] = []
        self.revision = 0

    def follow(self, observation: Observation, ranges: Array) -> Pose:  # noqa: ARG002
        """Add the measured motion."""
        last = self.poses[-1] if self.poses else Pose()
        self.poses.append(last @ measured(observation) if self.poses else Pose())
        return self.poses[-1]


class TruePosition:
    """The truth, from the key ``pose`` that the wrapper ``TruePose`` adds: for oracles."""

    drifts, corrects, kept_bytes = False, False, 0

    def __init__(self) -> None:
        """At the origin."""
        self.reset(LaserSpec())

    def reset(self, laser: LaserSpec) -> None:  # noqa: ARG002 - the protocol's
        """Begin a new life at the origin."""
        self.poses: list[Pose] = []
        self.revision = 0
        self._start_from_plan = Pose()

    def follow(self, observation: Observation, ranges: Array) -> Pose:  # noqa: ARG002
        """Read the pose off."""
        pose = Pose(*(float(v) for v in observation["pose"]))
        if not self.poses:
            self._start_from_plan = pose.inverse()
        self.poses.append(self._start_from_plan @ pose)
        return self.poses[-1]


def measured(observation: Observation) -> Pose:
    """The measured motion since the last observation; none where it is not finite."""
    motion = np.asarray(observation["odometry"], dtype=np.float64)
    return Pose(*motion.tolist()) if np.isfinite(motion).all() else Pose()
