"""Furniture, pillars and pilasters for the spaces of a generated office.

A piece stands flush with a wall or free; nothing else comes nearer to it than ``GAP``, so
that no passage is neither wide nor shut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import Polygon

from cogmap_gym.geometry import Points, Segments
from cogmap_gym.office_layout import DECIMALS, Rng

GAP = 0.8
"""Least distance to anything a piece does not touch [m]."""
DOOR_GAP = 1.2
"""Least distance to a door [m]."""
TOUCH = 1e-3
"""Things that are nearer to each other than this touch [m]."""
INTO_WALL = 0.001
"""How far a piece beside a wall reaches into it, so that rounding leaves no slit [m]."""
TRIES = 6
"""How often a place is drawn for a piece before it is left out [-]."""
CORNER_CHANCE = 0.35
"""How often a piece beside a wall is pushed to its end [-]."""
TURNED_CHANCE = 0.3
"""How often a free-standing piece stands at an angle to the walls [-]."""
FREE_CHANCE = 0.3
"""Share of free-standing pieces in rooms [-]."""
SOLID_CHANCE = 0.15
"""Share of pillars and pilasters among the pieces [-]."""
Range = tuple[float, float]
DESK: tuple[Range, Range] = ((1.2, 1.8), (0.6, 0.8))
"""Length along the wall and depth of what stands beside a wall [m]; so are the next ones."""
CUPBOARD: tuple[Range, Range] = ((0.8, 2.0), (0.4, 0.6))
SHELF: tuple[Range, Range] = ((1.6, 3.0), (0.3, 0.4))
LOCKER: tuple[Range, Range] = ((0.8, 1.8), (0.3, 0.45))
PILASTER: tuple[Range, Range] = ((0.4, 0.6), (0.2, 0.3))
TABLE: tuple[Range, Range] = ((1.2, 2.2), (0.8, 1.2))
PILLAR: tuple[Range, Range] = ((0.3, 0.5), (0.3, 0.5))


@dataclass(slots=True, eq=False)
class Scene:
    """One space while it is furnished."""

    floor: Polygon
    """The space with its parts of the doorways [m]."""
    faces: Segments
    """Its walls, (N, 2, 2), the floor on their left [m]."""
    keep_clear: shapely.Geometry
    """Door leaves, and home: no piece comes nearer to these than ``DOOR_GAP``."""
    furniture: list[Polygon] = field(default_factory=list)
    """What has been put in."""
    solids: list[Polygon] = field(default_factory=list)
    """Pillars and pilasters: part of the walls."""

    @staticmethod
    def of(floor: Polygon, keep_clear: shapely.Geometry) -> Scene:
        """An empty space."""
        ring = shapely.get_coordinates(shapely.normalize(floor).exterior)[::-1]
        shapely.prepare(floor)
        return Scene(floor, np.stack((ring[:-1], ring[1:]), axis=1), keep_clear)

    def fits(self, piece: Polygon) -> bool:
        """Whether a piece leaves every passage shut or wide."""
        if not shapely.covers(self.floor.buffer(TOUCH), piece):
            return False
        if piece.distance(self.keep_clear) < DOOR_GAP:
            return False
        others = np.array([*self.furniture, *self.solids], dtype=object)
        walls = shapely.distance(piece, shapely.linestrings(self.faces))
        near_wall = ((walls > TOUCH) & (walls < GAP)).any()
        return not near_wall and not (shapely.distance(piece, others) < GAP).any()


def furnish(scene: Scene, pieces: int, rng: Rng, *, is_corridor: bool) -> None:
    """Try to put a number of pieces into a space."""
    for _ in range(pieces):
        is_solid = bool(rng.random() < SOLID_CHANCE)
        is_free = not is_corridor and bool(rng.random() < FREE_CHANCE)
        for _ in range(TRIES):
            if is_free:
                piece = drawn = _free(scene, PILLAR if is_solid else TABLE, rng)
            else:
                piece, drawn = _beside_wall(scene, _kind(rng, is_corridor, is_solid), rng)
            if scene.fits(piece):
                (scene.solids if is_solid else scene.furniture).append(drawn)
                break


def _kind(rng: Rng, is_corridor: bool, is_solid: bool) -> tuple[Range, Range]:
    """The size of a piece beside a wall."""
    if is_solid:
        return PILASTER
    return LOCKER if is_corridor else (DESK, CUPBOARD, SHELF)[int(rng.integers(3))]


def _beside_wall(scene: Scene, size: tuple[Range, Range], rng: Rng) -> tuple[Polygon, Polygon]:
    """A piece flush with a wall, and the same reaching into the wall."""
    spans = scene.faces[:, 1] - scene.faces[:, 0]
    long = np.hypot(*spans.T)
    k = int(rng.choice(len(long), p=long / long.sum()))
    length, depth = (float(np.round(rng.uniform(*bounds), 2)) for bounds in size)
    along = spans[k] / long[k]
    inward = np.array((-along[1], along[0]))
    spare = max(long[k] - length, 0.0)
    at = float(np.round(rng.uniform(0.0, spare), 2))
    if rng.random() < CORNER_CHANCE:
        at = 0.0 if rng.random() < 0.5 else spare
    start = scene.faces[k, 0] + at * along
    end = start + length * along
    # In a corner of the room the piece reaches into a second wall as well.
    inner = [spans[k - 1] @ inward < 0.0, spans[(k + 1) % len(spans)] @ inward > 0.0]
    low, high = (INTO_WALL * (at == edge and inner[n]) for n, edge in enumerate((0.0, spare)))
    piece = _quad(start, end, depth * inward)
    back = INTO_WALL * inward
    deep = _quad(start - low * along - back, end + high * along - back, depth * inward + back)
    return piece, deep


def _free(scene: Scene, size: tuple[Range, Range], rng: Rng) -> Polygon:
    """A piece anywhere in a space, mostly square to its first wall."""
    x0, y0, x1, y1 = scene.floor.bounds
    middle = np.round((rng.uniform(x0, x1), rng.uniform(y0, y1)), 2)
    length, depth = (float(np.round(rng.uniform(*bounds), 2)) for bounds in size)
    span = scene.faces[0, 1] - scene.faces[0, 0]
    heading = math.atan2(span[1], span[0])
    if rng.random() < TURNED_CHANCE:
        heading += rng.uniform(0.0, math.pi / 2.0)
    along = np.array((math.cos(heading), math.sin(heading))) * length / 2.0
    inward = np.array((-math.sin(heading), math.cos(heading))) * depth
    return _quad(middle - along - inward / 2.0, middle + along - inward / 2.0, inward)


def _quad(start: Points, end: Points, inward: Points) -> Polygon:
    return Polygon(np.round((start, end, end + inward, start + inward), DECIMALS))
