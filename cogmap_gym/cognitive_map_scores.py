"""How a remembered map agrees with the truth, by the measures of the study of cognitive maps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cogmap_gym.geometry import Array, Points, Pose, wrap_angle

FEWEST_PLACES = 3
"""Fewest places for a bidimensional regression: with two, four numbers fit four [-]."""
POINTED_M = 1.0
"""Nearer than this a place has no bearing to point at [m]. Ours: it has been reached."""


@dataclass(frozen=True, slots=True)
class Regression:
    """A Euclidean bidimensional regression of remembered on true places."""

    scale: float
    """How large the remembered map is against the true one [-]; 1 is right."""
    turn: float
    """By how much it is turned against the true one [rad]."""
    distortion: float
    """Distortion index [%]: what scale, turn and shift leave unexplained, 0 to 100."""


def bidimensional_regression(remembered: Points, true: Points) -> Regression | None:
    """How a remembered map of places is scaled, turned and distorted.

    Euclidean regression with the true places as the independent variable: W. R. Tobler,
    "Bidimensional regression", Geographical Analysis 26, 1994. The distortion index is
    100 sqrt(1 - r^2), D over its largest possible value: D. Waterman and D. Gordon, "A
    quantitative-comparative approach to analysis of distortion in mental maps", Professional
    Geographer 36, 1984; A. Friedman and B. Kohler, "Bidimensional regression: assessing the
    configural similarity and accuracy of cognitive maps and other two-dimensional data sets",
    Psychological Methods 8, 2003.

    Args:
        remembered: (N, 2), in any frame [m].
        true: (N, 2), row by row the same places in the plan's frame [m].

    Returns:
        None with fewer than three places, or where all places of one map are one point.
    """
    if len(true) < FEWEST_PLACES:
        return None
    a, b = true - true.mean(axis=0), remembered - remembered.mean(axis=0)
    spread, total = float((a**2).sum()), float((b**2).sum())
    if spread == 0.0 or total == 0.0:
        return None
    cosine = float((a * b).sum()) / spread
    sine = float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / spread
    scale = math.hypot(cosine, sine)
    left = max(0.0, 1.0 - scale**2 * spread / total)
    return Regression(scale, math.atan2(sine, cosine), 100.0 * math.sqrt(left))


def pointing_errors(
    believed: Pose, remembered: Mapping[int, Points], true: Pose, places: Mapping[int, Points]
) -> dict[int, float]:
    """By how much a robot that points to places from where it is points wrong.

    The judgement of relative direction of way-finding studies: T. Ishikawa and D. R. Montello,
    "Spatial knowledge acquisition from direct experience in the environment", Cognitive Psychology
    52, 2006.

    Args:
        believed: its pose in its own frame.
        remembered: by mark, where it believes places to be in that frame, (2,) [m].
        true: its true pose.
        places: by mark, where they truly are, (2,) [m].

    Returns:
        By mark, the angle between the true bearing and the believed one, 0 to pi [rad]; without
        those it has forgotten, and those truly or believed nearer than 1 m.
    """
    found = {}
    for mark in sorted(set(remembered) & set(places)):
        pointed, right = (
            believed.inverse().apply(remembered[mark]),
            true.inverse().apply(places[mark]),
        )
        if min(np.hypot(*pointed), np.hypot(*right)) >= POINTED_M:
            found[mark] = abs(wrap_angle(_bearing(pointed) - _bearing(right)))
    return found


def _bearing(point: Array) -> float:
    return math.atan2(float(point[1]), float(point[0]))
