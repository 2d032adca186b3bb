"""How an action is read: three numbers within bounds, the last of which may declare."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from cogmap_gym.observation import RobotSpec

DECLARED: Final = 0.5
"""An action whose third number is above this says "I am there". DESIGN 3."""


def checked(action: Any) -> tuple[float, float, float]:
    """The three numbers of an action, clipped to [-1, 1].

    Raises:
        ValueError: another shape than (3,), or NaN.
    """
    values = np.asarray(action, dtype=np.float64)
    if values.shape != (3,) or np.isnan(values).any():
        raise ValueError(f"action: expected 3 numbers, none NaN, got {action!r}")
    first, second, third = np.clip(values, -1.0, 1.0).tolist()
    return first, second, third


def turn_and_forward(robot: RobotSpec, first: float, second: float) -> tuple[float, float]:
    """The turn [rad] and the drive after it [m] that a ``move`` action asks for."""
    return first * robot.max_turn, robot.max_forward * (second + 1.0) / 2.0
