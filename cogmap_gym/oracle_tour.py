"""A short tour from home that sees 95 % of a plan, by one who knows it: a mark for explorers.

Near-optimal, not optimal: the watchman route is NP-hard with furniture for holes (W.-P. Chin and S.
Ntafos, "Optimum watchman routes", Information Processing Letters 28, 1988). View points are chosen
greedily (the set cover of H. Gonzalez-Banos and J.-C. Latombe, "Navigation strategies for exploring
indoor environments", IJRR 21, 2002), put in order by the nearest and by 2-opt (G. A. Croes,
"A method for solving traveling-salesman problems", Operations Research 6, 1958), and left out
where the way between the others sees enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from cogmap_gym.courses import EXPLORED
from cogmap_gym.coverage import reachable
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.grid import CELL_M, Grid, Mask, mark_seen
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.routes import Routes
from cogmap_gym.world import World

SPACING_M = 1.0
"""Between view points that may be chosen, and between looks on the way [m]."""
ALL_ROUND = LaserSpec(first_angle=-math.pi, step=math.radians(0.5), beams=720)
"""What a robot sees that turns round where it stands."""


class _Views:
    """What is seen from where, in cells of the truth."""

    def __init__(self, world: World) -> None:
        self.world, self.grid = world, Grid.over(world.plan.walls_and_furniture())
        self.counts = reachable(self.grid, world.plan, world.solid_segments)
        self.total = max(int(self.counts.sum()), 1)

    def candidates(self) -> Points:
        """Where a robot may stand, (N, 2) [m]; home is the first."""
        stride, reach = round(SPACING_M / CELL_M), self.world.robot.radius + CELL_M
        stands = self.counts & ~self.grid.near(self.world.solid_segments, reach)
        home = self.world.plan.home
        lattice = np.zeros_like(stands)
        lattice[stride // 2 :: stride, stride // 2 :: stride] = True
        xs, ys = self.grid.centres()
        chosen = lattice & stands
        return np.array([home.position, *zip(xs[chosen], ys[chosen], strict=True)])

    def seen_from(self, points: Points) -> Mask:
        """The cells that count and are seen from any of some points."""
        seen = ~self.counts
        for x, y in points:
            ranges = self.world.caster.ranges(Pose(float(x), float(y)), ALL_ROUND)
            eye, grid = np.array((x, y)), self.grid
            mark_seen(seen, grid.x0, grid.y0, eye, ALL_ROUND.angles, ranges)
        return np.asarray(seen & self.counts)

    def share(self, points: Points) -> float:
        """The share that is seen from any of some points."""
        return float(self.seen_from(points).sum()) / self.total


def oracle_tour(plan: FloorPlan, share: float = EXPLORED) -> Points:
    """The points of a short way from home from which a share of the plan is seen, (K, 2) [m].

    With the doors as the plan has them at first. A way of one point: all is seen from home.

    Args:
        plan: the truth.
        share: of the free space that can be reached.
    """
    world = World(plan, RobotSpec())
    views, routes = _Views(world), Routes(world)
    stops = _cover(views, routes, share)
    order = _shortened(_lengths(routes, stops), _nearest_first(_lengths(routes, stops)))
    stops = _needed(views, routes, stops[order], share)
    order = _shortened(_lengths(routes, stops), list(range(len(stops))))
    return _until(views, _way(routes, stops[order]), share)


def tour_length(plan: FloorPlan, share: float = EXPLORED) -> float:
    """The length of ``oracle_tour`` [m]; 0 where all is seen from home."""
    way = oracle_tour(plan, share)
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _cover(views: _Views, routes: Routes, share: float) -> Points:
    """Home, and view points each of which sees most that was not seen before, (K, 2)."""
    points = views.candidates()
    home = Pose(*points[0].tolist())
    open_ = [math.isfinite(routes.distance(Pose(*p.tolist()), home)) for p in points]
    points = points[open_]
    seen = np.array([views.seen_from(point[None])[views.counts] for point in points])
    chosen, left = [0], ~seen[0]
    while left.sum() > (1.0 - share) * views.total:
        gains = seen[:, left].sum(axis=1)
        if not gains.any():
            break
        chosen.append(int(gains.argmax()))
        left &= ~seen[chosen[-1]]
    return points[chosen]


def _lengths(routes: Routes, stops: Points) -> Array:
    """Lengths of the ways between stops, (K, K) [m]."""
    poses = [Pose(*stop.tolist()) for stop in stops]
    lengths = np.zeros((len(stops), len(stops)))
    for k, there in enumerate(poses):
        for j in range(k):
            lengths[j, k] = lengths[k, j] = routes.distance(poses[j], there)
    return lengths


def _nearest_first(lengths: Array) -> list[int]:
    """An order from the first stop, always on to the nearest."""
    order, left = [0], set(range(1, len(lengths)))
    while left:
        order.append(min(left, key=lambda k: (lengths[order[-1], k], k)))
        left.remove(order[-1])
    return order


def _shortened(lengths: Array, order: Sequence[int]) -> list[int]:
    """The order with pieces turned round as long as that shortens it (2-opt); its end is free."""
    best, length, improved = list(order), _length(lengths, order), True
    while improved:
        improved = False
        for i in range(1, len(best) - 1):
            for j in range(i + 1, len(best)):
                turned = [*best[:i], *best[i : j + 1][::-1], *best[j + 1 :]]
                if _length(lengths, turned) < length - CELL_M * 1e-3:
                    best, length, improved = turned, _length(lengths, turned), True
    return best


def _length(lengths: Array, order: Sequence[int]) -> float:
    return float(lengths[list(order[:-1]), list(order[1:])].sum())


def _needed(views: _Views, routes: Routes, stops: Points, share: float) -> Points:
    """The stops without those that the way between the others makes needless, last first."""
    kept = stops
    for k in range(len(stops) - 1, 0, -1):
        fewer = np.delete(kept, k, axis=0)
        if views.share(_looks(_way(routes, fewer))) >= share:
            kept = fewer
    return kept


def _way(routes: Routes, stops: Points) -> Points:
    """The corners of the way by some stops, (K, 2) [m]."""
    corners = [stops[:1]]
    for here, there in pairwise(stops):
        way = routes.way(Pose(*here.tolist()), Pose(*there.tolist()))
        assert way is not None, "every stop can be reached"
        corners.append(way[1:])
    return np.concatenate(corners)


def _looks(way: Points) -> Points:
    """Points on a way from which one looks round: its corners, and between them each metre."""
    looks = [way[:1]]
    for a, b in pairwise(way):
        count = max(math.ceil(float(np.hypot(*(b - a))) / SPACING_M), 1)
        looks.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.concatenate(looks)


def _until(views: _Views, way: Points, share: float) -> Points:
    """The way up to the look after which a share has been seen."""
    looks = _looks(way)
    seen = np.zeros(views.grid.shape, dtype=np.bool_)
    for k in range(len(looks)):
        seen |= views.seen_from(looks[k : k + 1])
        if seen.sum() >= share * views.total:
            return looks[: k + 1]
    return looks
