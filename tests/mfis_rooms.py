"""Random rooms, and the MFIS a robot would have of them when it leaves.

A stand-in for laser and mapping: exact ray casting from the points of a path, walls kept
as the noisy pieces that were seen.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import networkx as nx
import numpy as np
import shapely
from shapely.geometry.polygon import orient

from cogmap_gym.geometry import Points, Segments
from tests.mfis_mapping import faces, mapped, seen

WALL = 0.2
"""Thickness of walls [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """One ASR to be cut, and the truth."""

    kind: str
    room: shapely.Polygon
    furniture: shapely.Geometry
    surfaces: Segments
    exit_crossed: Points
    other_exits: Segments
    path: Points
    seen: float
    """Share of the room that came into view."""


def make_scene(rng: np.random.Generator, kind: str | None = None) -> Scene:
    """A random room with furniture and neighbours, as mapped by a robot that crosses it."""
    kind = kind or str(rng.choice(["rect", "ell", "corridor", "home"]))
    while True:
        scene = _try_scene(rng, kind)
        if scene is not None:
            return scene


def _try_scene(rng: np.random.Generator, kind: str) -> Scene | None:
    room = _room(rng, kind)
    doors = _doors(rng, room, int(rng.integers(2, 6 if kind == "corridor" else 4)))
    if len(doors) < 2:
        return None
    furniture = _furniture(rng, room, doors, kind)
    free = room.difference(furniture)
    beyond = _neighbours(rng, room, doors)
    free = shapely.union_all([free, *beyond])
    path = _path(rng, room.difference(furniture), doors, kind)
    if path is None or not isinstance(free, shapely.Polygon):
        return None
    walls = faces(free)
    surfaces = mapped(rng, walls, path, look_round=kind == "home")
    exits = [_noisy_exit(rng, d) for d in doors]
    known = [
        e
        for k, e in enumerate(exits)
        if k > 0 and ((k == 1 and kind != "home") or rng.random() < 0.9)
    ]
    known_exits = np.array(known) if known else np.zeros((0, 2, 2))
    share = seen(walls, room, path, kind == "home")
    path = path + rng.normal(0.0, 0.02, path.shape)
    return Scene(kind, room, furniture, surfaces, exits[0], known_exits, path, share)


def _room(rng: np.random.Generator, kind: str) -> shapely.Polygon:
    if kind == "corridor":
        room = shapely.box(0, 0, rng.uniform(8, 24), rng.uniform(1.8, 2.4))
    else:
        w, h = rng.uniform(4, 10), rng.uniform(3.5, 8)
        room = shapely.box(0, 0, w, h)
        if kind == "ell":
            room = shapely.box(0, 0, w + 2, h + 2).difference(
                shapely.box(rng.uniform(0.4, 0.7) * w, rng.uniform(0.4, 0.7) * h, 99, 99)
            )
    room = shapely.affinity.rotate(room, float(rng.choice([0, 90, 180, 270])), origin=(0, 0))
    return orient(shapely.affinity.rotate(room, rng.normal(0, 3), origin=(0, 0)))


def _doors(rng: np.random.Generator, room: shapely.Polygon, wanted: int) -> list[Points]:
    """Doors in the walls: (2, 2), along the wall, the room on the left."""
    ring = np.array(room.exterior.coords)
    doors: list[Points] = []
    for _ in range(60):
        k = int(rng.integers(len(ring) - 1))
        along = ring[k + 1] - ring[k]
        size, width = float(np.hypot(*along)), rng.uniform(0.8, 1.0)
        if size < width + 0.6:
            continue
        at = rng.uniform(0.3, size - width - 0.3)
        start = ring[k] + along / size * at
        door = np.array((start, start + along / size * width))
        if all(np.hypot(*(door.mean(0) - d.mean(0))) > 2.0 for d in doors):
            doors.append(door)
        if len(doors) == wanted:
            break
    return doors


def _outward(door: Points) -> Points:
    along = (door[1] - door[0]) / np.hypot(*(door[1] - door[0]))
    return np.array((along[1], -along[0]))


def _neighbours(
    rng: np.random.Generator, room: shapely.Polygon, doors: list[Points]
) -> list[shapely.Geometry]:
    """Passages through the wall and spaces beyond them."""
    taken = room.buffer(WALL, join_style="mitre")
    out = []
    for door in doors:
        o = _outward(door)
        along = (door[1] - door[0]) / np.hypot(*(door[1] - door[0]))
        left, right, deep = rng.uniform(0.6, 3), rng.uniform(0.6, 3), rng.uniform(2, 6)
        base = WALL * o
        space = shapely.Polygon(
            [
                door[0] - left * along + base,
                door[1] + right * along + base,
                door[1] + right * along + deep * o,
                door[0] - left * along + deep * o,
            ]
        ).difference(taken)
        parts = getattr(space, "geoms", [space])
        part = max(
            parts, key=lambda g: g.buffer(0.01).intersection(shapely.LineString(door + base)).length
        )
        taken = taken.union(part.buffer(WALL, join_style="mitre"))
        passage = shapely.Polygon(
            [door[0] - 0.01 * o, door[1] - 0.01 * o, door[1] + 1.01 * base, door[0] + 1.01 * base]
        )
        out += [passage, part]
    return out


def _furniture(
    rng: np.random.Generator, room: shapely.Polygon, doors: list[Points], kind: str
) -> shapely.Geometry:
    keep_free = shapely.union_all([shapely.LineString(d).buffer(1.0) for d in doors])
    pieces: list[shapely.Geometry] = []
    ring = np.array(room.exterior.coords)
    for _ in range(int(rng.integers(0, 3 if kind == "corridor" else 6))):
        if kind != "corridor" and rng.random() < 0.35:  # in the middle
            x, y = rng.uniform(room.bounds[:2], room.bounds[2:])
            size = rng.uniform(0.3, 1.6, 2)
            piece = shapely.affinity.rotate(
                shapely.box(x, y, x + size[0], y + size[1]), rng.uniform(0, 90)
            )
            if not room.buffer(-1.0).contains(piece):
                continue
        else:
            k = int(rng.integers(len(ring) - 1))
            along = ring[k + 1] - ring[k]
            size = float(np.hypot(*along))
            along, into = along / size, np.array((-along[1], along[0])) / size
            long, deep = rng.uniform(0.5, 1.8), rng.uniform(0.3, 0.5 if kind == "corridor" else 0.8)
            if size < long + 0.4:
                continue
            at = ring[k] + rng.uniform(0.0, size - long) * along - 0.01 * into
            piece = shapely.Polygon(
                [at, at + long * along, at + long * along + deep * into, at + deep * into]
            )
        if piece.intersects(keep_free) or any(piece.distance(p) < 1.0 for p in pieces):
            continue
        pieces.append(piece.intersection(room))
    return shapely.union_all(pieces) if pieces else shapely.Polygon()


def _path(
    rng: np.random.Generator, free: shapely.Geometry, doors: list[Points], kind: str
) -> Points | None:
    """From the entry (or home) by way of some points to beyond the first door."""
    if not isinstance(free, shapely.Polygon):
        return None

    def spot() -> Points:
        while True:
            p = rng.uniform(free.bounds[:2], free.bounds[2:])
            if free.contains(shapely.Point(p).buffer(0.45)):
                return p

    if free.buffer(-0.5).is_empty:
        return None
    begin = (
        spot() if kind == "home" else doors[1].mean(0) - rng.uniform(0.1, 0.4) * _outward(doors[1])
    )
    stops = [begin, *(spot() for _ in range(int(rng.integers(0, 3))))]
    stops.append(doors[0].mean(0) - 0.5 * _outward(doors[0]))
    hull = free.buffer(-0.3, join_style="mitre")
    roomy = shapely.union_all(
        [
            hull,
            *(
                shapely.LineString([d.mean(0), d.mean(0) - 0.6 * _outward(d)]).buffer(0.1)
                for d in doors
            ),
        ]
    )
    nodes = (
        [np.array(c) for ring in (hull.exterior, *hull.interiors) for c in ring.coords[:-1]]
        if isinstance(hull, shapely.Polygon)
        else None
    )
    if nodes is None:
        return None
    points = [*stops, *nodes]
    graph = nx.Graph()
    for i, j in itertools.combinations(range(len(points)), 2):
        line = shapely.LineString((points[i], points[j]))
        if roomy.buffer(0.02).contains(line):
            graph.add_edge(i, j, weight=line.length)
    way: list[Points] = [stops[0]]
    for i in range(len(stops) - 1):
        if not (graph.has_node(i) and graph.has_node(i + 1) and nx.has_path(graph, i, i + 1)):
            return None
        way += [points[k] for k in nx.shortest_path(graph, i, i + 1, weight="weight")[1:]]
    way.append(doors[0].mean(0) + rng.uniform(0.3, 0.6) * _outward(doors[0]))
    line = shapely.LineString(way)
    if line.length < 2.0:
        return None
    at = np.concatenate((np.arange(0.0, line.length, 1.5), [line.length]))
    at = np.unique(np.concatenate((at, [line.project(shapely.Point(w)) for w in way])))
    return np.array([line.interpolate(a).coords[0] for a in at])


def _noisy_exit(rng: np.random.Generator, door: Points) -> Points:
    """Where the robot has an exit: somewhere in the depth of the wall, jambs in any order."""
    out = door + rng.uniform(0.0, WALL) * _outward(door) + rng.normal(0.0, 0.03, (2, 2))
    return out if rng.random() < 0.5 else out[::-1].copy()


def overlap(boundary: Points, scene: Scene) -> float:
    """Intersection over union with the true room, furniture taken out of both; 0 if open."""
    if len(boundary) < 3:
        return 0.0
    mine = shapely.Polygon(boundary).buffer(0).difference(scene.furniture)
    true = scene.room.difference(scene.furniture)
    return float(mine.intersection(true).area / mine.union(true).area)
