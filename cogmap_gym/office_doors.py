"""Which spaces of a generated office are joined by doors, and where.

First every corridor is joined to those it meets and every room to a corridor, then what
still hangs loose; then some more doors make loops, and doors that would save the longest
ways become the chords, which are shut at first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import networkx as nx
import numpy as np
import shapely
from shapely.geometry import Polygon

from cogmap_gym.geometry import Points, Segments
from cogmap_gym.office_layout import DECIMALS, Difficulty, Rng, Space

WIDTHS = (0.8, 0.85, 0.9, 0.95, 1.0)
"""Clear widths of doorways [m]. DESIGN 4."""
JAMB = 0.25
"""Least length of wall between an opening and a corner [m]. Ours."""
APART = 0.6
"""Least distance of two openings [m]. Ours."""
CHORD_GAIN = 6.0
"""Least length that opening a chord saves on the way between its two sides [m]. Ours."""
LOOP_GAIN = 4.0
"""The same for a door that makes a loop [m]. Ours: shorter loops teach nothing."""
ROUNDS = 4
"""How often places for all doors are drawn before the layout is given up [-]. Ours."""
OPTIONAL_LOOPS = 2
"""Most loops beyond the fewest asked for [-]. Ours."""


@dataclass(frozen=True, slots=True, eq=False)
class Doorway:
    """An opening through the wall between two spaces, and its door."""

    sides: tuple[int, int]
    """The two spaces; ``normal`` points from the first to the second."""
    middle: Points
    """Of the opening, in the middle of the wall, shape (2,) [m]."""
    normal: Points
    """Unit, at right angles to the wall, shape (2,)."""
    width: float
    """Clear width [m]."""
    wall: float
    """Thickness of the wall [m]."""
    leaf_at: float = 0.0
    """Where the leaf is: 0 in the middle of the wall, -1 or 1 flush with the face of the
    first or second space."""

    @property
    def leaf(self) -> Segments:
        """The door when it is shut, shape (2, 2) [m]."""
        return self._across(0.5 * self.leaf_at)

    @property
    def opening(self) -> Polygon:
        """The whole opening, face to face and jamb to jamb."""
        return self._between(-0.5, 0.5)

    def share(self, space: int) -> Polygon:
        """The part of the opening on the side of ``space``; empty if the leaf is flush."""
        ends = (-0.5, 0.5 * self.leaf_at) if space == self.sides[0] else (0.5 * self.leaf_at, 0.5)
        return self._between(*ends) if ends[0] < ends[1] else Polygon()

    def _between(self, near: float, far: float) -> Polygon:
        return Polygon(np.concatenate((self._across(near), self._across(far)[::-1])))

    def _across(self, at: float) -> Points:
        along = np.array((-self.normal[1], self.normal[0])) * self.width / 2.0
        middle = self.middle + at * self.wall * self.normal
        ends = np.stack((middle - along, middle + along))
        return np.asarray(np.round(ends, DECIMALS), dtype=np.float64)


def doorways(
    spaces: Sequence[Space], wall: float, difficulty: Difficulty, rng: Rng
) -> tuple[list[Doorway], list[Doorway]] | None:
    """Choose the doors that are open and the chords.

    Args:
        spaces: of a layout.
        wall: thickness of the walls [m].
        difficulty: how many loops and chords.
        rng: all chance comes from here.

    Returns:
        The open doors and the chords; None if this layout or these draws allow no office.
    """
    walls = _shared_walls(spaces, wall)
    doors = _tree(walls, spaces, wall, rng)
    if doors is None:
        return None
    loops = difficulty.loops + int(rng.integers(OPTIONAL_LOOPS + 1))
    missing = loops - (len(doors) - len(spaces) + 1)
    doors += _savers(walls, doors, LOOP_GAIN, missing, wall, rng)
    if len(doors) - len(spaces) + 1 < difficulty.loops:
        return None
    wanted = int(rng.integers(difficulty.chords[0], difficulty.chords[1] + 1))
    chords = _savers(walls, doors, CHORD_GAIN, wanted, wall, rng)
    if len(chords) < difficulty.chords[0]:
        return None
    return doors, [_flush(chord, spaces) for chord in chords]


Walls = dict[tuple[int, int], list[Segments]]
"""By pair of spaces, the straight walls between them that are long enough for a door, each
(2, 2) with the second space on its left [m]."""


def _shared_walls(spaces: Sequence[Space], wall: float) -> Walls:
    shared: Walls = {}
    for a, b in combinations(range(len(spaces)), 2):
        lines = spaces[a].outline.intersection(spaces[b].outline)
        parts = [part for part in shapely.get_parts(lines) if part.geom_type == "LineString"]
        merged = shapely.get_parts(shapely.line_merge(shapely.union_all(parts)))
        pieces = [shapely.get_coordinates(shapely.simplify(line, 0.0)) for line in merged]
        straight = [piece[k : k + 2] for piece in pieces for k in range(len(piece) - 1)]
        straight = [_directed(ends, spaces[b].outline) for ends in straight]
        needed = WIDTHS[0] + 2.0 * (JAMB + wall / 2.0)
        wide = [ends for ends in straight if math.dist(*ends) >= needed]
        if wide:
            shared[a, b] = wide
    return shared


def _directed(ends: Segments, left: Polygon) -> Segments:
    """The ends of a straight wall in such an order that ``left`` is on its left."""
    along = (ends[1] - ends[0]) / math.dist(*ends)
    beside = ends.mean(axis=0) + JAMB * np.array((-along[1], along[0]))
    return ends if shapely.contains_xy(left, *beside) else ends[::-1]


def _drawn(
    pair: tuple[int, int], walls: Walls, taken: Sequence[Polygon], wall: float, rng: Rng
) -> Doorway | None:
    """A doorway between a pair of spaces; None if it comes too near to those taken."""
    start, end = walls[pair][int(rng.integers(len(walls[pair])))]
    length = math.dist(start, end)
    margin = JAMB + wall / 2.0
    fitting = [width for width in WIDTHS if width <= length - 2.0 * margin] or [WIDTHS[0]]
    width = float(rng.choice(fitting))
    first = margin + width / 2.0
    at = float(np.round(rng.uniform(first, max(first, length - first)), 2))
    along = (end - start) / length
    door = Doorway(pair, start + at * along, np.array((-along[1], along[0])), width, wall)
    opening = door.opening
    gaps = [opening.distance(other) for other in taken]
    return door if min(gaps, default=APART) >= APART else None


def _tree(walls: Walls, spaces: Sequence[Space], wall: float, rng: Rng) -> list[Doorway] | None:
    """Doors that join all spaces, and every corridor to all corridors beside it."""
    graph: nx.Graph[int] = nx.empty_graph(len(spaces))
    doors: list[Doorway] = []
    pairs = [list(walls)[k] for k in rng.permutation(len(walls))]
    by_kind = sorted(pairs, key=lambda p: -sum(spaces[k].is_corridor for k in p))
    for pair in by_kind * ROUNDS:
        both = all(spaces[k].is_corridor for k in pair) and not graph.has_edge(*pair)
        if both or not nx.has_path(graph, *pair):
            door = _drawn(pair, walls, [other.opening for other in doors], wall, rng)
            if door is not None:
                doors.append(door)
                graph.add_edge(*pair)
    return doors if nx.is_connected(graph) else None


def _savers(
    walls: Walls, doors: Sequence[Doorway], least: float, most: int, wall: float, rng: Rng
) -> list[Doorway]:
    """Up to ``most`` more doors, each of which saves ``least`` metres or more on some way.

    One that saves more is likelier to be drawn.
    """
    chosen: list[Doorway] = []
    joined = {door.sides for door in doors}
    for _ in range(most):
        taken = [door.opening for door in (*doors, *chosen)]
        pairs = [pair for pair in sorted(walls) if pair not in joined]
        drawn = [_drawn(pair, walls, taken, wall, rng) for pair in pairs]
        new = [door for door in drawn if door is not None]
        gains = np.array([_gain(door, doors) for door in new])
        weights = np.where(gains >= least, gains, 0.0) ** 2
        if not weights.sum():
            break
        door = new[int(rng.choice(len(new), p=weights / weights.sum()))]
        chosen.append(door)
        joined.add(door.sides)
    return chosen


def _gain(door: Doorway, doors: Sequence[Doorway]) -> float:
    """About how long the way from one side of a shut door to the other is [m]."""
    graph: nx.Graph[int] = nx.Graph()
    ends = [replace(door, sides=(side, -1)) for side in door.sides]
    stops = [*doors, *ends]
    for i, j in combinations(range(len(stops)), 2):
        if set(stops[i].sides) & set(stops[j].sides) - {-1}:
            graph.add_edge(i, j, weight=math.dist(stops[i].middle, stops[j].middle))
    return float(nx.dijkstra_path_length(graph, len(stops) - 2, len(stops) - 1))


def _flush(chord: Doorway, spaces: Sequence[Space]) -> Doorway:
    """Put the leaf of a chord in one plane with a wall, that of a corridor if there is one."""
    first, second = (spaces[k].is_corridor for k in chord.sides)
    return replace(chord, leaf_at=1.0 if second and not first else -1.0)
