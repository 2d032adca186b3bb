"""Pose-graph SLAM: scan matching whose loops are closed."""

from __future__ import annotations

import math

import numpy as np

from agents.frontier import params
from agents.frontier.icp import Match, match
from agents.frontier.matching import ScanMatching
from agents.frontier.pose_graph import PoseGraph, covariance_of
from agents.frontier.surfels import Surfels
from cogmap_gym.geometry import Array, Pose, wrap_angle
from cogmap_gym.observation import LaserSpec, Observation


class PoseGraphSLAM(ScanMatching):
    """Scan matching against a window of key scans; each new one is laid on old ones near it.

    Args:
        matching: of the matching.
        keys: of the window.
        loops: of closing loops.
    """

    corrects = True

    def __init__(
        self,
        matching: params.Matching | None = None,
        keys: params.Keys | None = None,
        loops: params.Loops | None = None,
    ) -> None:
        """Take the numbers."""
        self.loops = loops or params.Loops()
        super().__init__(matching, keys)

    def reset(self, laser: LaserSpec) -> None:
        """Begin a new life at the origin."""
        super().reset(laser)
        self._graph: PoseGraph | None = None
        self._driven: list[float] = []
        self._references: list[int] = []
        self._published: list[Pose] = []
        self.closures = 0

    def follow(self, observation: Observation, ranges: Array) -> Pose:
        """As without loops; a pose then moves with the key scan that was used last."""
        steps = len(self.poses)
        step = np.asarray(observation["odometry"], dtype=np.float64)[:2]
        drive = float(np.hypot(*step)) if steps and np.isfinite(step).all() else 0.0
        self._driven.append(drive + (self._driven[-1] if steps else 0.0))
        self._references.append(self.window[-1] if self.window else 0)
        super().follow(observation, ranges)
        self._published.append(self.poses[-1])
        return self.poses[-1]

    def _keep(self, scan: Surfels, found: Match | None) -> None:
        """A node of the graph, an edge to the key scan used last, and perhaps a loop."""
        last = self.window[-1] if self.window else None
        super()._keep(scan, found)
        key = len(self.key_scans) - 1
        self._references[-1] = key
        if last is None:
            self._graph = PoseGraph(self.poses[-1])
            return
        information = np.zeros((3, 3)) if found is None else found.information
        self._connect(last, key, self.poses[-1], information, closes=False)
        old = self._old_keys()
        if not old:
            return
        closed = self._closed(scan, old)
        if closed is not None:
            self._connect(old[0], key, closed.pose, closed.information, closes=True)
            self._correct()
            self.use([*old[::-1], key])

    def _connect(self, a: int, b: int, pose: Pose, information: Array, *, closes: bool) -> None:
        """An edge between two key scans, the second taken at a pose."""
        motion = self.key_pose(a).inverse() @ pose
        length = math.hypot(motion.x, motion.y)
        vague = np.array((0.1 + 0.05 * length, 0.1 + 0.05 * length, math.radians(5.0)))
        position, heading = self.loops.floor
        floor = np.array((position, position, heading))
        assert self._graph is not None, "the first key scan begins the graph"
        self._graph.add(a, b, motion, covariance_of(information, vague, floor), closes=closes)

    def _old_keys(self) -> list[int]:
        """The key scans near the last one that are not in the window, the nearest first."""
        here, driven = self.poses[-1], self._driven[-1]
        near = []
        for key, step in enumerate(self.key_steps):
            since = driven - self._driven[step]
            gap = here.distance(self.poses[step])
            reach = min(self.loops.near + self.loops.drift * since, self.loops.most)
            if key not in self.window and gap < reach:
                near.append((gap, key))
        return [key for _, key in sorted(near)[: self.loops.scans]]

    def _closed(self, scan: Surfels, old: list[int]) -> Match | None:
        """How the scan lies on old key scans, if that can be trusted."""
        here = self.poses[-1]
        since = self._driven[-1] - self._driven[self.key_steps[max(old)]]
        shift, turn = (c + s * since for c, s in (self.loops.shift, self.loops.turn))
        found = match(scan, self.map_of(old), here, np.array((shift, shift, turn)), self.matching)
        off = here.inverse() @ found.pose
        sound = math.hypot(off.x, off.y) < shift and abs(off.theta) < turn
        return found if sound and found.share >= self.loops.good else None

    def _correct(self) -> None:
        """Solve the graph, and move every pose with its key scan."""
        old = [self.key_pose(key) for key in range(len(self.key_scans))]
        assert self._graph is not None, "the first key scan begins the graph"
        new = self._graph.solve(old)
        moved = [a @ b.inverse() for a, b in zip(new, old, strict=True)]
        self.poses = [
            moved[key] @ pose for key, pose in zip(self._references, self.poses, strict=True)
        ]
        self.closures += 1
        position, heading = self.loops.rebuild
        if any(
            a.distance(b) > position or abs(wrap_angle(a.theta - b.theta)) > heading
            for a, b in zip(self.poses, self._published, strict=False)
        ):
            self.revision += 1
            self._published = self.poses[:-1]
