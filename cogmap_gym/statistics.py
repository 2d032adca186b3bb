"""Honest figures of few trials: interquartile means, bootstrap intervals, who beats whom.

After Agarwal, Schwarzer, Castro, Courville and Bellemare, "Deep Reinforcement Learning at the Edge
of the Statistical Precipice", NeurIPS 2021. Scores come by stratum, the map they were won on: an
interval resamples within each map, so that hard and easy maps keep their share.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import stats

from cogmap_gym.geometry import Array

Strata = Sequence[Array]
"""The scores of one robot, an array (n,) a map."""
RESAMPLES = 2_000
"""Of a bootstrap [-]. Agarwal et al. 2021 use as many."""
CONFIDENCE = 0.95
"""Of an interval [-]."""
TRIM = 0.25
"""Share of the scores cut off at each end [-]. Agarwal et al. 2021: the middle half counts."""


def interquartile_mean(scores: Array) -> float:
    """The mean of the middle half of the scores (n,); NaN without a score."""
    return float(stats.trim_mean(scores, TRIM)) if len(scores) else float("nan")


def interquartile_mean_of(strata: Strata) -> float:
    """The interquartile mean over the scores of all maps."""
    return interquartile_mean(np.concatenate(strata))


def bootstrap(
    strata: Strata,
    statistic: Callable[[Strata], float],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """The stratified percentile interval of a statistic.

    Args:
        strata: scores by map; a map without any takes no part.
        statistic: of scores by map.
        rng: chance.
        resamples: how often the scores are drawn anew.

    Returns:
        Its lower and upper bound; NaN without a score.
    """
    held = [scores for scores in strata if len(scores)]
    if not held:
        return float("nan"), float("nan")
    drawn = [statistic([rng.choice(x, len(x)) for x in held]) for _ in range(resamples)]
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(drawn, (tail, 1.0 - tail))
    return float(low), float(high)


def paired_difference(
    ours: Strata, theirs: Strata, rng: np.random.Generator, resamples: int = RESAMPLES
) -> tuple[float, float, float]:
    """How much better one robot did than another on the same trials.

    Args:
        ours: scores by map.
        theirs: scores of the same trials, in the same order.
        rng: chance.
        resamples: of the bootstrap.

    Returns:
        The mean difference, and the lower and upper bound of its interval.

    Raises:
        ValueError: the trials are not the same.
    """
    if [len(x) for x in ours] != [len(x) for x in theirs]:
        raise ValueError("paired difference: expected as many scores of both robots on each map")
    apart = [a - b for a, b in zip(ours, theirs, strict=True)]
    if not sum(len(x) for x in apart):
        return float("nan"), float("nan"), float("nan")
    return _mean(apart), *bootstrap(apart, _mean, rng, resamples)


def probability_of_improvement(ours: Strata, theirs: Strata) -> float:
    """How likely one robot beats another on a map drawn at random; a draw counts half.

    The mean over the maps of Mann and Whitney's U over the number of pairs (Agarwal et al. 2021,
    section 4.3). NaN where no map has scores of both.
    """
    shares = []
    for a, b in zip(ours, theirs, strict=True):
        if len(a) and len(b):
            gap = a[:, None] - b[None]
            shares.append(float((gap > 0.0).mean() + 0.5 * (gap == 0.0).mean()))
    return float(np.mean(shares)) if shares else float("nan")


def _mean(strata: Strata) -> float:
    return float(np.concatenate(strata).mean())
