"""Scan matching without closing loops: each scan is laid on the last key scans."""

from __future__ import annotations

from agents.frontier import params
from agents.frontier.icp import Match, PointMap, match, odometry_sds
from agents.frontier.positions import measured
from agents.frontier.scans import hits_in_robot
from agents.frontier.surfels import Surfels, joined, surfels_of
from cogmap_gym.geometry import Array, Pose, wrap_angle
from cogmap_gym.observation import LaserSpec, Observation

FEWEST = 10
"""A scan with fewer points on walls tells nothing [1]."""


class ScanMatching:
    """Point-to-line ICP with odometry as a prior, against a window of key scans.

    Args:
        matching: of the matching.
        keys: of the window.
    """

    drifts, corrects = False, False

    def __init__(
        self, matching: params.Matching | None = None, keys: params.Keys | None = None
    ) -> None:
        """Take the numbers."""
        self.matching, self.keys = matching or params.Matching(), keys or params.Keys()
        self.reset(LaserSpec())

    def reset(self, laser: LaserSpec) -> None:
        """Begin a new life at the origin."""
        self._laser = laser
        self.poses: list[Pose] = []
        self.revision = 0
        self.key_scans: list[Surfels] = []
        """Of each key scan, in the robot's frame."""
        self.key_steps: list[int] = []
        """At which step each was taken."""
        self.window: list[int] = []
        """The key scans that the next scan is matched with, the last used at the end."""
        self._map: PointMap | None = None

    def follow(self, observation: Observation, ranges: Array) -> Pose:
        """Lay the scan on the window; what it does not tell, odometry decides."""
        scan = surfels_of(hits_in_robot(ranges, self._laser), self.matching)
        motion = measured(observation) if self.poses else Pose()
        guess = self.poses[-1] @ motion if self.poses else Pose()
        found = self._matched(scan, guess, motion)
        self.poses.append(guess if found is None else found.pose)
        if len(scan) >= FEWEST and self._is_new(self.poses[-1]):
            self._keep(scan, found)
        return self.poses[-1]

    @property
    def kept_bytes(self) -> int:
        """Of the key scans, a point and a normal in single precision each."""
        return 4 * 4 * sum(map(len, self.key_scans))

    def key_pose(self, key: int) -> Pose:
        """Where a key scan was taken."""
        return self.poses[self.key_steps[key]]

    def map_of(self, keys: list[int]) -> PointMap:
        """These key scans as one map."""
        return PointMap(joined([self.key_scans[k].moved(self.key_pose(k)) for k in keys]))

    def use(self, keys: list[int]) -> None:
        """These key scans are the last used."""
        self.window = [k for k in self.window if k not in keys] + keys
        self.window = self.window[-self.keys.window :]
        self._map = None

    def _matched(self, scan: Surfels, guess: Pose, motion: Pose) -> Match | None:
        if len(scan) < FEWEST or not self.window:
            return None
        if self._map is None:
            self._map = self.map_of(self.window)
        sds = odometry_sds(motion, self.matching)
        return match(scan, self._map, guess, sds, self.matching)

    def _is_new(self, pose: Pose) -> bool:
        """Whether no key scan of the window was taken near this pose."""
        return not any(
            pose.distance(old) < self.keys.distance
            and abs(wrap_angle(pose.theta - old.theta)) < self.keys.turn
            for old in map(self.key_pose, self.window)
        )

    def _keep(self, scan: Surfels, found: Match | None) -> None:  # noqa: ARG002 - for the graph
        """The scan just taken becomes a key scan."""
        self.key_scans.append(scan)
        self.key_steps.append(len(self.poses) - 1)
        self.use([len(self.key_scans) - 1])
