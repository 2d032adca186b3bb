"""What crosses the wall between the world and a robot: specs, spaces and units.

A robot program may import this module and ``cogmap_gym.geometry``, and nothing else of
the world. Lengths are metres, angles radians, times seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from cogmap_gym.geometry import Pose

MARKS = 10
"""How many values ``mark`` and ``goal`` take: 0 for none, 1 for home, then places."""

Observation = dict[str, Any]


@dataclass(frozen=True, slots=True)
class LaserSpec:
    """A planar laser: beam i points at ``first_angle + i * step`` in the laser's frame.

    Defaults are the SICK LMS-200 of thesis 3.2: 360 beams over 180 degrees, 32 m.
    """

    first_angle: float = -math.pi / 2
    """Direction of beam 0 [rad]; the robot's right."""
    step: float = math.radians(0.5)
    """Angle from one beam to the next, counter-clockwise [rad]."""
    beams: int = 360
    """Number of beams."""
    range_max: float = 32.0
    """Largest range; a beam that returns nothing reads this [m]."""
    sd: float = 0.012
    """Standard deviation of a range [m]."""
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Pose of the laser in the robot's frame: x [m], y [m], theta [rad]."""

    def __post_init__(self) -> None:
        """Check the fields.

        Raises:
            ValueError: naming the field that is out of bounds.
        """
        object.__setattr__(self, "mount", tuple(float(v) for v in self.mount))
        numbers = (self.first_angle, self.step, self.range_max, self.sd, *self.mount)
        if len(self.mount) != 3 or not all(map(math.isfinite, numbers)):
            raise ValueError(f"LaserSpec: expected finite numbers and a mount of 3, got {self}")
        if not isinstance(self.beams, int) or self.beams < 1:
            raise ValueError(f"LaserSpec.beams: expected an int of at least 1, got {self.beams!r}")
        if self.step <= 0.0 or self.step * (self.beams - 1) > math.tau:
            raise ValueError(
                f"LaserSpec.step: expected above 0 and at most a full turn in all, got {self.step}"
            )
        if self.range_max <= 0.0 or self.sd < 0.0:
            raise ValueError(f"LaserSpec: expected range_max > 0 and sd >= 0, got {self}")

    @property
    def angles(self) -> NDArray[np.float64]:
        """Beam directions in the laser's frame [rad], shape (beams,)."""
        return np.asarray(self.first_angle + self.step * np.arange(self.beams, dtype=np.float64))

    @property
    def robot_from_laser(self) -> Pose:
        """Where the laser sits on the robot."""
        return Pose(*self.mount)


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A round differential-drive robot and the scale of its actions (Pioneer 3DX)."""

    control: str = "move"
    """``"move"``: turn, then drive, a step of the thesis; ``"velocity"``: 0.1 s of (v, omega)."""
    radius: float = 0.25
    """Radius of the body [m]."""
    max_forward: float = 3.0
    """Longest drive of one move [m]. Thesis 3.3."""
    max_turn: float = math.radians(30.0)
    """Largest turn of one move [rad]. Thesis 3.3."""
    max_speed: float = 0.7
    """Top speed [m/s]."""
    max_turn_rate: float = math.radians(100.0)
    """Top turning rate [rad/s]."""
    velocity_step: float = 0.1
    """Duration of one step of velocity control [s]."""

    def __post_init__(self) -> None:
        """Check the fields.

        Raises:
            ValueError: naming the field that is out of bounds.
        """
        if self.control not in ("move", "velocity"):
            raise ValueError(
                f"RobotSpec.control: expected 'move' or 'velocity', got {self.control!r}"
            )
        for name in (
            "radius",
            "max_forward",
            "max_turn",
            "max_speed",
            "max_turn_rate",
            "velocity_step",
        ):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"RobotSpec.{name}: expected a finite number > 0, got {value!r}")

    def move(self, turn: float, forward: float) -> NDArray[np.float32]:
        """The action that turns by ``turn`` [rad] and then drives ``forward`` [m]."""
        return _action(turn / self.max_turn, 2.0 * forward / self.max_forward - 1.0)

    def velocity(self, v: float, omega: float) -> NDArray[np.float32]:
        """The action that drives at ``v`` [m/s] turning at ``omega`` [rad/s] for one step."""
        return _action(v / self.max_speed, omega / self.max_turn_rate)

    def declare(self) -> NDArray[np.float32]:
        """The action that says "I am there"; the robot does not move."""
        return np.array((0.0, -1.0 if self.control == "move" else 0.0, 1.0), dtype=np.float32)

    @property
    def action_space(self) -> spaces.Box:
        """Box float32 (3,) in [-1, 1]: two motions and the declaration (> 0.5)."""
        return spaces.Box(-1.0, 1.0, (3,), np.float32)


def observation_space(laser: LaserSpec, odometry_bound: tuple[float, float, float]) -> spaces.Dict:
    """The space of what a robot receives.

    Args:
        laser: gives the number of beams and the largest range.
        odometry_bound: largest |dx|, |dy| [m] and |dtheta| [rad] that are ever reported.
    """
    bound = np.array(odometry_bound, dtype=np.float32)
    return spaces.Dict(
        {
            "scan": spaces.Box(0.0, laser.range_max, (laser.beams,), np.float32),
            "odometry": spaces.Box(-bound, bound, (3,), np.float32),
            "bump": spaces.Discrete(2),
            "mark": spaces.Discrete(MARKS),
            "goal": spaces.Discrete(MARKS),
        }
    )


def _action(first: float, second: float) -> NDArray[np.float32]:
    clipped = np.clip((first, second), -1.0, 1.0)
    return np.array((clipped[0], clipped[1], 0.0), dtype=np.float32)
