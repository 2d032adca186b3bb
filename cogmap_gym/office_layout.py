"""How a generated office is divided into rooms and corridors.

An office is made of bands along x: a row of rooms, a corridor, and a row of rooms (the
shape ``"spine"``); or two corridors with a row of rooms outside either and a middle band
between them, in which links join the corridors: one (``"ladder"``), one at each end
(``"ring"``), or two with rooms on both sides (``"grid"``). Outlines run along the middle of
the walls. ``cogmap_gym.office_shapes`` then makes some of them irregular.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from cogmap_gym.geometry import Array

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
MIDDLE_SHARE = 0.35
"""Share of the rooms that lie in the middle band [-]."""
SPLIT_CHANCE = 0.5
"""How often some rooms of the middle band lie back to back [-]."""
COLUMN_SHARE = 0.7
"""Then: columns of the middle band over its rooms [-]."""
JOIN_CHANCE = 0.5
"""How often a link opens into a corridor with no wall between [-]."""
STEP, DECIMALS = 0.05, 4
"""Most lengths of a layout are multiples of this [m]; decimals of all of them."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """A room or a corridor."""

    outline: Polygon
    """Along the middle of the walls [m]."""
    is_corridor: bool
    """Rooms are furnished otherwise, and every corridor opens to those it meets."""
    side: int = 0
    """-1 in the lowest row, 1 in the highest, 0 elsewhere."""


@dataclass(frozen=True, slots=True)
class _Sizes:
    """The numbers that a layout begins with."""

    counts: tuple[int, int, int]
    """Rooms in the lowest row, the middle band and the highest row."""
    blocks: str
    """What the middle band holds; empty if there is none."""
    width: float
    """Of the building [m]."""
    clear: Array
    """Clear width of the lower and the upper corridor [m]."""
    depths: Array
    """Depth of the lowest and the highest row [m]."""
    alike: bool
    """Whether the upper half is the lower one after half a turn, where it can be."""


def layout(difficulty: Difficulty, wall: float, rng: Rng) -> list[Space]:
    """Divide an office into spaces: corridors first, then rooms.

    Args:
        difficulty: how many rooms, of what shape.
        wall: thickness of the walls [m].
        rng: all chance comes from here.
    """
    sizes = _sizes(difficulty, rng)
    (low, inner, high), width = sizes.counts, sizes.width
    below = _cuts(width, low, rng)
    above = (width - below)[::-1] if sizes.alike and low == high else _cuts(width, high, rng)
    rooms = _row(below, 0.0, sizes.depths[0], -1)
    corridors = [_corridor(width, sizes.depths[0], sizes.clear[0] + wall)]
    y = corridors[0].outline.bounds[3]
    if sizes.blocks:
        links, columns, depth = _middle(sizes.blocks, inner, width, y, wall, rng)
        rooms += columns
        upper = _corridor(width, y + depth, sizes.clear[1] + wall)
        corridors = _joined([corridors[0], upper], links, rng)
        y = upper.outline.bounds[3]
    return corridors + rooms + _row(above, y, y + sizes.depths[1], 1)


def _sizes(difficulty: Difficulty, rng: Rng) -> _Sizes:
    count = int(rng.integers(difficulty.rooms[0], difficulty.rooms[1] + 1))
    blocks = MIDDLE.get(str(rng.choice(difficulty.shapes)), "")
    alike = bool(rng.random() < difficulty.alike)
    inner = max(blocks.count("R"), round(MIDDLE_SHARE * count)) if blocks else 0
    low = (count - inner) // 2
    high = count - inner - low
    most = max(low, high, round(COLUMN_SHARE * inner) + blocks.count("C") // 2)
    width = float(_on_step(most * rng.uniform(*ROOM_WIDTHS)))
    clear, depths = _draw(CORRIDOR_WIDTHS, rng, 2), _draw(ROOM_DEPTHS, rng, 2)
    if alike:
        clear[1], depths[1] = clear[0], depths[0]
    return _Sizes((low, inner, high), blocks, width, clear, depths, alike)


def _middle(
    blocks: str, count: int, width: float, y: float, wall: float, rng: Rng
) -> tuple[list[Space], list[Space], float]:
    """Links, rooms and depth of a middle band that begins at ``y``."""
    fewest = blocks.count("R")
    split = count > fewest and bool(rng.random() < SPLIT_CHANCE)
    columns = max(fewest, round(COLUMN_SHARE * count)) if split else count
    depth = float(_draw(SPLIT_DEPTHS if split else ROOM_DEPTHS, rng, 1)[0])
    breadths = iter(_draw(CORRIDOR_WIDTHS, rng, blocks.count("C")) + wall)
    numbers = iter(np.diff(np.round(np.linspace(0, columns, fewest + 1))).astype(int).tolist())
    parts = [(kind, next(breadths) if kind == "C" else next(numbers)) for kind in blocks]
    spare = width - sum(size for kind, size in parts if kind == "C")
    halved = set(rng.permutation(columns)[: count - columns].tolist())
    links: list[Space] = []
    rooms: list[Space] = []
    x, done = 0.0, 0
    for number, (kind, size) in enumerate(parts):
        end = x + (size if kind == "C" else spare * size / columns)
        end = width if number == len(parts) - 1 else float(_on_step(end))
        if kind == "C":
            links.append(Space(_box(x, y, end, y + depth), is_corridor=True))
        else:
            for left, right in pairwise(x + _cuts(end - x, int(size), rng)):
                rooms += _column(left, right, y, depth, halved=done in halved)
                done += 1
        x = end
    return links, rooms, depth


def _column(left: float, right: float, y: float, depth: float, *, halved: bool) -> list[Space]:
    middle = float(_on_step(depth / 2.0))
    heights = (0.0, middle, depth) if halved else (0.0, depth)
    boxes = [_box(left, y + low, right, y + high) for low, high in pairwise(heights)]
    return [Space(outline, is_corridor=False) for outline in boxes]


def _row(cuts: Array, low: float, high: float, side: int) -> list[Space]:
    return [Space(_box(a, low, b, high), is_corridor=False, side=side) for a, b in pairwise(cuts)]


def _corridor(width: float, low: float, breadth: float) -> Space:
    return Space(_box(0.0, low, width, low + breadth), is_corridor=True)


def _joined(corridors: list[Space], links: list[Space], rng: Rng) -> list[Space]:
    """All corridors; some links open into one of the two others with no wall between."""
    outlines, kept = [space.outline for space in corridors], []
    first = int(rng.integers(2))
    for number, link in enumerate(links):
        k = (first + number) % 2
        if rng.random() < JOIN_CHANCE:
            outlines[k] = unary_union([outlines[k], link.outline])
        else:
            kept.append(link)
    return [*(Space(outline, is_corridor=True) for outline in outlines), *kept]


def _cuts(width: float, count: int, rng: Rng) -> Array:
    """Where a row of ``count`` rooms is cut, both ends included, shape (count + 1,) [m]."""
    shares = rng.uniform(*UNEVEN, count)
    return _on_step(np.concatenate(([0.0], np.cumsum(shares / shares.sum()))) * width)


def _draw(bounds: tuple[float, float], rng: Rng, count: int) -> Array:
    return _on_step(rng.uniform(*bounds, count))


def _on_step(value: Any) -> Array:
    return np.round(np.round(np.asarray(value) / STEP) * STEP, DECIMALS)


def _box(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    return box(*np.round((x0, y0, x1, y1), DECIMALS).tolist())
