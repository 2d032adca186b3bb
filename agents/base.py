"""The protocol that every robot program follows, scripted or learned."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.observation import LaserSpec, Observation, RobotSpec


@runtime_checkable
class Agent(Protocol):
    """A robot program: it gets scans and odometry, and answers with actions.

    An agent never raises on a scan: beams that are not finite, or that returned
    nothing, are no evidence.
    """

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing."""

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Answer one observation with one action of ``robot.action_space``."""

    def sketch(self) -> dict[str, Any] | None:
        """What it believes, JSON-able and in its own coordinates, or None.

        Keys: ``surfaces`` [{id, p, q}], ``exits`` [{id, p, q}], ``asrs`` [{id, boundary,
        exits}], ``links`` [[asr, exit, asr]], ``here`` (ASR id), ``pose`` [x, y, theta],
        ``home``, ``marks``, ``route`` ([exit id] or None), ``status``.
        """
