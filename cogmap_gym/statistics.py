"""Honest figures of few trials: interquartile means, bootstrap intervals, who beats whom.

After Agarwal, Schwarzer, Castro, Courville and Bellemare, "Deep Reinforcement Learning at the Edge
of the Statistical Precipice", NeurIPS 2021. Scores come by stratum, the map they were won on: an
interval resamples within each map, so that hard and easy maps keep their share. It tells what other
trials on these very maps would show, not what other maps would.

What is drawn is a whole trial. The goals of one trial share its robot, its map and its drift; they
are no independent trials of a coin, and Wilson's interval, which takes them for such, would be too
narrow. So a rate over goals is a cluster bootstrap (Field and Welsh, "Bootstrapping clustered
data", JRSS B 69, 2007); Wilson's serves rates of one outcome a trial.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cogmap_gym.geometry import Array
from cogmap_gym.metrics import wilson

Strata = Sequence[Array]
"""What one robot did, an array a map, its first axis the trials: scores (n,), or (n, 2), goals met
and goals asked for. A statistic of strata works along that axis, so that a bootstrap can give it
all its resamples at once, (n, resamples) or (n, resamples, 2)."""
Statistic = Callable[[Strata], Array]
Interval = tuple[float, float, float]
"""A figure, and the lower and upper bound of its interval; NaN where there is none."""
RESAMPLES = 2_000
"""Of a bootstrap [-]. Agarwal et al. 2021 use as many."""
CONFIDENCE = 0.95
"""Of an interval [-]."""
TRIM = 0.25
"""Share of the scores cut off at each end [-]. Agarwal et al. 2021: the middle half counts."""
NOTHING = float("nan"), float("nan")
"""The bounds of an interval that cannot be told."""


def interquartile_mean(scores: Array) -> float:
    """The mean of the middle half of the scores (n,); NaN without a score."""
    return float(stats.trim_mean(scores, TRIM)) if len(scores) else float("nan")


def interquartile_mean_of(strata: Strata) -> Array:
    """The interquartile mean over the scores of all maps."""
    return np.asarray(stats.trim_mean(np.concatenate(strata), TRIM, axis=0))


def share_met(counts: Strata) -> Array:
    """Goals met over goals asked for, over all maps."""
    total = np.concatenate(counts).sum(axis=0)
    return np.asarray(total[..., 0] / total[..., 1])


def mean_of(strata: Strata) -> Array:
    """The mean over all maps; of differences alone, and never without an interval."""
    return np.asarray(np.concatenate(strata).mean(axis=0))


def bootstrap(
    strata: Strata, statistic: Statistic, rng: np.random.Generator, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """The stratified percentile interval of a statistic.

    A map with a single trial tells nothing of the chance within it. Such maps make one stratum.

    Args:
        strata: by map; a map without any trial takes no part.
        statistic: of strata, along their first axis.
        rng: chance.
        resamples: how often the trials are drawn anew.

    Returns:
        Its lower and upper bound; NaN with fewer than two trials.
    """
    single = [x for x in strata if len(x) == 1]
    held = [x for x in strata if len(x) > 1] + ([np.concatenate(single)] if single else [])
    if sum(len(x) for x in held) < 2:
        return NOTHING
    return _bounds(statistic([x[_rows(len(x), resamples, rng)] for x in held]))


def interval_of(strata: Strata, statistic: Statistic, rng: np.random.Generator) -> Interval:
    """A statistic and its stratified interval; NaN without a trial."""
    if not sum(len(x) for x in strata):
        return float("nan"), *NOTHING
    return float(statistic(strata)), *bootstrap(strata, statistic, rng)


def goal_rate(counts: Strata, rng: np.random.Generator) -> Interval:
    """The share of the goals met, with the interval of a cluster bootstrap over trials.

    Where the bootstrap knows no doubt, for all trials came out alike or there is only one, the
    interval is Wilson's with a trial, not a goal, for a unit: the most cautious of its kind.

    Args:
        counts: by map, (n, 2): goals met and goals asked for of each trial.
        rng: chance.
    """
    rate, low, high = interval_of(counts, share_met, rng)
    if np.isfinite(rate) and not low < high:
        trials = sum(len(x) for x in counts)
        low, high = wilson(rate * trials, trials)
    return rate, low, high


def paired_difference(ours: Strata, theirs: Strata, rng: np.random.Generator) -> Interval:
    """How much better one robot did than another on the same trials: the mean difference.

    Args:
        ours: scores by map.
        theirs: scores of the same trials, in the same order.
        rng: chance.

    Raises:
        ValueError: the trials are not the same.
    """
    _check_pairs(ours, theirs)
    return interval_of([a - b for a, b in zip(ours, theirs, strict=True)], mean_of, rng)


def probability_of_improvement(
    ours: Strata, theirs: Strata, rng: np.random.Generator, resamples: int = RESAMPLES
) -> Interval:
    """How likely one robot beats another on a map drawn at random; a draw counts half.

    The mean over the maps of Mann and Whitney's U over the number of pairs (Agarwal et al. 2021,
    section 4.3). The interval draws trials within each map, of each robot for itself, as they do;
    where a map has a single trial, it draws maps.

    Args:
        ours: scores by map.
        theirs: scores of the same trials, in the same order.
        rng: chance.
        resamples: of the bootstrap.

    Raises:
        ValueError: the trials are not the same.
    """
    _check_pairs(ours, theirs)
    both = [(a, b) for a, b in zip(ours, theirs, strict=True) if len(a)]
    if not both:
        return float("nan"), *NOTHING
    shares = np.array([_share_won(a, b) for a, b in both])
    if min(len(a) for a, _ in both) == 1:
        return float(shares.mean()), *bootstrap([shares], mean_of, rng, resamples)
    drawn = ([x[_rows(len(x), resamples, rng)] for x in pair] for pair in both)
    every = np.mean([_share_won(a, b) for a, b in drawn], axis=0)
    return float(shares.mean()), *_bounds(every)


def _share_won(a: Array, b: Array) -> Array:
    """Share of the pairs along the first axis in which a is larger; a draw counts half."""
    gap = a[:, None] - b[None]
    return np.asarray(((gap > 0.0) + 0.5 * (gap == 0.0)).mean(axis=(0, 1)))


def _rows(count: int, resamples: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Rows drawn with replacement, (count, resamples)."""
    return rng.integers(count, size=(count, resamples))


def _bounds(drawn: Array) -> tuple[float, float]:
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(drawn, (tail, 1.0 - tail))
    return float(low), float(high)


def _check_pairs(ours: Strata, theirs: Strata) -> None:
    counts = [[len(x) for x in strata] for strata in (ours, theirs)]
    if counts[0] != counts[1]:
        raise ValueError(
            f"pairs: expected as many scores of both robots on each map, got {counts[0]} and "
            f"{counts[1]}"
        )
