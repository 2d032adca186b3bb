"""Lines of Markdown tables of figures: rates and means with their intervals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogmap_gym.metrics import wilson

HEAD = "| figure | seen | 95 % interval | asked |\n|---|---|---|---|\n"
RESAMPLES = 2000
"""How often groups are drawn again for the interval of a mean [-]."""


def rate_text(successes: int, trials: int) -> tuple[str, str]:
    """A rate and its Wilson interval, in words."""
    low, high = wilson(successes, trials)
    seen = f"{successes}/{trials} = {successes / trials:.1%}" if trials else "no trial"
    return seen, f"{low:.1%} to {high:.1%}" if trials else ""


def rate_line(text: str, successes: int, trials: int, asked: str = "") -> str:
    """A rate with its Wilson interval."""
    seen, interval = rate_text(successes, trials)
    return f"| {text} | {seen} | {interval} | {asked} |\n"


def value_line(text: str, seen: str, asked: str = "") -> str:
    """A figure without an interval."""
    return f"| {text} | {seen} | | {asked} |\n"


def mean_line(
    text: str, groups: Sequence[Sequence[float]], asked: str, rng: np.random.Generator
) -> str:
    """A mean with its bootstrap interval over groups; a group without values does not count."""
    filled = [group for group in groups if len(group)]
    if not filled:
        return value_line(text, "-", asked)
    low, mean, high = bootstrap_mean(filled, rng)
    return f"| {text} | {mean:.3f} | {low:.3f} to {high:.3f} | {asked} |\n"


def bootstrap_mean(
    groups: Sequence[Sequence[float]], rng: np.random.Generator
) -> tuple[float, float, float]:
    """The mean of all values, and its 95 % interval when whole groups are drawn again.

    Args:
        groups: at least one, each with at least one value.
        rng: draws the groups.

    Returns:
        Lower bound, mean, upper bound.
    """
    sums, counts = (np.array([f(g) for g in groups], dtype=np.float64) for f in (np.sum, len))
    drawn = rng.integers(len(groups), size=(RESAMPLES, len(groups)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.quantile(means, (0.025, 0.975)).tolist()
    return low, float(sums.sum() / counts.sum()), high
