"""Offices made by chance: ``"office:SEED"`` or ``"office:SEED:DIFFICULTY"`` is a plan.

A layout of rooms and corridors is drawn along the middle of the walls. Each space is drawn
in by half a wall, doorways are cut, and pillars and furniture put in; the rings about what
is then free are the walls, which therefore have no gap. At last all is turned and shifted.
What does not pass ``_is_sound`` is thrown away and drawn again, so every office that comes
out is connected for a disc of ``CLEAR_M`` with the chords shut.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely.geometry import MultiLineString, Point, Polygon
from shapely.geometry.polygon import orient
from shapely.ops import polylabel, unary_union

from cogmap_gym.geometry import Points, Pose
from cogmap_gym.office_doors import Doorway, doorways
from cogmap_gym.office_furniture import Scene, furnish
from cogmap_gym.office_layout import DECIMALS, DIFFICULTIES, Difficulty, Rng, Space, layout
from cogmap_gym.office_shapes import irregular

TEST_SEEDS = range(1000)
"""Offices for reports alone: nothing is chosen by looking at them."""
DEVELOPMENT_SEEDS = range(1000, 1_000_000)
"""Offices by which programs and parameters are made and chosen."""
DEFAULT_DIFFICULTY = "medium"
"""Of ``"office:SEED"``."""
WALLS = (0.1, 0.12, 0.16, 0.2, 0.24)
"""Thicknesses of walls [m]; an office has one of them."""
CLEAR_M = 0.36
"""Every way leaves room for a disc of this radius [m]: the robot's 0.25 and a margin."""
TIGHT_M = 0.24
"""Where a disc of this radius passes, one of ``CLEAR_M`` does [m]."""
NOOK_M2 = 0.04
"""Of what the first disc sweeps, no part larger than this [m^2] is lost to the other: in the
corner of a room that is 0.01."""
HOME_M = 0.5
"""Home has at least this to all sides [m]."""
CENTRED_M = 1.0
"""Home is the centroid of its room where that leaves this to the room's walls [m]."""
LABEL_M = 0.05
"""How exactly the point farthest from the walls is found otherwise [m]."""
LEAF_M = 0.01
"""Half of what a shut door takes [m]."""
FARTHEST = 50.0
"""Largest shift of an office along x and y [m]."""
EXACT = 9
"""Decimals of a coordinate once turned [-]: 1 nm, so that rooms still meet at doors."""
STRAIGHT_M2 = 1e-7
"""A ring goes straight on at a point where it and its neighbours span less than this [m^2]."""
DRAWS = 100
"""An office is given up after this many draws; nineteen in twenty serve [-]."""
_NAME = re.compile(r"office:(\d{1,6})(?::([a-z]+))?")


def is_office(source: object) -> bool:
    """Whether a map's name asks for an office of this module."""
    return isinstance(source, str) and source.startswith("office:")


def office(name: str) -> dict[str, Any]:
    """The mapping of a plan: ``FloorPlan.load(name)`` makes the plan of it.

    The rooms are called R1, R2, ..., the corridors C1, C2, ...; the doors that are open at
    first E1, E2, ..., and the chords, which are shut at first and whose opening makes
    short-cuts, S1, S2, .... There are no barriers. The same name gives the same plan.

    Args:
        name: ``"office:SEED"`` or ``"office:SEED:DIFFICULTY"``: seed 0 to 999999,
            difficulty ``easy``, ``medium`` (if left out) or ``hard``.

    Raises:
        ValueError: another name.
    """
    match = _NAME.fullmatch(name)
    level = (match.group(2) or DEFAULT_DIFFICULTY) if match else ""
    if match is None or level not in DIFFICULTIES:
        raise ValueError(
            f"map: expected office:SEED or office:SEED:DIFFICULTY with a seed of 0 to 999999 "
            f"and one of {tuple(DIFFICULTIES)}, got {name!r}"
        )
    rng = np.random.default_rng((int(match.group(1)), tuple(DIFFICULTIES).index(level)))
    for _ in range(DRAWS):
        draft = _draft(DIFFICULTIES[level], rng)
        if draft is not None and _is_sound(draft):
            return _turned(draft, name, rng)
    raise AssertionError(f"no draw of {name} was sound")


@dataclass(frozen=True, slots=True, eq=False)
class _Draft:
    """An office before it is turned; lengths in metres."""

    rooms: dict[str, Polygon]
    """By name, each with its parts of the doorways."""
    bare: Polygon
    """All of them, less pillars and pilasters."""
    furniture: list[Polygon]
    doors: list[Doorway]
    """Open at first."""
    chords: list[Doorway]
    """Shut at first."""
    home: Points
    """Shape (2,)."""


def _draft(difficulty: Difficulty, rng: Rng) -> _Draft | None:
    """One draw; None if no doors could be found or the walls cut it apart."""
    wall = float(rng.choice(WALLS))
    spaces = irregular(layout(difficulty, wall, rng), difficulty.irregular, rng)
    found = doorways(spaces, wall, difficulty, rng)
    if found is None:
        return None
    doors = [*found[0], *found[1]]
    floors = [_floor(space, k, wall, doors) for k, space in enumerate(spaces)]
    rooms = [k for k, space in enumerate(spaces) if not space.is_corridor]
    home = _middle(floors[int(rng.choice(rooms))])
    clear = unary_union([MultiLineString([door.leaf for door in doors]), Point(home)])
    scenes = [Scene.of(floor, clear) for floor in floors]
    for scene, space in zip(scenes, spaces, strict=True):
        pieces = round(scene.floor.area / difficulty.piece_area + rng.uniform(-0.5, 0.5))
        furnish(scene, pieces, rng, is_corridor=space.is_corridor)
    solids = unary_union([piece for scene in scenes for piece in scene.solids])
    bare = unary_union([*floors, *(door.opening for door in doors)]).difference(solids)
    furniture = [piece for scene in scenes for piece in scene.furniture]
    if bare.geom_type != "Polygon":
        return None
    return _Draft(_named(spaces, floors), bare, furniture, *found, home)


def _floor(space: Space, k: int, wall: float, doors: list[Doorway]) -> Polygon:
    """A space between its walls, with its parts of the doorways."""
    drawn_in = space.outline.buffer(-wall / 2.0, join_style="mitre")
    inside = shapely.transform(drawn_in, lambda points: np.round(points, DECIMALS))
    return unary_union([inside, *(door.share(k) for door in doors if k in door.sides)])


def _named(spaces: list[Space], floors: list[Polygon]) -> dict[str, Polygon]:
    corridors = sum(space.is_corridor for space in spaces)
    names = [f"C{k + 1}" if k < corridors else f"R{k + 1 - corridors}" for k in range(len(spaces))]
    return dict(zip(names, floors, strict=True))


def _middle(floor: Polygon) -> Points:
    """A point well inside a room, shape (2,) [m]."""
    point = floor.centroid
    if not floor.covers(point) or floor.exterior.distance(point) < CENTRED_M:
        point = polylabel(floor, LABEL_M)
    middle: Points = np.round(shapely.get_coordinates(point)[0], DECIMALS)
    return middle


def _is_sound(draft: _Draft) -> bool:
    """Whether all can be reached, and no way is neither wide nor shut."""
    if any(floor.geom_type != "Polygon" or floor.interiors for floor in draft.rooms.values()):
        return False
    free = draft.bare.difference(unary_union(draft.furniture))
    roomy, tight = free.buffer(-CLEAR_M), free.buffer(-TIGHT_M)
    shut = MultiLineString([chord.leaf for chord in draft.chords]).buffer(LEAF_M)
    first = free.difference(shut).buffer(-CLEAR_M)
    return bool(
        roomy.geom_type == tight.geom_type == first.geom_type == "Polygon"
        and len(roomy.interiors) == len(tight.interiors)
        and _largest(tight.buffer(TIGHT_M).difference(roomy.buffer(CLEAR_M + LEAF_M))) < NOOK_M2
        and all(floor.intersection(first).area > HOME_M for floor in draft.rooms.values())
        and free.boundary.distance(Point(draft.home)) >= HOME_M
    )


def _largest(area: shapely.Geometry) -> float:
    """Area of the largest part [m^2]."""
    return max((float(part.area) for part in shapely.get_parts(area)), default=0.0)


def _turned(draft: _Draft, name: str, rng: Rng) -> dict[str, Any]:
    """The mapping of a plan, the draft turned and shifted by chance."""
    heading, degrees = rng.uniform(-math.pi, math.pi), float(np.round(rng.uniform(-180, 180), 1))
    x, y = map(float, rng.uniform(-FARTHEST, FARTHEST, 2))
    pose = Pose(x, y, float(heading))

    def moved(points: Points) -> list[Any]:
        return np.round(pose.apply(points), EXACT).tolist()  # type: ignore[no-any-return]

    named = {f"E{k}": door for k, door in enumerate(draft.doors, 1)}
    chords = {f"S{k}": chord for k, chord in enumerate(draft.chords, 1)}
    rings = orient(draft.bare)
    return {
        "name": name,
        "walls": [moved(_closed(_corners(r))) for r in (rings.exterior, *rings.interiors)],
        "furniture": [moved(_corners(orient(piece).exterior)) for piece in draft.furniture],
        "doors": {key: moved(door.leaf) for key, door in (named | chords).items()},
        "closed": list(chords),
        "barriers": {},
        "rooms": {key: moved(_corners(orient(f).exterior)) for key, f in draft.rooms.items()},
        "home": [*moved(draft.home), degrees],
    }


def _corners(ring: shapely.LinearRing) -> Points:
    """The points of a ring at which it turns, shape (K, 2), the first not repeated [m]."""
    points: Points = shapely.get_coordinates(ring)[:-1]
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    corners: Points = points[np.abs(turns) > STRAIGHT_M2]
    return corners


def _closed(points: Points) -> Points:
    return np.concatenate((points, points[:1]))
