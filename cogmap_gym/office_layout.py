"""How a generated office is divided into rooms and corridors.

An office is made of bands along x: a row of rooms, a corridor, and a row of rooms (the
shape ``"spine"``); or two corridors with a row of rooms outside either and a middle band
between them, in which links join the corridors: one (``"ladder"``), one at each end
(``"ring"``), or two with rooms on both sides (``"grid"``). Then ends of corridors are
given to rooms, niches to corridors, and bits are cut off at the outside. Outlines here
run along the middle of the walls and fill the building.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon, box

Rng = np.random.Generator


@dataclass(frozen=True, slots=True)
class Difficulty:
    """What makes an office easy or hard. All values are ours."""

    rooms: tuple[int, int]
    """Fewest and most rooms, corridors not counted [-]."""
    shapes: tuple[str, ...]
    """Which shapes occur."""
    alike: float
    """How often the corridors are alike, each seen from its own end [-]."""
    irregular: float
    """How often each irregularity that can be occurs [-]."""
    piece_area: float
    """Floor area for each piece of furniture that is tried [m^2]."""
    loops: int
    """Fewest independent loops with the chords shut [-]."""
    chords: tuple[int, int]
    """Fewest and most chords [-]."""


DIFFICULTIES = {
    "easy": Difficulty((6, 8), ("spine", "ladder"), 0.0, 0.5, 14.0, 1, (1, 2)),
    "medium": Difficulty((9, 12), ("ladder", "ring", "grid"), 0.25, 0.4, 9.0, 2, (2, 3)),
    "hard": Difficulty((13, 16), ("ring", "grid"), 0.75, 0.3, 6.0, 3, (3, 4)),
}
"""By name. With its corridors an office has at most 20 spaces."""

MIDDLE = {"ladder": "RCR", "ring": "CRC", "grid": "RCRCR"}
"""What the middle band holds from left to right: blocks of rooms, and links."""
STEP = 0.05
"""All lengths of a layout are multiples of this [m]."""
ROOM_WIDTHS = (3.6, 5.2)
"""Mean width of the rooms of a row, least and most [m]."""
ROOM_DEPTHS = (3.6, 6.0)
"""Depth of a row, least and most [m]."""
SPLIT_DEPTHS = (6.8, 8.6)
"""Depth of a middle band that is split into two rows [m]."""
CORRIDOR_WIDTHS = (1.8, 2.4)
"""Clear width of a corridor, least and most [m]."""
UNEVEN = (0.75, 1.25)
"""Least and most share of its mean width that a room has before all are scaled [-]."""
END_LENGTHS = (2.0, 3.2)
"""Length of a corridor's end that a room gets [m]."""
DOOR_WALL = 1.9
"""Length of wall that a room keeps beside its corridor, so that a door fits in [m]."""
NICHE_WIDTHS, NICHE_DEPTHS = (1.5, 2.4), (0.7, 1.1)
"""Size of a niche [m]."""
SETBACKS = (0.5, 1.3)
"""How far an outer wall is set back [m]."""
CUTS = (0.8, 1.4)
"""Sides of what is cut off at an outer corner [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """A room or a corridor."""

    outline: Polygon
    """Along the middle of the walls [m]."""
    is_corridor: bool
    """Rooms are furnished otherwise, and every corridor opens to those it meets."""
    side: int = 0
    """-1 in the lowest row, 1 in the highest, 0 elsewhere."""


def layout(difficulty: Difficulty, wall: float, rng: Rng) -> list[Space]:
    """Divide an office into spaces: corridors first, then rooms from left to right.

    Args:
        difficulty: how many rooms, of what shape.
        wall: thickness of the walls [m].
        rng: all chance comes from here.
    """
    count = int(rng.integers(difficulty.rooms[0], difficulty.rooms[1] + 1))
    shape = str(rng.choice(difficulty.shapes))
    alike = bool(rng.random() < difficulty.alike)
    blocks = MIDDLE.get(shape, "")
    inner = max(blocks.count("R"), round(0.35 * count)) if blocks else 0
    low = (count - inner) // 2
    high = count - inner - low
    clear = _draw(CORRIDOR_WIDTHS, rng, 2)
    clear[1] = clear[0] if alike else clear[1]
    widest = max(low, high, round(0.7 * inner) + blocks.count("C") // 2)
    width = _on_step(widest * rng.uniform(*ROOM_WIDTHS))
    depths = _draw(ROOM_DEPTHS, rng, 2)
    lower = _cuts(width, low, rng)
    upper = width - lower[::-1] if alike and low == high else _cuts(width, high, rng)
    y = depths[0]
    rooms = _row(lower, 0.0, y, -1)
    corridors = [Space(_box(0.0, y, width, y + clear[0] + wall), is_corridor=True)]
    y += clear[0] + wall
    if blocks:
        links, columns, depth = _middle(blocks, inner, width, y, wall, rng)
        corridors += links
        rooms += columns
        y += depth
        corridors.append(Space(_box(0.0, y, width, y + clear[1] + wall), is_corridor=True))
        y += clear[1] + wall
    rooms += _row(upper, y, y + (depths[0] if alike else depths[1]), 1)
    corridors = _joined(corridors, rng)
    return _irregular(corridors + rooms, difficulty.irregular, rng)


def _middle(
    blocks: str, count: int, width: float, y: float, wall: float, rng: Rng
) -> tuple[list[Space], list[Space], float]:
    """Links, rooms and depth of a middle band that begins at ``y``."""
    split = bool(rng.random() < 0.5) and count >= blocks.count("R") + 1
    depth = float(_draw(SPLIT_DEPTHS if split else ROOM_DEPTHS, rng, 1)[0])
    columns = max(blocks.count("R"), round(0.7 * count)) if split else count
    share = np.diff(np.round(np.linspace(0, columns, blocks.count("R") + 1))).astype(int)
    breadths = _draw(CORRIDOR_WIDTHS, rng, blocks.count("C")) + wall
    per_column = (width - breadths.sum()) / columns
    doubled = set(rng.permutation(columns)[: count - columns].tolist())
    links: list[Space] = []
    rooms: list[Space] = []
    x, seen = 0.0, [0, 0, 0]
    for kind in blocks:
        if kind == "C":
            end = x + breadths[seen[0]]
            links.append(Space(_box(x, y, end, y + depth), is_corridor=True))
            seen[0] += 1
        else:
            number = int(share[seen[1]])
            is_last = seen[0] == blocks.count("C") and seen[1] == len(share) - 1
            end = width if is_last else x + per_column * number
            cuts = x + _cuts(end - x, number, rng)
            for left, right in pairwise(cuts):
                rooms += _column(left, right, y, depth, seen[2] in doubled)
                seen[2] += 1
            seen[1] += 1
        x = _on_step(end)
    return links, rooms, depth


def _column(left: float, right: float, y: float, depth: float, doubled: bool) -> list[Space]:
    half = _on_step(depth / 2.0)
    heights = (0.0, half, depth) if doubled else (0.0, depth)
    return [
        Space(_box(left, y + low, right, y + high), is_corridor=False)
        for low, high in pairwise(heights)
    ]


def _row(cuts: np.ndarray, low: float, high: float, side: int) -> list[Space]:
    return [Space(_box(a, low, b, high), is_corridor=False, side=side) for a, b in pairwise(cuts)]


def _joined(corridors: list[Space], rng: Rng) -> list[Space]:
    """Sometimes a link opens into the first or last corridor without a wall between."""
    if len(corridors) < 3:
        return corridors
    ends, links = [corridors[0], corridors[-1]], corridors[1:-1]
    first = int(rng.integers(2))
    kept = []
    for number, link in enumerate(links):
        k = (first + number) % 2
        if rng.random() < 0.5:
            ends[k] = replace(ends[k], outline=_union(ends[k].outline, link.outline))
        else:
            kept.append(link)
    return [*ends, *kept]


def _irregular(spaces: list[Space], chance: float, rng: Rng) -> list[Space]:
    """Change some outlines so that not all is made of rectangles."""
    spaces = list(spaces)
    for k, space in enumerate(spaces):
        if space.side and rng.random() < chance:
            partner = _corridor_beside(spaces, k)
            change = (_end_taken, _niche, _set_back, _corner_cut)[int(rng.integers(4))]
            room, corridor = change(space, spaces[partner], spaces, rng)
            spaces[k], spaces[partner] = room, corridor
    return spaces


def _corridor_beside(spaces: list[Space], k: int) -> int:
    beside = shapely.length(
        [spaces[k].outline.intersection(s.outline) if s.is_corridor else None for s in spaces]
    )
    return int(np.nanargmax(beside))


def _end_taken(
    room: Space, corridor: Space, spaces: list[Space], rng: Rng
) -> tuple[Space, Space]:
    """The room at the end of a corridor gets that end, and is shaped like an L."""
    x0, y0, x1, y1 = corridor.outline.bounds
    left, low, right, high = room.outline.bounds
    length = float(_draw(END_LENGTHS, rng, 1)[0])
    near, far = (low, high) if room.side > 0 else (high, low)
    del far
    deep = _shared_band(corridor, near, room.side)
    if left == x0 and right - left >= length + DOOR_WALL:
        end = _box(x0, *deep[:1], x0 + length, deep[1])
    elif right == x1 and right - left >= length + DOOR_WALL:
        end = _box(x1 - length, deep[0], x1, deep[1])
    else:
        return room, corridor
    del y0, y1, spaces
    return room, corridor if end.is_empty else corridor
