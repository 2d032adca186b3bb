"""Scores of one trial of any robot in any task, from the truth alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import Any

import numpy as np

from cogmap_gym.geometry import Array

CURVE_POINTS = 21
"""Points of a coverage curve, evenly over the budget of moves [-]."""
TOURS = 4.0
"""A coverage curve against distance goes to so many lengths of the oracle's tour [-]. Ours."""
LEAST_HORIZON_M = 10.0
"""... and at least so far, where all is seen from home [m]. Ours."""
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


def horizon(tour: float) -> float:
    """Up to which distance coverage is told on a plan, the same for all robots [m].

    Args:
        tour: length of the oracle's tour [m].
    """
    return max(TOURS * tour, LEAST_HORIZON_M)


def distance_curve(seen: Array, driven: Array, far: float, points: int = CURVE_POINTS) -> Array:
    """The share seen by the time that so far was driven, (points,), evenly from 0 to ``far``.

    Args:
        seen: (T,), the share seen at each move.
        driven: (T,), metres driven by then.
        far: the horizon [m].
        points: of the curve.
    """
    rows = np.searchsorted(driven, np.linspace(0.0, far, points), side="right") - 1
    return np.asarray(seen[np.maximum(rows, 0)])


def distance_area(seen: Array, driven: Array, far: float) -> float:
    """The area under the share seen against the distance driven, over the horizon: 0 to 1.

    What a robot has seen it has seen; one that stops keeps its share. So the mean over distance of
    a step function (the "coverage AUC" of exploration benchmarks, as D. S. Chaplot, D. Gandhi, S.
    Gupta, A. Gupta and R. Salakhutdinov, "Learning to explore using active neural SLAM", ICLR 2020,
    plot it over steps).

    Args:
        seen: (T,), the share seen at each move.
        driven: (T,), metres driven by then.
        far: the horizon [m].

    Raises:
        ValueError: a horizon that is not above 0.
    """
    if not far > 0.0:
        raise ValueError(f"distance area: expected metres above 0, got {far!r}")
    edges = np.append(np.minimum(driven, far), far)
    return float((seen * np.diff(edges)).sum() / far)


def distance_to(share: float, seen: Array, driven: Array) -> float | None:
    """Metres driven until a share was seen; None if it never was.

    Args:
        share: of the free area.
        seen: (T,), the share seen at each move.
        driven: (T,), metres driven by then.
    """
    return float(driven[int(np.argmax(seen >= share))]) if seen[-1] >= share else None


def goal_scores(
    phases: Sequence[Mapping[str, Any]], info: Mapping[str, Any], marks: Sequence[int]
) -> dict[str, Any]:
    """Scores over the goals of an episode; None where it has none.

    Args:
        phases: as in ``Episode.phases``, those with a goal that are over, in order.
        info: the last ``info``.
        marks: that of every goal of the episode, in order. One whose phase never came to its end
            is missed.
    """
    if not marks:
        return dict.fromkeys(("goals", "goals_met", "spl", "spl_learning", "soft_spl"))
    far = info["final_distance"]
    soft = [
        0.0 if phase is None else _soft(phase, float(far[mark]))
        for mark, phase in zip_longest(marks, phases)
    ]
    return {
        "goals": len(marks),
        "goals_met": sum(bool(phase["success"]) for phase in phases),
        "spl": _mean_share(info["spl"], marks),
        "spl_learning": _mean_share(info["spl_learning"], marks),
        "soft_spl": float(np.mean(soft)),
    }


def _soft(phase: Mapping[str, Any], final: float) -> float:
    """Soft SPL; where there is no way, whether the robot said so."""
    if phase["oracle_length"] <= 0.0:
        return float(phase["success"])
    return soft_spl(phase["oracle_length"], phase["path_length"], final)


def _mean_share(scores: Array, marks: Sequence[int]) -> float:
    """The mean over the goals; one that was never begun, or that has no way, counts nothing."""
    return float(np.maximum(scores[list(marks)], 0.0).mean())
