"""Scores of one trial of any robot in any task, from the truth alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cogmap_gym.geometry import Array

CURVE_POINTS = 21
"""Points of a coverage curve, evenly over the budget of moves [-]."""
SHARES = (0.9, 0.95)
"""Shares of the free area whose distance is told [-]."""


def soft_spl(oracle: float, driven: float, final: float) -> float:
    """How far a goal was approached, weighted by the length of the way.

    The progress 1 - final / oracle takes the place of success in SPL (Datta, Maksymets, Hoffman,
    Lee, Batra and Parikh, "Integrating egocentric localization for more realistic point-goal
    navigation agents", CoRL 2020).

    Args:
        oracle: length of the shortest way at the start [m].
        driven: metres driven.
        final: distance to the goal at the end [m].
    """
    if oracle <= 0.0:
        return float(final <= 0.0)
    return max(0.0, 1.0 - final / oracle) * oracle / max(oracle, driven)


def coverage_curve(seen: Array, moves: int, points: int = CURVE_POINTS) -> Array:
    """The share seen at evenly spaced moves of the budget, (points,); it stays as it ended.

    Args:
        seen: (T,), the share seen at each move.
        moves: the budget.
        points: of the curve.
    """
    at = np.linspace(0, moves, points).round().astype(np.int64)
    return np.asarray(seen[np.minimum(at, len(seen) - 1)])


def curve_area(seen: Array, moves: int) -> float:
    """The mean share seen over the whole budget of moves, 0 to 1."""
    every = np.minimum(np.arange(moves + 1), len(seen) - 1)
    return float(seen[every].mean())


def distance_area(seen: Array, driven: Array, metres: float) -> float:
    """The mean share seen over the first metres of the way, 0 to 1.

    What a step shows counts from its end; a robot that stops before keeps what it has seen.

    Args:
        seen: (T,), the share seen at each move.
        driven: (T,), metres driven by then, from 0 up.
        metres: over which the mean is taken.

    Raises:
        ValueError: no metres.
    """
    if not metres > 0.0:
        raise ValueError(f"distance area: expected metres above 0, got {metres!r}")
    ends = np.append(np.minimum(driven, metres), metres)
    return float(np.sum(np.diff(ends) * seen) / metres)


def distance_to(share: float, seen: Array, driven: Array) -> float | None:
    """Metres driven until a share was seen; None if it never was.

    Args:
        share: of the free area.
        seen: (T,), the share seen at each move.
        driven: (T,), metres driven by then.
    """
    return float(driven[int(np.argmax(seen >= share))]) if seen[-1] >= share else None


def goal_scores(
    phases: Sequence[dict[str, Any]], info: dict[str, Any], marks: Sequence[int]
) -> dict[str, Any]:
    """Scores over the goals of an episode; None where it had none.

    Args:
        phases: as in ``Episode.phases``, those with a goal, in order.
        info: the last ``info``.
        marks: the mark of each.
    """
    if not phases:
        return dict.fromkeys(("goals", "goals_met", "spl", "spl_learning", "soft_spl"))
    soft = [
        soft_spl(phase["oracle_length"], phase["path_length"], float(info["final_distance"][mark]))
        if phase["oracle_length"] > 0.0
        else float(phase["success"])
        for phase, mark in zip(phases, marks, strict=True)
    ]
    return {
        "goals": len(phases),
        "goals_met": sum(bool(phase["success"]) for phase in phases),
        "spl": _mean_share(info["spl"], marks),
        "spl_learning": _mean_share(info["spl_learning"], marks),
        "soft_spl": float(np.mean(soft)),
    }


def _mean_share(scores: Array, marks: Sequence[int]) -> float:
    """The mean over the goals; one that was never begun, or that has no way, counts nothing."""
    return float(np.maximum(scores[list(marks)], 0.0).mean())
