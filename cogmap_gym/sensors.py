"""What the robot senses of the world: laser ranges and wheel odometry, with their noise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from numbers import Integral
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Pose, wrap_angle
from cogmap_gym.noise import noisy_ranges
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.raycast import RayCaster
from cogmap_gym.spec_fields import known_fields, number_of

TYPICAL_DISTANCE: Final = 1.5
"""Drive to which the odometry levels refer [m]. DESIGN 3."""
TYPICAL_TURN: Final = math.radians(15.0)
"""Turn to which the odometry levels refer [rad]. DESIGN 3."""
BOUND_SIGMAS: Final = 6.0
"""Odometry noise within the bounds of its space [sd]: exceeded once in 5e8 readings."""
BOUND_MARGIN: Final = 1.01
"""Room in the bounds for what a body moves beyond its command [1]. Ours: rounding."""

Range32 = NDArray[np.float32]


class Laser:
    """A laser on a robot: exact ranges plus Gaussian noise.

    Args:
        caster: the segments it sees, and which doors are shut.
        spec: the fan of beams, the noise, and where the laser sits on the robot.
    """

    def __init__(self, caster: RayCaster, spec: LaserSpec) -> None:
        self._caster = caster
        self._spec = spec
        self._range_max, self._sd = float(spec.range_max), float(spec.sd)
        self._centred = spec.mount == (0.0, 0.0, 0.0)

    def scan(self, robot_pose: Pose, rng: np.random.Generator) -> Range32:
        """One scan from where the robot truly is.

        The noise is a compiled stream of its own, keyed by one raw draw from ``rng``.

        Returns:
            (beams,) float32, metres, a fresh array: a beam without return reads exactly
            ``range_max`` (as float32), the others are clipped to [0, range_max] after noise.
        """
        spec = self._spec
        pose = robot_pose if self._centred else robot_pose @ spec.robot_from_laser
        key = rng.bit_generator.random_raw() >> 1  # Signed, for one compiled version.
        return noisy_ranges(self._caster.ranges(pose, spec), self._range_max, self._sd, key)


def laser_spec(value: LaserSpec | Mapping[str, Any] | None) -> LaserSpec:
    """Read a laser from the keyword of an environment.

    Args:
        value: a spec, a mapping of its fields (those not named keep their defaults), or
            None for the default laser.

    Raises:
        ValueError: naming the field that is unknown or wrong.
    """
    if value is None:
        return LaserSpec()
    if isinstance(value, LaserSpec):
        return value
    given = known_fields(value, LaserSpec)
    for name, item in given.items():
        if name == "mount":
            if not isinstance(item, list | tuple) or len(item) != 3:
                raise ValueError(f"LaserSpec.mount: expected [x, y, theta], got {item!r}")
            given[name] = tuple(number_of(part, "LaserSpec.mount") for part in item)
        elif name == "beams":
            if isinstance(item, bool) or not isinstance(item, Integral):
                raise ValueError(f"LaserSpec.beams: expected an int, got {item!r}")
            given[name] = int(item)
        else:
            given[name] = number_of(item, f"LaserSpec.{name}")
    return LaserSpec(**given)


@dataclass(frozen=True, slots=True)
class OdometrySpec:
    """How far the wheels mislead, for a turn of 15 degrees and a drive of 1.5 m.

    With turn t, distance d and ``k = (|t| / 15 deg + |d| / 1.5 m) / 2``, the turn is wrong by
    N(s turn_bias k, turn_sd^2 k) and the distance by
    N(s' distance_bias d, (1.5 m distance_sd)^2 |d| / 1.5 m), where the signs s and s' are
    drawn once an episode.
    """

    distance_sd: float
    """Standard deviation of a drive of 1.5 m, as a part of it [1]."""
    turn_sd: float
    """Standard deviation of the turn at k = 1 [rad]."""
    distance_bias: float
    """Size of the constant error of distance, as a part of it [1]."""
    turn_bias: float
    """Size of the constant error of the turn at k = 1 [rad]."""

    def __post_init__(self) -> None:
        """Check the fields.

        Raises:
            ValueError: naming the field that is out of bounds.
        """
        for field in fields(self):
            value = number_of(getattr(self, field.name), f"OdometrySpec.{field.name}")
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(
                    f"OdometrySpec.{field.name}: expected a finite number >= 0, got {value!r}"
                )

    @classmethod
    def of(cls, value: str | Mapping[str, Any] | OdometrySpec) -> OdometrySpec:
        """Read odometry from the keyword of an environment.

        Args:
            value: the name of a level, a mapping of all four fields (angles in radians), or
                a spec.

        Raises:
            ValueError: naming the level or the field that is unknown, missing or wrong.
        """
        if isinstance(value, OdometrySpec):
            return value
        if isinstance(value, str):
            if value not in ODOMETRY_LEVELS:
                raise ValueError(
                    f"odometry: expected a level of {sorted(ODOMETRY_LEVELS)}, got {value!r}"
                )
            return ODOMETRY_LEVELS[value]
        return cls(**known_fields(value, cls))


def _level(
    distance_sd: float, turn_sd: float, distance_bias: float, turn_bias: float
) -> OdometrySpec:
    """A level from the table of DESIGN 3: parts of the distance, and degrees."""
    return OdometrySpec(distance_sd, math.radians(turn_sd), distance_bias, math.radians(turn_bias))


ODOMETRY_LEVELS: Final[dict[str, OdometrySpec]] = {
    "perfect": _level(0.0, 0.0, 0.0, 0.0),
    "low": _level(0.01, 0.5, 0.0, 0.1),
    "medium": _level(0.02, 1.0, 0.01, 0.25),
    "high": _level(0.035, 2.0, 0.015, 0.4),
    "severe": _level(0.05, 3.0, 0.02, 0.6),
}
"""The odometry levels by name. DESIGN 3."""


class Odometer:
    """The wheel odometry of one episode.

    Args:
        spec: its errors.
        rng: source of all its noise; the signs of the biases are drawn at once.
    """

    def __init__(self, spec: OdometrySpec, rng: np.random.Generator) -> None:
        self._spec = spec
        self._rng = rng
        self._turn_sign, self._distance_sign = (1.0 - 2.0 * rng.integers(2, size=2)).tolist()

    def measure(self, turn: float, distance: float) -> Pose:
        """What the wheels report of a turn followed by a drive.

        Args:
            turn: true turn [rad], not wrapped.
            distance: true drive after it [m], negative backwards.

        Returns:
            The measured turn, then the measured drive, in the robot's previous frame.
        """
        turn_error, distance_error = self._errors(turn, distance)
        turn, distance = turn + turn_error, distance + distance_error
        return Pose(distance * math.cos(turn), distance * math.sin(turn), wrap_angle(turn))

    def measure_velocity(self, dx: float, dy: float, dtheta: float) -> Pose:
        """What the wheels report of one small step of driving along an arc.

        The distance is the chord's, negative where it leads backwards; a step shows half
        its turn's error before the drive and half after it.

        Args:
            dx: true motion ahead, in the robot's previous frame [m].
            dy: true motion to the left [m].
            dtheta: true turn [rad].
        """
        ahead = dx * math.cos(dtheta / 2.0) + dy * math.sin(dtheta / 2.0)
        distance = math.copysign(math.hypot(dx, dy), ahead)
        turn_error, distance_error = self._errors(dtheta, distance)
        scale = 1.0 + distance_error / distance if distance else 0.0
        half_error = Pose(0.0, 0.0, turn_error / 2.0)
        return half_error @ Pose(dx * scale, dy * scale, dtheta) @ half_error

    def _errors(self, turn: float, distance: float) -> tuple[float, float]:
        """Draw the errors of a turn [rad] and a drive [m]; see OdometrySpec."""
        spec = self._spec
        turn_draw, distance_draw = self._rng.standard_normal(2).tolist()
        k = _effort(turn, distance)
        return (
            self._turn_sign * spec.turn_bias * k + spec.turn_sd * math.sqrt(k) * turn_draw,
            self._distance_sign * spec.distance_bias * distance
            + _distance_sd(spec, distance) * distance_draw,
        )


def odometry_bound(robot: RobotSpec, spec: OdometrySpec) -> tuple[float, float, float]:
    """Largest |dx|, |dy| [m] and |dtheta| [rad] that are ever reported.

    Noise beyond ``BOUND_SIGMAS`` is clipped; see ``odometry_reading``.
    """
    if robot.control == "move":
        turn, distance = robot.max_turn, robot.max_forward
    else:
        turn = robot.max_turn_rate * robot.velocity_step
        distance = robot.max_speed * robot.velocity_step
    k = _effort(turn, distance)
    turn += spec.turn_bias * k + BOUND_SIGMAS * spec.turn_sd * math.sqrt(k)
    distance += spec.distance_bias * distance + BOUND_SIGMAS * _distance_sd(spec, distance)
    return distance * BOUND_MARGIN, distance * BOUND_MARGIN, min(turn * BOUND_MARGIN, math.pi)


def odometry_reading(motion: Pose, bound: tuple[float, float, float]) -> Range32:
    """The observation of a measured motion: (dx, dy, dtheta) float32, within ``bound``."""
    limit = np.array(bound, dtype=np.float32)
    return np.clip(np.array((motion.x, motion.y, motion.theta), dtype=np.float32), -limit, limit)


def _effort(turn: float, distance: float) -> float:
    """The k of OdometrySpec: how large a motion is beside the typical one."""
    return (abs(turn) / TYPICAL_TURN + abs(distance) / TYPICAL_DISTANCE) / 2.0


def _distance_sd(spec: OdometrySpec, distance: float) -> float:
    """Standard deviation of the measured distance [m]."""
    return TYPICAL_DISTANCE * spec.distance_sd * math.sqrt(abs(distance) / TYPICAL_DISTANCE)
