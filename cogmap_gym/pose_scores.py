"""How well a robot knows where it is, over a whole trial."""

from __future__ import annotations

import math

import numpy as np

from cogmap_gym.geometry import Array
from cogmap_gym.log_metrics import absolute_errors, relative_errors

RPE_M = 10.0
"""Travel over which relative errors are taken [m]."""


def pose_scores(believed: Array, true: Array) -> dict[str, float | None]:
    """ATE and RPE of the poses believed at each moment, each as a root mean square [m].

    J. Sturm, N. Engelhard, F. Endres, W. Burgard and D. Cremers, "A benchmark for the evaluation
    of RGB-D SLAM systems", IROS 2012. ATE after one rigid fit; RPE of the translation, between
    poses 10 m of travel apart. A pose counts as it was believed at the time, not as the robot
    mended its past later.

    Args:
        believed: (T, 3), in any frame.
        true: (T, 3), row by row the true poses.

    Returns:
        ``ate``, and ``rpe``, None where the way was shorter than 10 m.
    """
    rows = np.arange(len(true))
    return {
        "ate": _root_mean_square(absolute_errors(believed, true, rows)),
        "rpe": _root_mean_square(relative_errors(believed, true, rows, RPE_M)),
    }


def _root_mean_square(errors: Array) -> float | None:
    return math.sqrt(float((errors**2).mean())) if len(errors) else None
