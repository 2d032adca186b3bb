"""Irregular outlines for generated offices: L-shapes, niches, set-backs, cut corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon, box

from cogmap_gym.office_layout import DECIMALS, Rng, Space

END_LENGTHS = (2.0, 3.2)
"""Length of a corridor's end that a room gets [m]. Ours, as all that follows."""
END_AT = 1.0
"""Where the breadth of a corridor is taken, from its end [m]."""
BROADEST = 3.0
"""A corridor broader than this where it ends turns a corner there [m]."""
NICHE_WIDTHS, NICHE_DEPTHS = (1.6, 2.4), (0.8, 1.1)
"""Size of the niches that corridors have [m]."""
NICHE_WALL = 1.9
"""Length of wall that the room keeps beside the niche, so that a door fits in [m]."""
SET_BACKS = (0.5, 1.3)
"""How far an outer wall is set back [m]."""
CUTS = (0.8, 1.5)
"""Legs of the triangle or box that is cut off at an outer corner [m]."""
ALL_CHANGES = 4
"""How many kinds of change there are [-]."""


def irregular(spaces: list[Space], chance: float, rng: Rng) -> list[Space]:
    """Change some outlines, so that not all is made of rectangles.

    Args:
        spaces: of a layout, corridors first.
        chance: how often a room of an outer row is changed.
        rng: all chance comes from here.
    """
    changed = list(spaces)
    for k, room in enumerate(spaces):
        if room.side and rng.random() < chance:
            j = _corridor_beside(changed, k)
            outlines = _change(room, changed[j].outline, rng)
            if all(outline.geom_type == "Polygon" for outline in outlines):
                changed[k] = replace(room, outline=outlines[0])
                changed[j] = replace(changed[j], outline=outlines[1])
    return changed


def _corridor_beside(spaces: list[Space], k: int) -> int:
    """The corridor that shares most wall with space ``k``."""
    outline = spaces[k].outline
    corridors = [number for number, space in enumerate(spaces) if space.is_corridor]
    shared = [outline.intersection(spaces[number].outline).length for number in corridors]
    return corridors[int(np.argmax(shared))]


def _change(room: Space, corridor: Polygon, rng: Rng) -> tuple[Polygon, Polygon]:
    """New outlines of a room of an outer row and the corridor beside it."""
    kind = int(rng.integers(ALL_CHANGES))
    if kind == 0:
        end = _end(room, corridor, rng)
        return shapely.union(room.outline, end), corridor.difference(end)
    if kind == 1:
        niche = _niche(room, rng)
        return room.outline.difference(niche), shapely.union(corridor, niche)
    taken = _set_back(room, rng) if kind == 2 else _corner(room, rng)
    return room.outline.difference(taken), corridor


def _end(room: Space, corridor: Polygon, rng: Rng) -> Polygon:
    """The end of the corridor that lies before the room; empty if there is none."""
    left, _, right, _ = room.outline.bounds
    x0, y0, x1, y1 = corridor.bounds
    length = _draw(END_LENGTHS, rng)
    if right - left < length or (left > x0 and right < x1):
        return Polygon()
    at = x0 + END_AT if left <= x0 else x1 - END_AT
    across = corridor.intersection(LineString(((at, y0 - 1.0), (at, y1 + 1.0)))).bounds
    if across[3] - across[1] > BROADEST:
        return Polygon()
    return _box(*((x0, x0 + length) if left <= x0 else (x1 - length, x1)), across[1], across[3])


def _niche(room: Space, rng: Rng) -> Polygon:
    """A part of the room on its side to the corridor; empty if the room is too small."""
    left, low, right, high = room.outline.bounds
    width, depth = _draw(NICHE_WIDTHS, rng), _draw(NICHE_DEPTHS, rng)
    if right - left < width + NICHE_WALL or high - low < 4.0 * depth:
        return Polygon()
    x = left if rng.random() < 0.5 else right - width
    return _box(x, x + width, *((high - depth, high) if room.side < 0 else (low, low + depth)))


def _set_back(room: Space, rng: Rng) -> Polygon:
    """A strip along the outer wall."""
    left, low, right, high = room.outline.bounds
    depth = _draw(SET_BACKS, rng)
    return _box(left, right, *((low, low + depth) if room.side < 0 else (high - depth, high)))


def _corner(room: Space, rng: Rng) -> Polygon:
    """A triangle or a box at one of the two outer corners."""
    left, low, right, high = room.outline.bounds
    wide, deep = _draw(CUTS, rng), _draw(CUTS, rng)
    x, y = (left if rng.random() < 0.5 else right), (low if room.side < 0 else high)
    inner_x = x + (wide if x == left else -wide)
    inner_y = y + (deep if y == low else -deep)
    if rng.random() < 0.5:
        return Polygon(np.round(((x, y), (inner_x, y), (x, inner_y)), DECIMALS))
    return _box(*sorted((x, inner_x)), *sorted((y, inner_y)))


def _draw(bounds: tuple[float, float], rng: Rng) -> float:
    return float(np.round(rng.uniform(*bounds), 2))


def _box(x0: float, x1: float, y0: float, y1: float) -> Polygon:
    return box(*np.round((x0, y0, x1, y1), DECIMALS).tolist())
