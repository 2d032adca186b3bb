"""The visibility graph of a floor plan for a round robot, by which the oracle finds its ways.

The robot's centre must keep its radius from every wall. The shortest way then runs straight
between circles of that radius about wall corners, and along them. The circles are drawn as
polygons round them whose sides touch the circle, so that every way in the graph can truly be
driven: it is up to 1.3 % longer on the arcs, a few millimetres a corner, and needs a gap of
0.51 m where the body needs 0.5 m.

The graph is made once for all doors and barriers; each edge knows which of them would cut it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Segments, headings
from cogmap_gym.raycast_kernel import compiled

QUARTER_SIDES = 4
"""Sides of the polygon about a quarter of a circle [-]. Ours: 16 about a whole circle."""
TOLERANCE_M = 1e-6
"""A way may come this much nearer to a wall than the radius [m]: rounding."""
HALF_SIDE = math.pi / (4 * QUARTER_SIDES)
"""Half the angle that a side of the polygon spans [rad]."""
TAUT = math.sin(HALF_SIDE) + TOLERANCE_M
"""A taut way leaves a corner of the polygon this near to the tangent, as a sine [-]."""
ROUNDING = 6
"""Corners alike to so many decimals of a metre are one."""
Mask = NDArray[np.bool_]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class VisibilityGraph:
    """Where a disc can drive straight, whatever doors and barriers are in the way."""

    nodes: Points
    """(N, 2): where ways may bend [m]."""
    edges: Ints
    """(E, 2): the rows of two nodes between which nothing stands but doors and barriers."""
    lengths: Array
    """(E,) [m]."""
    cut_by: Mask
    """(E, M): which movable segments are in the way of an edge when they are in place."""

    @classmethod
    def of(cls, plan: FloorPlan, movable: Segments, radius: float) -> VisibilityGraph:
        """Build the graph of a plan.

        Args:
            plan: its walls and furniture stand for ever; only what hangs together with its
                home counts.
            movable: (M, 2, 2), doors and barriers [m].
            radius: of the robot [m].
        """
        walls, reach = plan.walls_and_furniture(), radius - TOLERANCE_M
        nodes, outward = _corners(np.concatenate((walls, movable)), radius)
        free = plan.free_space()
        shapely.prepare(free)
        fits = shapely.contains_xy(free, nodes) & clear(nodes, nodes, walls, reach)
        nodes, outward = nodes[fits], outward[fits]
        edges = _taut_edges(nodes, outward, walls, reach)
        a, b = nodes[edges[:, 0]], nodes[edges[:, 1]]
        cuts = [~clear(a, b, leaf[None], reach) for leaf in movable]
        cut_by = np.stack(cuts, axis=1) if cuts else np.zeros((len(edges), 0), dtype=np.bool_)
        return cls(nodes, edges, np.hypot(*(b - a).T), cut_by)


def clear(starts: Points, ends: Points, solid: Segments, radius: float) -> Mask:
    """Whether a disc can drive straight from each start to the end of the same row.

    Args:
        starts: (K, 2) [m].
        ends: (K, 2) [m].
        solid: (N, 2, 2), what is in the way [m].
        radius: of the disc [m]; 0 asks for a line of sight.

    Returns:
        (K,).
    """
    return np.asarray(_clear_rows(starts, ends, np.ascontiguousarray(solid), radius))


def first_clear(here: Points, there: Points, order: Ints, solid: Segments, radius: float) -> int:
    """The first row of ``there`` (N, 2), taken in ``order``, to which the way is clear; or -1."""
    return int(_first_clear(here, there, order, np.ascontiguousarray(solid), radius))


def _corners(segments: Segments, radius: float) -> tuple[Points, Points]:
    """Corners of the polygons about all segment ends (K, 2), and the way out there (K, 2)."""
    sides = np.arange(2 * QUARTER_SIDES + 1) * 2.0 * HALF_SIDE - math.pi / 2.0
    angle = headings(segments)[:, None] + np.stack((sides + math.pi, sides))[:, None]
    outward = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    centres = np.swapaxes(segments, 0, 1)[:, :, None]
    nodes = (centres + radius / math.cos(HALF_SIDE) * outward).reshape(-1, 2)
    _, kept = np.unique(nodes.round(ROUNDING), axis=0, return_index=True)
    return nodes[kept], outward.reshape(-1, 2)[kept]


def _taut_edges(nodes: Points, outward: Points, walls: Segments, reach: float) -> Ints:
    """The edges (E, 2) that a shortest way can use: free, and tangent at both ends."""
    edges = [np.zeros((0, 2), dtype=np.int64)]
    walls = np.ascontiguousarray(walls)
    for row in range(len(nodes) - 1):
        others = np.asarray(_taut_and_clear(row, nodes, outward, walls, reach))
        edges.append(np.stack((np.full(len(others), row), others), axis=1))
    return np.concatenate(edges)


@compiled
def _taut_and_clear(
    row: int, nodes: Points, outward: Points, walls: Segments, reach: float
) -> Ints:
    """The later nodes to which a free edge from node ``row`` is tangent at both ends, (K,)."""
    x, y, ux, uy = nodes[row, 0], nodes[row, 1], outward[row, 0], outward[row, 1]
    out = np.zeros(nodes.shape[0], dtype=np.int64)
    count, blocker = 0, 0
    for n in range(row + 1, nodes.shape[0]):
        dx, dy = nodes[n, 0] - x, nodes[n, 1] - y
        slack = TAUT * math.hypot(dx, dy)
        if abs(dx * ux + dy * uy) > slack:
            continue
        if abs(dx * outward[n, 0] + dy * outward[n, 1]) > slack:
            continue
        blocker = _blocker(x, y, nodes[n, 0], nodes[n, 1], walls, reach, max(blocker, 0))
        if blocker < 0:
            out[count] = n
            count += 1
    return out[:count]


@compiled
def _gap(x: float, y: float, px: float, py: float, qx: float, qy: float) -> float:
    """Distance from (x, y) to the segment from p to q [m]."""
    dx, dy = qx - px, qy - py
    squared = dx * dx + dy * dy
    t = 0.0
    if squared > 0.0:
        t = min(max(((x - px) * dx + (y - py) * dy) / squared, 0.0), 1.0)
    return math.hypot(x - px - t * dx, y - py - t * dy)


@compiled
def _blocker(
    ax: float, ay: float, bx: float, by: float, solid: Segments, radius: float, first: int
) -> int:
    """A segment that crosses the line from a to b or comes nearer than ``radius``, or -1.

    The search begins with segment ``first``: the one that stood in the last way may stand in
    this one.
    """
    left, right = min(ax, bx) - radius, max(ax, bx) + radius
    low, high = min(ay, by) - radius, max(ay, by) + radius
    for k in range(solid.shape[0]):
        n = k + first if k + first < solid.shape[0] else k + first - solid.shape[0]
        px, py, qx, qy = solid[n, 0, 0], solid[n, 0, 1], solid[n, 1, 0], solid[n, 1, 1]
        if max(px, qx) < left or min(px, qx) > right or max(py, qy) < low or min(py, qy) > high:
            continue
        side_p = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
        side_q = (bx - ax) * (qy - ay) - (by - ay) * (qx - ax)
        side_a = (qx - px) * (ay - py) - (qy - py) * (ax - px)
        side_b = (qx - px) * (by - py) - (qy - py) * (bx - px)
        if side_p * side_q < 0.0 and side_a * side_b < 0.0:
            return n
        if radius > 0.0 and (
            _gap(px, py, ax, ay, bx, by) < radius
            or _gap(qx, qy, ax, ay, bx, by) < radius
            or _gap(ax, ay, px, py, qx, qy) < radius
            or _gap(bx, by, px, py, qx, qy) < radius
        ):
            return n
    return -1


@compiled
def _clear_rows(starts: Points, ends: Points, solid: Segments, radius: float) -> Mask:
    """Whether nothing blocks the line, row by row."""
    out = np.ones(starts.shape[0], dtype=np.bool_)
    for k in range(starts.shape[0]):
        ax, ay, bx, by = starts[k, 0], starts[k, 1], ends[k, 0], ends[k, 1]
        out[k] = _blocker(ax, ay, bx, by, solid, radius, 0) < 0
    return out


@compiled
def _first_clear(here: Points, there: Points, order: Ints, solid: Segments, radius: float) -> int:
    """The first of ``order`` that ``here`` (2,) can reach in a straight line, or -1."""
    for k in range(order.shape[0]):
        row = order[k]
        if _blocker(here[0], here[1], there[row, 0], there[row, 1], solid, radius, 0) < 0:
            return int(row)
    return -1
