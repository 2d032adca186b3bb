"""What a robot sees of walls along a path, entered into an MFIS with the map's noise."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.polygon import orient

from cogmap_gym.geometry import Points, Segments

LEAST_PIECE = 0.5
"""Shorter pieces are not in an MFIS [m]."""


def faces(free: shapely.Polygon) -> Segments:
    """Wall faces of free space, directed with it on the left."""
    free = orient(free.simplify(0.005))
    rings = [np.array(r.coords) for r in (free.exterior, *free.interiors)]
    return np.concatenate([np.stack((r[:-1], r[1:]), axis=1) for r in rings])


def _cast(
    walls: Segments, eye: Points, angles: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The wall each ray hits first (-1: none) and where along it (share)."""
    d = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    p, s = walls[:, 0] - eye, walls[:, 1] - walls[:, 0]
    den = d[:, None, 0] * s[:, 1] - d[:, None, 1] * s[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (p[:, 0] * s[:, 1] - p[:, 1] * s[:, 0]) / den
        u = (p[:, 0] * d[:, None, 1] - p[:, 1] * d[:, None, 0]) / den
    t = np.where((t > 1e-6) & (u >= 0) & (u <= 1) & np.isfinite(t), t, np.inf)
    hit = t.argmin(axis=1)
    rows = np.arange(len(d))
    return np.where(np.isfinite(t[rows, hit]), hit, -1), u[rows, hit]


def _looks(path: Points, look_round: bool) -> list[tuple[Points, NDArray[np.float64]]]:
    """Where the robot looked from, and its beams: 180 degrees ahead, at home all round."""
    ways = np.diff(path, axis=0)
    headings = np.arctan2(ways[:, 1], ways[:, 0])
    poses = [(p, h) for p, h in zip(path, [*headings, headings[-1]], strict=True)]
    if look_round:
        poses += [(path[0], h) for h in (0.0, np.pi)]
    return [(eye, heading + np.deg2rad(np.arange(-90, 90, 0.5))) for eye, heading in poses]


def seen(walls: Segments, room: shapely.Polygon, path: Points, look_round: bool) -> float:
    """Share of the room's area that came into view before the last point."""
    fans = []
    for eye, angles in _looks(path, look_round):
        hit, u = _cast(walls, eye, angles)
        ends = walls[hit, 0] + u[:, None] * (walls[hit, 1] - walls[hit, 0])
        fans.append(shapely.Polygon((eye, *ends[hit >= 0])).buffer(0))
    return float(shapely.union_all(fans).intersection(room).area / room.area)


def mapped(rng: np.random.Generator, walls: Segments, path: Points, look_round: bool) -> Segments:
    """The pieces of walls seen from the path with 180 degrees ahead, as an MFIS has them."""
    seen: list[list[tuple[float, float]]] = [[] for _ in walls]
    for eye, angles in _looks(path, look_round):
        hit, u = _cast(walls, eye, angles)
        start = 0
        for k in range(1, len(hit) + 1):
            if k == len(hit) or hit[k] != hit[start]:
                if hit[start] >= 0 and k - start >= 4:
                    seen[hit[start]].append((u[start:k].min(), u[start:k].max()))
                start = k
    out: list[Points] = []
    for wall, spans in zip(walls, seen, strict=True):
        size = float(np.hypot(*(wall[1] - wall[0])))
        for a, b in _merged(spans, 0.3 / size):
            if (b - a) * size >= LEAST_PIECE:
                out += _entered(rng, wall, a * size, b * size)
    return np.array(out) if out else np.zeros((0, 2, 2))


def _merged(spans: list[tuple[float, float]], gap: float) -> list[tuple[float, float]]:
    out: list[tuple[float, float]] = []
    for a, b in sorted(spans):
        if out and a <= out[-1][1] + gap:
            out[-1] = (out[-1][0], max(b, out[-1][1]))
        else:
            out.append((a, b))
    return out


def _entered(rng: np.random.Generator, wall: Points, a: float, b: float) -> list[Points]:
    """One piece as the map has it: one in ten split, one in twenty doubled.

    One in ten of those under 3 m is lost.
    """
    chance, pieces = rng.random(), [(a, b)]
    if chance < 0.1 and b - a < 3.0:
        pieces = []
    elif 0.1 <= chance < 0.2 and b - a > 2.0:
        cut = rng.uniform(a + 0.5, b - 1.5)
        pieces = [(a, cut), (cut + rng.uniform(0.3, 1.0), b)]
    elif 0.2 <= chance < 0.25 and b - a > 1.5:
        cut = rng.uniform(a + 0.6, b - 0.6)
        pieces = [(a, cut + rng.uniform(0.0, 0.5)), (cut, b)]
    return [_noisy(rng, wall, p, q) for p, q in pieces if q - p >= LEAST_PIECE]


def _noisy(rng: np.random.Generator, wall: Points, a: float, b: float) -> Points:
    """A piece of wall, shifted by 4 cm, turned by 0.5 degrees, ends moved by 8 cm (sd)."""
    along = (wall[1] - wall[0]) / np.hypot(*(wall[1] - wall[0]))
    ends = np.array((a, b)) + rng.normal(0.0, 0.08, 2)
    side = rng.normal(0.0, 0.04) + np.array((-0.5, 0.5)) * (b - a) * np.deg2rad(rng.normal(0, 0.5))
    normal = np.array((-along[1], along[0]))
    return np.asarray(wall[0] + ends[:, None] * along + side[:, None] * normal)
