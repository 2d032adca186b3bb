"""Scores of a sequence of poses against corrected ones, for recordings without a truth.

A corrected pose comes from a SLAM system, in its own frame. So relative poses are compared,
or positions after one rigid fit. Everywhere ``poses`` (T, 3) are the poses to score,
``reference`` (R, 3) the corrected ones in the order of the recording, and ``ref_index``
(T,) the row of the reference that belongs to each pose, increasing. Poses are x, y [m],
theta [rad]. Travel is the length of the corrected path.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, Points, Pose, relative_poses

Indices = NDArray[np.int64]
KEY_SPACING = 0.5
"""Travel from one key pose to the next [m]; the measure of the first trials on these logs."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseTable:
    """Poses of some scans of a log."""

    scan_index: Indices
    """0-based index among the log's laser messages, increasing, shape (R,)."""
    poses: Array
    """x, y [m], theta [rad], shape (R, 3)."""


def read_corrected(path: str | Path) -> PoseTable:
    """Read poses from a CSV file with the columns ``scan_index, x, y, theta``; others are ignored.

    Raises:
        ValueError: a column is missing, a value is no finite number, an index does not
            increase, or there is no row; it names the file, the line and the column.
        OSError: the file cannot be opened.
    """
    index: list[int] = []
    poses: list[list[float]] = []
    with Path(path).open(newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        for name in ("scan_index", "x", "y", "theta"):
            if name not in (rows.fieldnames or ()):
                raise ValueError(f"{path}, line 1: expected a column {name}, got {rows.fieldnames}")
        for row in rows:
            where = f"{path}, line {rows.line_num}"
            number = _finite(row["scan_index"], f"{where}, scan_index")
            if number != int(number) or number <= (index[-1] if index else -1):
                raise ValueError(f"{where}, scan_index: expected whole, increasing, got {number}")
            index.append(int(number))
            poses.append([_finite(row[name], f"{where}, {name}") for name in ("x", "y", "theta")])
    if not poses:
        raise ValueError(f"{path}: expected at least one row of poses, got none")
    return PoseTable(np.array(index, dtype=np.int64), np.array(poses))


def travel_lengths(poses: Array) -> Array:
    """Length of the path from the first pose to each [m], shape (N,)."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return np.concatenate(((0.0,), np.cumsum(steps)))


def relative_errors(
    poses: Array, reference: Array, ref_index: Indices, travel: float = 10.0
) -> Array:
    """Errors of the motion over a given travel: how well the shape of the path is kept.

    For each pose i, j is the first pose at least ``travel`` later. The error is the distance
    between the translations of ``inverse(pose_i) @ pose_j`` and of its reference.

    Returns:
        (K,) errors [m], one for each pose that has a j, in order.
    """
    travelled = travel_lengths(reference)[ref_index]
    later = np.searchsorted(travelled, travelled + travel)
    first = np.flatnonzero(later < len(travelled))
    return _pair_errors(poses, reference[ref_index], first, later[first])[0]


def key_rows(reference: Array, ref_index: Indices, spacing: float = KEY_SPACING) -> Indices:
    """The rows of the scored poses that are key poses: one per ``spacing`` of travel [m]."""
    kept: list[int] = []
    last = -math.inf
    for row, travelled in enumerate(travel_lengths(reference)[ref_index]):
        if travelled - last >= spacing:
            kept.append(row)
            last = travelled
    return np.array(kept, dtype=np.int64)


def adjacent_errors(
    poses: Array, reference: Array, ref_index: Indices, spacing: float = KEY_SPACING
) -> tuple[Array, Array]:
    """Errors of the motion from each key pose to the next.

    Returns:
        Two arrays (K - 1,): errors of the translation [m] and of the turn [rad], >= 0.
    """
    keys = key_rows(reference, ref_index, spacing)
    return _pair_errors(poses, reference[ref_index], keys[:-1], keys[1:])


def revisit_errors(
    poses: Array,
    reference: Array,
    ref_index: Indices,
    radius: float = 2.0,
    travel: float = 20.0,
    spacing: float = KEY_SPACING,
) -> Array:
    """Errors where the robot comes back to a place: whether the map is one map.

    All pairs of key poses are taken whose corrected positions are nearer than ``radius``
    [m] and more than ``travel`` [m] apart along the path.

    Returns:
        (K,) errors of the relative translation [m].
    """
    keys = key_rows(reference, ref_index, spacing)
    true = reference[ref_index]
    travelled = travel_lengths(reference)[ref_index][keys]
    errors = [np.zeros(0)]
    for k, row in enumerate(keys):
        near = np.hypot(*(true[keys, :2] - true[row, :2]).T) < radius
        again = keys[near & (travelled > travelled[k] + travel)]
        errors.append(_pair_errors(poses, true, np.full(len(again), row), again)[0])
    return np.concatenate(errors)


def rigid_fit(source: Points, target: Points) -> Pose:
    """The rigid motion that lays points on their partners with the least squared distance.

    Umeyama's method (IEEE PAMI 13(4), 1991) in the plane, without scale: a closed form.

    Args:
        source: (N, 2), N >= 1.
        target: (N, 2), row by row the partners.

    Returns:
        ``target_from_source``; no turn where the points do not tell one.
    """
    centre, goal = source.mean(axis=0), target.mean(axis=0)
    a, b = source - centre, target - goal
    sine = float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    cosine = float((a * b).sum())
    turn = Pose(0.0, 0.0, math.atan2(sine, cosine))
    x, y = goal - turn.apply(centre)
    return Pose(float(x), float(y), turn.theta)


def absolute_errors(poses: Array, reference: Array, ref_index: Indices) -> Array:
    """Distances to the corrected positions after one rigid fit [m], shape (T,) (ATE)."""
    true = reference[ref_index, :2]
    fitted = rigid_fit(poses[:, :2], true).apply(poses[:, :2])
    return np.asarray(np.hypot(*(fitted - true).T))


@dataclass(frozen=True, slots=True)
class LogScore:
    """The scores of one sequence of poses in one line; NaN where no pair is long enough."""

    relative: float
    """Mean error of the motion over 10 m of travel [m]."""
    key_metres: float
    """Mean error of the motion between adjacent key poses [m]."""
    key_degrees: float
    """Mean error of the turn between adjacent key poses [deg]."""
    revisit_mean: float
    """Mean error between visits of the same place [m]."""
    revisit_median: float
    """Median error between visits of the same place [m]."""
    absolute: float
    """Mean distance to the corrected positions after one rigid fit [m]."""

    def __str__(self) -> str:
        """All scores, with their units."""
        return (
            f"{self.relative:.3f} m over 10 m | key poses {self.key_metres:.3f} m"
            f" / {self.key_degrees:.1f} deg | revisits mean {self.revisit_mean:.2f},"
            f" median {self.revisit_median:.2f} m | after a rigid fit {self.absolute:.2f} m"
        )


def score_poses(poses: Array, reference: Array, ref_index: Indices) -> LogScore:
    """Score poses by every measure of this module, at its default distances."""
    scored = (poses, reference, ref_index)
    metres, radians = adjacent_errors(*scored)
    revisits = revisit_errors(*scored)
    return LogScore(
        _mean(relative_errors(*scored)),
        _mean(metres),
        math.degrees(_mean(radians)),
        _mean(revisits),
        float(np.median(revisits)) if revisits.size else math.nan,
        _mean(absolute_errors(*scored)),
    )


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else math.nan


def _pair_errors(
    poses: Array, reference: Array, first: Indices, second: Indices
) -> tuple[Array, Array]:
    motions = relative_poses(poses[first], poses[second])
    wanted = relative_poses(reference[first], reference[second])
    turn_errors = np.abs(relative_poses(wanted, motions)[:, 2])
    return np.hypot(*(motions - wanted)[:, :2].T), turn_errors


def _finite(word: str | None, where: str) -> float:
    try:
        value = float(word or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{where}: expected a finite number, got {word!r}")
    return value
