"""The boundary walk: connect items from one end of the exit round to the other.

Departs from thesis 3.5: the text goes to the nearest item each time and gets stuck. Here
all orders are weighed together: the walk returned has the least sum of gaps and of seen
surface cut off, among those that break no rule of connection and go once round the path.
Surfaces are directed, so the counter-clockwise walk is the clockwise one read backwards.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.polygon import orient

from agents.cogmap.connection import NO_GROUP, lay, round_trip, turns, weigh
from agents.cogmap.crossing import Crossing, Sight
from agents.cogmap.params import Boundary
from cogmap_gym.geometry import Array, Points, Segments, lengths, segments_cross

Link = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Items:
    """What a boundary may run along: row 0 the exit crossed, then exits twice, then surfaces."""

    lines: Segments
    """(N, 2, 2), directed with the space inside on the left."""
    surface: NDArray[np.int64]
    """(N,): row of the surface, -1 for an exit."""
    group: NDArray[np.int64]
    """(N,): the same number for the same thing, so for both directions of an exit."""


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """Connections from each item (row) to each other (column)."""

    leave: Points
    """(N, N, 2): where the walk leaves the first."""
    enter: Points
    """(N, N, 2): where it enters the second."""
    cost: Array
    """(N, N): gap plus what it cuts off [m]; infinite if not allowed."""
    turn: NDArray[np.int64]
    """(N, N): how often it and the second item cross a line from the path outward [1]."""


def gather(exit_crossed: Points, exits: Segments, surfaces: Segments) -> Items:
    """Put the exit crossed, the other exits both ways round, and the surfaces into one list."""
    k, n = len(exits), len(surfaces)
    others = np.arange(1, k + 1)
    return Items(
        np.concatenate((exit_crossed[None], exits, exits[:, ::-1], surfaces)),
        np.concatenate((np.full(1 + 2 * k, -1), np.arange(n))),
        np.concatenate(([0], others, others, np.arange(k + 1, k + 1 + n))),
    )


def connect(items: Items, crossing: Crossing, sight: Sight, params: Boundary) -> Links:
    """Lay and weigh the connection from each item to each other.

    Not allowed to cross are (a) the path, (b) large surfaces, (c) exits. Small surfaces
    and lines of sight only cost.
    """
    lines, is_exit = items.lines, items.surface < 0
    limits = (params.max_trim, params.max_extend, params.overlap_offset, params.min_corner_sine)
    leave, enter, gap = lay(lines, is_exit, *limits)
    gap[(items.group[:, None] == items.group) | (gap > params.max_gap)] = np.inf
    hard = is_exit | (lengths(lines) >= params.large)
    toll = np.concatenate(
        (
            np.where(hard, np.inf, params.small_cost),
            np.full(len(crossing.path), np.inf),
            sight.weights * params.hidden_cost,
        )
    )
    blockers = np.concatenate((_shrunk(lines, params.margin), crossing.path, sight.rays))
    nobody = np.full(len(blockers) - len(lines), NO_GROUP)
    cost = weigh(
        lines, items.group, leave, enter, gap, blockers, toll, np.append(items.group, nobody)
    )
    turn = turns(lines, leave, enter, _middle(crossing.path), crossing.outward)
    return Links(leave, enter, cost, turn)


def _shrunk(lines: Segments, margin: float) -> Segments:
    """Lines shortened at both ends by ``margin``, at most by a quarter of their length."""
    size = np.maximum(lengths(lines), np.finfo(np.float64).tiny)
    cut = np.minimum(margin / size, 0.25)[:, None] * (lines[:, 1] - lines[:, 0])
    return np.stack((lines[:, 0] + cut, lines[:, 1] - cut), axis=1)


def _middle(path: Segments) -> Points:
    """The middle of the longest piece of the path."""
    return np.asarray(path[lengths(path).argmax()].mean(axis=0))


def walk_round(
    items: Items, links: Links, path: Segments, params: Boundary
) -> tuple[Points, list[int]]:
    """Find the cheapest walk that closes a simple polygon round the path.

    Where a walk crosses itself (d), the connections at fault are forbidden, one by one,
    and the next cheapest walk is tried, at most ``max_tries`` times.

    Returns:
        The polygon (K, 2), counter-clockwise, and the rows of the items on it; (0, 2) and
        none if nothing closed.
    """
    queue: list[tuple[float, int, Array, list[int]]] = []
    _offer(queue, links.cost, links.turn, 0)
    for tried in range(params.max_tries):
        if not queue:
            break
        _, _, cost, chain = heapq.heappop(queue)
        polygon, faults = _judge(chain, links, path, params)
        if not faults:
            return polygon, chain
        # The rest of the walks, parted: those without the first fault, those with it but
        # without the second, and so on.
        for number, (i, j) in enumerate(faults):
            without = cost.copy()
            without[i, j] = np.inf
            _offer(queue, without, links.turn, (tried + 1) * len(items.lines) + number)
            kept = cost[i, j]
            cost[i, :] = cost[:, j] = np.inf
            cost[i, j] = kept
    return np.zeros((0, 2)), []


def _offer(
    queue: list[tuple[float, int, Array, list[int]]],
    cost: Array,
    turn: NDArray[np.int64],
    number: int,
) -> None:
    """Queue the cheapest walk under these costs, if there is one."""
    total, chain = round_trip(cost, turn)
    if np.isfinite(total):
        heapq.heappush(queue, (total, number, cost.copy(), [0, *chain.tolist()]))


def _judge(
    chain: list[int], links: Links, path: Segments, params: Boundary
) -> tuple[Points, list[Link]]:
    """Lay out a chain as a polygon; the connections at fault, none if it is good."""
    steps = list(zip(chain, chain[1:] + chain[:1], strict=True))
    points = np.array([p for s in steps for p in (links.leave[s], links.enter[s])])
    polygon = _unfolded(points, params)
    if polygon is None:
        return points, _self_crossings(points, steps) or steps
    good = _contains(polygon, path, params)
    return np.array(polygon.exterior.coords)[:-1], [] if good else steps


def _unfolded(points: Points, params: Boundary) -> shapely.Polygon | None:
    """A simple counter-clockwise polygon, small folds cut off; None if the folds are large."""
    points = points[np.hypot(*(points - np.roll(points, 1, axis=0)).T) > params.min_side]
    if len(points) < 3:
        return None
    ring = shapely.Polygon(points)
    pieces = shapely.get_parts(shapely.make_valid(ring))
    parts = [p for p in shapely.get_parts(pieces) if p.geom_type == "Polygon"]
    if not parts:
        return None
    largest = max(parts, key=_area)
    if sum(map(_area, parts)) - _area(largest) > params.max_fold or largest.interiors:
        return None
    return orient(largest)


def _area(polygon: shapely.Polygon) -> float:
    return float(polygon.area)


def _contains(polygon: shapely.Polygon, path: Segments, params: Boundary) -> bool:
    """Whether enough of the path lies inside."""
    line = shapely.MultiLineString(list(path))
    return bool(line.intersection(polygon).length >= params.path_inside * line.length)


def _self_crossings(points: Points, steps: list[Link]) -> list[Link]:
    """The connections in or next to each pair of polygon edges that cross."""
    # Edge 2m is connection m, edge 2m + 1 runs along the item after it.
    edges = np.stack((points, np.roll(points, -1, axis=0)), axis=1)
    found = np.flatnonzero(segments_cross(edges, edges).any(axis=1))
    at = {(e + k) // 2 % len(steps) for e in found.tolist() for k in (0, 1)}
    return [steps[m] for m in sorted(at)]
