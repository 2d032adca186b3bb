"""Laser logs in CARMEN's text format: recordings of real robots.

A log has one message a line: its name, its words, then ``ipc_timestamp host
logger_timestamp``. Two messages carry a scan, and only they are read:

``FLASER n r_1..r_n  x y theta  odom_x odom_y odom_theta  ...``
    The fan is not stated. CARMEN's convention: beam 0 points to the robot's right
    (-90 deg) and beams run counter-clockwise over 180 degrees. An odd count has a beam at
    both ends (181: 1 deg, 361: 0.5 deg); an even count leaves the last end out (180: 1 deg,
    -90..+89; 360: 0.5 deg).
``ROBOTLASER1 type start fov step max_range accuracy remission_mode n r_1..r_n m s_1..s_m
laser_x y theta  robot_x y theta  laser_tv laser_rv forward side axis  ...``
    The fan is stated, in the laser's frame.
"""

from __future__ import annotations

import gzip
import math
import re
import zlib
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, relative_poses, wrap_angle
from cogmap_gym.observation import LaserSpec

SICK_NO_RETURN = 81.83
"""Smallest code by which a SICK LMS says that it measured nothing [m]. SICK LMS-2xx telegrams."""
SICK_LARGEST = 81.92
"""First value beyond the 13-bit distances of a SICK LMS [m]. SICK LMS-2xx telegrams."""
MOUNT_SPREAD = 0.02
"""Two poses of a message are one rigid body if nine in ten agree so well [m and rad]."""
MOUNT_REACH = 1.0
"""A laser further than this from the robot's centre is no laser of the robot [m]."""
_MOUNT_NOTE = re.compile(r"laser (-?\d+(?:\.\d+)?) m ahead")


@dataclass(frozen=True, slots=True, eq=False)
class LaserLog:
    """The scans of one recording with the wheel odometry; row t belongs to laser message t."""

    laser: LaserSpec
    """The fan, the range that means "no return", and where the laser sits on the robot."""
    scans: NDArray[np.float32]
    """Ranges [m], shape (T, beams); no return reads ``laser.range_max``."""
    poses_odometry: Array
    """Raw odometry of the robot's centre in the frame of the log: x, y [m], theta [rad], (T, 3)."""
    times: Array
    """Time stamp of each scan [s], shape (T,)."""

    def motions(self, indices: NDArray[np.int64] | None = None) -> Array:
        """Measured motion since the previous scan, in the previous frame of the robot.

        Args:
            indices: scans that are used, in order; all of them when left out.

        Returns:
            (T, 3) or (len(indices), 3): dx, dy [m], dtheta [rad]; the first row is zero.
        """
        poses = self.poses_odometry if indices is None else self.poses_odometry[indices]
        return np.vstack((np.zeros((1, 3)), relative_poses(poses[:-1], poses[1:])))

    def every(self, metres: float, radians: float) -> NDArray[np.int64]:
        """The scans kept when one is taken per given motion, the first always.

        A scan is kept once the odometry since the last kept one comes to ``metres`` or to
        ``radians``; what was passed over is in the motion to the next kept scan.

        Raises:
            ValueError: a motion is negative or NaN.
        """
        if not (metres >= 0.0 and radians >= 0.0):
            raise ValueError(f"every: expected motions >= 0, got {metres} m and {radians} rad")
        kept: list[int] = [0]
        x, y, theta = self.poses_odometry[0]
        for t, pose in enumerate(self.poses_odometry[1:], start=1):
            moved = math.hypot(pose[0] - x, pose[1] - y)
            if moved >= metres or abs(wrap_angle(pose[2] - theta)) >= radians:
                kept.append(t)
                x, y, theta = pose
        return np.array(kept, dtype=np.int64)


class _Message(NamedTuple):
    fan: tuple[float, float, int, float]
    """First angle, step [rad], beams, and the stated largest range (infinite: not stated) [m]."""
    ranges: list[float]
    poses_and_time: list[float]
    """Pose of the laser, pose of the robot, time stamp: 7 numbers."""


@dataclass(slots=True)
class _Rows:
    """What was read so far, in compact columns."""

    kind: str = ""
    fan: tuple[float, float, int, float] | None = None
    mount_note: float = 0.0
    ranges: array[float] = field(default_factory=lambda: array("f"))
    poses_and_times: array[float] = field(default_factory=lambda: array("d"))

    def add(self, line: str) -> None:
        """Take in one line; anything but a laser message of the first kind met is passed over."""
        kind = line.split(maxsplit=1)[0] if line.strip() else ""
        if kind.startswith("#") and (note := _MOUNT_NOTE.search(line)):
            self.mount_note = float(note.group(1))
        if kind not in _PARSERS or kind != (self.kind or kind):
            return
        message = _PARSERS[kind](line.split())
        if message.fan != (self.fan or message.fan):
            names = "first angle, step, beams, maximum"
            raise ValueError(f"{kind} ({names}): expected {self.fan}, as before, got {message.fan}")
        self.kind, self.fan = kind, message.fan
        self.ranges.extend(message.ranges)
        self.poses_and_times.extend(message.poses_and_time)


def read_carmen(path: str | Path) -> LaserLog:
    """Read a CARMEN log, ``.clf`` or ``.log``, plain or with ``.gz``, line by line.

    The first kind of laser message met counts; every other message, ``PARAM`` and comments
    are passed over. A reading at the maximum means "no return": the maximum is the stated
    one (ROBOTLASER1) or the largest of the file (FLASER), and for a SICK any of its error
    codes. Readings that are negative or not finite mean the same.

    The laser's place on the robot is the first pose of the messages as seen from the
    second, where that is the same throughout. Where it wanders, the first pose is another
    program's correction and the laser is taken to be at the centre. Where both are equal,
    a comment of the words "laser 0.25 m ahead" is believed.

    Raises:
        ValueError: no laser message, a message with a wrong number of words or with words
            that are no numbers, a fan that changes, odometry that is not finite, or a
            broken gzip file; it names the file, the line and the field.
        OSError: the file cannot be opened.
    """
    path, rows, number = Path(path), _Rows(), 0
    try:
        opener: Callable[..., IO[str]] = gzip.open if path.suffix == ".gz" else open
        with opener(path, "rt", encoding="utf-8", errors="replace") as lines:
            for line in lines:
                number += 1
                rows.add(line)
        return _assemble(rows)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise ValueError(f"{path}, after line {number}: broken gzip file ({error})") from error
    except ValueError as error:
        raise ValueError(f"{path}, line {number}: {error}") from error


def _parse_flaser(words: list[str]) -> _Message:
    beams = _count(words, 1, "FLASER num_readings", at_least=2)
    _expect_words(words, beams + 11)
    fan = (-math.pi / 2.0, math.pi / (beams - beams % 2), beams, math.inf)
    return _Message(fan, _readings(words, 2, beams), _numbers(words, 2 + beams, _FLASER_TAIL))


def _parse_robotlaser1(words: list[str]) -> _Message:
    beams = _count(words, 8, "ROBOTLASER1 num_readings", at_least=2)
    remissions = _count(words, 9 + beams, "ROBOTLASER1 num_remissions")
    _expect_words(words, beams + remissions + 24)
    first, fov, step, stated = _numbers(words, 2, _ROBOTLASER1_FAN)
    tail = _numbers(words, 10 + beams + remissions, _ROBOTLASER1_TAIL)
    fan = (first, step or fov / (beams - 1), beams, stated if stated > 0.0 else math.inf)
    return _Message(fan, _readings(words, 9, beams), [*tail[:6], tail[11]])


def _count(words: list[str], at: int, name: str, at_least: int = 0) -> int:
    word = words[at] if at < len(words) else "the end of the line"
    if not word.isdecimal() or int(word) < at_least:
        raise ValueError(f"{name}: expected a whole number >= {at_least}, got {word}")
    return int(word)


def _expect_words(words: list[str], expected: int) -> None:
    if len(words) != expected:
        raise ValueError(f"{words[0]} num_readings: expected {expected} words, got {len(words)}")


def _number(word: str, name: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise ValueError(f"{name}: expected a number, got {word!r}") from None


def _readings(words: list[str], first: int, beams: int) -> list[float]:
    try:
        return [float(word) for word in words[first : first + beams]]
    except ValueError:
        return [_number(words[first + i], f"{words[0]} reading {i}") for i in range(beams)]


def _numbers(words: list[str], first: int, names: Sequence[str]) -> list[float]:
    values = []
    for word, name in zip(words[first:], names, strict=False):
        values.append(_number(word, f"{words[0]} {name}"))
        if not math.isfinite(values[-1]):
            raise ValueError(f"{words[0]} {name}: expected a finite number, got {word}")
    return values


def _assemble(rows: _Rows) -> LaserLog:
    if rows.fan is None:
        raise ValueError(f"expected a laser message ({' or '.join(_PARSERS)}), got none")
    first_angle, step, beams, stated = rows.fan
    scans = np.frombuffer(rows.ranges, dtype=np.float32).reshape(-1, beams).copy()
    range_max = _no_return(scans, stated)
    scans[~((scans >= 0.0) & (scans < range_max))] = range_max
    numbers = np.frombuffer(rows.poses_and_times).reshape(-1, 7).copy()
    mount = _mount(numbers[:, 3:6], numbers[:, :3], rows.mount_note)
    laser = LaserSpec(first_angle, step, beams, range_max, mount=mount)
    return LaserLog(laser, scans, numbers[:, 3:6], numbers[:, 6])


def _no_return(scans: NDArray[np.float32], stated: float) -> float:
    """The smallest reading that means "no return" [m], a number that float32 holds exactly."""
    largest = float(np.max(scans, initial=0.0, where=np.isfinite(scans)))
    smallest = SICK_NO_RETURN if SICK_NO_RETURN <= largest < SICK_LARGEST else math.inf
    limit = min(stated, smallest)
    return float(np.float32(limit if math.isfinite(limit) else largest))


def _mount(robot: Array, laser: Array, noted: float) -> tuple[float, float, float]:
    """Where the laser sits on the robot, to 1 mm and 1 mrad; see ``read_carmen``."""
    robot_from_laser = relative_poses(robot, laser)
    mount = np.median(robot_from_laser, axis=0)
    off = np.abs(relative_poses(np.broadcast_to(mount, robot.shape), robot_from_laser))
    spread = np.quantile(off.max(axis=1), 0.9)
    if spread > MOUNT_SPREAD or math.hypot(mount[0], mount[1]) > MOUNT_REACH:
        return (0.0, 0.0, 0.0)
    x, y, theta = (float(value) + 0.0 for value in np.round(mount, 3))
    return (x, y, theta) if (x, y, theta) != (0.0, 0.0, 0.0) else (noted, 0.0, 0.0)


_FLASER_TAIL = ("x", "y", "theta", "odom_x", "odom_y", "odom_theta", "ipc_timestamp")
_ROBOTLASER1_FAN = ("start_angle", "fov", "angular_resolution", "max_range")
_ROBOTLASER1_TAIL = (
    *("laser x", "laser y", "laser theta", "robot x", "robot y", "robot theta"),
    *("laser_tv", "laser_rv", "forward_safety", "side_safety", "turn_axis", "timestamp"),
)
_PARSERS = {"FLASER": _parse_flaser, "ROBOTLASER1": _parse_robotlaser1}
