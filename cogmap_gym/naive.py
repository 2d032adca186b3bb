"""The naive way: pymunk is asked for the nearest segment beam by beam. The rival of benchmarks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray

from cogmap_gym.env import CogMapEnv
from cogmap_gym.geometry import Pose, Segments
from cogmap_gym.observation import LaserSpec


class NaiveLaser:
    """Asks pymunk for the nearest segment beam by beam, and adds NumPy noise."""

    def __init__(self, walls: Segments, spec: LaserSpec) -> None:
        """See ``walls`` (N, 2, 2) [m]."""
        self._space, self._spec = pymunk.Space(), spec
        for p, q in walls.tolist():
            self._space.add(pymunk.Segment(self._space.static_body, p, q, 0.0))

    def scan(self, pose: Pose, rng: np.random.Generator) -> NDArray[np.float32]:
        """One scan (beams,) [m]."""
        spec, every = self._spec, pymunk.ShapeFilter()
        reach, ranges = spec.range_max, np.full(spec.beams, spec.range_max)
        for i, angle in enumerate((pose.theta + spec.angles).tolist()):
            end = pose.x + reach * math.cos(angle), pose.y + reach * math.sin(angle)
            hit = self._space.segment_query_first((pose.x, pose.y), end, 0.0, every)
            if hit is not None:
                ranges[i] = reach * hit.alpha
        noisy = np.clip(ranges + rng.normal(0.0, spec.sd, spec.beams), 0.0, reach)
        return np.where(ranges < reach, noisy, reach).astype(np.float32)


class NaiveEnv(CogMapEnv):
    """The same task with a naive laser; all else is as in ``CogMapEnv``."""

    def reset(self, **keywords: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the laser sees the doors as they stand then."""
        self._scanner = NaiveLaser(self.world.solid_segments, self.laser)  # type: ignore[assignment]
        return super().reset(**keywords)
