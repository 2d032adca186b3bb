"""The scores of goals in ``info``, and the lengths that they compare with."""

from __future__ import annotations

import math

from cogmap_gym.events import EventQueue
from cogmap_gym.geometry import Pose
from cogmap_gym.learning_walk import learning_length
from cogmap_gym.routes import Routes
from cogmap_gym.world import World

SCORES = (
    *("success", "spl", "final_distance", "oracle_length"),
    *("spl_learning", "learning_length"),
)
"""The arrays by mark in ``info``. ``success[0]`` is that of the last finished phase of goal 0.
Of a mark that was a goal more than once, the last finished phase counts. ``final_distance``
is the straight distance to the mark [m]. Both lengths [m] are from where the goal was given:
``oracle_length`` that of the shortest way for one who knows all events of the phase,
``learning_length`` that of the shortest walk that learns of a block only on seeing it
(``learning_walk``). ``spl`` and ``spl_learning`` are
success weighted by each length over the length driven, at most 1. -1: not finished, no route."""


def shortest_lengths(
    world: World, routes: Routes, events: EventQueue, mark: Pose, range_max: float
) -> tuple[float, float]:
    """The lengths to a mark for one who knows what will happen, and for one who learns [m].

    To be asked as a goal is given, before the first of its events has fired.

    Args:
        world: with the robot where the goal is given.
        routes: of that world.
        events: what will happen.
        mark: the goal.
        range_max: how far the one who learns sees [m].

    Returns:
        ``oracle_length`` and ``learning_length``; -1 where there is no way.
    """
    oracle = learning = routes.distance(world.pose, mark, events.outcome())
    if events.pending:
        learning = learning_length(world, routes, events, mark, range_max)
    return _finite(min(oracle, learning)), _finite(learning)


def path_share(shortest: float, driven: float, *, success: bool) -> float:
    """Success weighted by path length, 0 to 1; -1 where no way was there."""
    if shortest < 0.0:
        return -1.0
    return float(success) * (shortest / max(shortest, driven) if driven > 0.0 else 1.0)


def _finite(length: float) -> float:
    """A length as ``info`` tells it: -1 for none."""
    return length if math.isfinite(length) else -1.0
