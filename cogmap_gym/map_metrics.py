"""How good a map of surfaces is: which true wall each surface shows, and how often over.

Its true wall is the face nearest its points under the true pose when it was seen. Faces in line
in one room are one *wall line*: a wall goes on behind a doorway, a shut leaf or a pillar.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from cogmap_gym.edit_log import Edit
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import (
    Array,
    Pose,
    Segments,
    cross,
    headings,
    lengths,
    midpoints,
    point_segment_distances,
    wrap_angles,
)

Ints = NDArray[np.int64]
NO_WALL = -1
"""The wall line of a surface that shows no wall: a phantom."""
SIDE_M = 0.05
"""How far before a face one looks for free space [m]. Ours: under half of any wall's thickness."""
SHARES = np.array((0.25, 0.5, 0.75))
"""Where along a face one looks for free space [-]. Ours."""
POINT_SHARES = np.linspace(0.05, 0.95, 10)
"""Where along a surface its points are taken [-]. Ours."""
REACH_M = 0.3
"""A surface farther from every wall is a phantom [m]. Ours: 25 noise sds of a range."""
FACE_TURN = 0.5236
"""A surface shows a face turned from it by at most 30 degrees [rad]. Ours: short surfaces."""
LINE_OFFSET_M = 0.3
"""Faces of one wall line are so near in line [m]. Issue 2: as near as a map tells them."""
LINE_TURN = 0.1745
"""And turned by at most 10 degrees [rad]. Issue 2."""
LINE_GAP_M = 1.3
"""And part by no more than a doorway with its jambs [m]. DESIGN 4: doorways are 0.8-1.0 m."""


@dataclass(frozen=True, slots=True, eq=False)
class WallFaces:
    """All faces that a laser can see, in the plan's frame."""

    segments: Segments
    """(F, 2, 2), free space on the left."""
    line: Ints
    """(F,): the number of the wall line each belongs to, from 0."""
    door: tuple[str, ...]
    """Of each face the door whose leaf it is, or ``""``."""

    def present(self, shut: Collection[str]) -> NDArray[np.bool_]:
        """(F,): which faces stand while these doors are shut."""
        return np.array([not name or name in shut for name in self.door], dtype=np.bool_)


def wall_faces(plan: FloorPlan) -> WallFaces:
    """The visible sides of walls, furniture and door leaves; furniture joins no wall line."""
    solid, leaves = plan.walls_and_furniture(), plan.door_segments()
    both = np.concatenate((solid, solid[:, ::-1], leaves, leaves[:, ::-1]))
    doors = ("",) * (2 * len(solid)) + 2 * plan.door_names
    along = both[:, 1] - both[:, 0]
    left = np.stack((-along[:, 1], along[:, 0]), axis=1) / lengths(both)[:, None]
    before = both[:, None, 0] + SHARES[:, None] * along[:, None] + SIDE_M * left[:, None]
    free = shapely.intersects_xy(plan.free_space(), before[..., 0], before[..., 1])
    kept = np.flatnonzero(free.any(axis=1))
    pieces = len(plan.furniture_segments())
    walls = len(solid) - pieces
    counts = (walls, pieces, walls, pieces, 2 * len(leaves))
    alone = np.repeat((False, True, False, True, False), counts)
    owner = [f"piece {row}" if alone[row] else _room(plan, before[row][free[row]]) for row in kept]
    faces = both[kept]
    return WallFaces(faces, _lines(faces, owner), tuple(doors[row] for row in kept))


def _room(plan: FloorPlan, points: Array) -> str:
    """The first room that holds one of the points."""
    return next(filter(None, (plan.room_at(float(x), float(y)) for x, y in points)), "")


def _lines(faces: Segments, owners: Sequence[str]) -> Ints:
    """Number the wall lines: what is in line, near and of one owner hangs together."""
    size, heading, middle = lengths(faces), headings(faces), midpoints(faces)
    unit = (faces[:, 1] - faces[:, 0]) / size[:, None]
    between = middle[None] - middle[:, None]
    offset = np.abs(cross(unit[:, None], between))
    ahead = np.abs((unit[:, None] * between).sum(-1))
    gap = ahead - 0.5 * (size[:, None] + size[None])
    turn = np.abs(wrap_angles(heading[None] - heading[:, None]))
    name = np.array(owners)
    one = (np.maximum(offset, offset.T) <= LINE_OFFSET_M) & (np.maximum(gap, gap.T) <= LINE_GAP_M)
    one &= (turn <= LINE_TURN) & (name[:, None] == name[None])
    return connected_components(one, directed=False)[1].astype(np.int64)


def true_lines(surfaces: Segments, faces: WallFaces, shut: Collection[str]) -> Ints:
    """The wall line that each surface truly shows.

    Each of ten points along a surface votes for the face nearest to it, among those that
    stand, are seen from their free side, and are turned by at most 30 degrees.

    Args:
        surfaces: (N, 2, 2), free space on the left, laid by the true pose.
        faces: of the plan.
        shut: names of the doors that were shut.

    Returns:
        (N,): wall lines, ``NO_WALL`` where no face lies within 0.3 m.
    """
    if len(surfaces) == 0:
        return np.zeros(0, dtype=np.int64)
    along = surfaces[:, 1] - surfaces[:, 0]
    points = surfaces[:, None, 0] + POINT_SHARES[:, None] * along[:, None]
    gaps = point_segment_distances(points.reshape(-1, 2), faces.segments)
    gaps = gaps.reshape(len(surfaces), len(POINT_SHARES), -1)
    turn = wrap_angles(headings(surfaces)[:, None] - headings(faces.segments))
    fits = (np.abs(turn) <= FACE_TURN) & faces.present(shut)
    gaps = np.where(fits[:, None], gaps, np.inf)
    nearest, reach = gaps.argmin(axis=2), gaps.min(axis=2)
    near = (n[r <= REACH_M] for n, r in zip(nearest, reach, strict=True))
    return np.array([_vote(faces.line[rows]) for rows in near], dtype=np.int64)


def _vote(lines: Ints) -> int:
    return int(np.bincount(lines).argmax()) if len(lines) else NO_WALL


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """Where a surface of the map truly comes from."""

    step: int
    """When it was entered."""
    line: int
    """The wall line it truly shows, or ``NO_WALL``."""
    in_map: Segments
    """(2, 2): as it was entered."""
    in_plan: Segments
    """(2, 2): the same, moved to where its sighting truly was."""


def origins(
    edits: Iterable[Edit],
    poses: Array,
    mapped: Array,
    shut: Sequence[Collection[str]],
    faces: WallFaces,
) -> dict[int, Origin]:
    """The origin of each surface, by id, from the edit log and the true poses.

    Args:
        edits: the whole log.
        poses: (T, 3) true poses.
        mapped: (T, 3) poses by which the robot laid each view into its map.
        shut: at each step, the doors that were shut.
        faces: of the plan.
    """
    found: dict[int, Origin] = {}
    for edit in edits:
        if edit.before is None:
            at = edit.sighted
            plan_from_robot = Pose(*poses[at].tolist())
            plan_from_map = plan_from_robot @ Pose(*mapped[at].tolist()).inverse()
            true = plan_from_robot.apply(edit.in_view)
            line = int(true_lines(true[None], faces, shut[at])[0])
            found[edit.id] = Origin(edit.step, line, edit.after, plan_from_map.apply(edit.after))
    return found


def cover_ratios(
    surfaces: Segments, ids: Ints, origin: Mapping[int, Origin], faces: WallFaces
) -> Array:
    """Along each wall line, the summed length of its surfaces over the length of their union.

    Each surface lies where it truly was when entered, as long as it is in the map now. 1
    means that nothing is there twice.

    Args:
        surfaces: (N, 2, 2) of the map, those forgotten left out.
        ids: (N,) their ids.
        origin: of each surface, by id.
        faces: of the plan.

    Returns:
        (L,): one ratio, >= 1, for each wall line that has a surface.
    """
    spans: dict[int, list[tuple[float, float]]] = {}
    for surface, number in zip(surfaces, ids, strict=True):
        known = origin[int(number)]
        if known.line != NO_WALL:
            start, end = sorted((in_plan(surface, known) @ _direction(faces, known.line)).tolist())
            spans.setdefault(known.line, []).append((start, end))
    return np.array([_summed_over_union(span) for span in spans.values()])


def shows_again(
    seen: Segments, line: int, known: Origin, surface: Segments, faces: WallFaces
) -> bool:
    """Whether a view shows again the piece of wall that a surface of the map stands for.

    They show the same wall line, and truly overlap along it or part by no more than a doorway.

    Args:
        seen: (2, 2) a surface of the view, laid by the true pose.
        line: the wall line that it truly shows.
        known: the origin of the map's surface.
        surface: (2, 2) the map's surface now.
        faces: of the plan.
    """
    if line == NO_WALL or line != known.line:
        return False
    unit = _direction(faces, line)
    old, new = in_plan(surface, known) @ unit, seen @ unit
    return bool(max(old.min() - new.max(), new.min() - old.max()) <= LINE_GAP_M)


def in_plan(surface: Segments, known: Origin) -> Segments:
    """Where a surface (2, 2) of the map truly is, by its true place when entered."""
    grown = (surface - known.in_map[0]) @ _unit(known.in_map)
    return np.asarray(known.in_plan[0] + grown[:, None] * _unit(known.in_plan))


def _unit(segment: Segments) -> Array:
    return np.asarray((segment[1] - segment[0]) / lengths(segment[None])[0])


def _direction(faces: WallFaces, line: int) -> Array:
    """The unit vector of the longest face of a wall line."""
    own = faces.segments[faces.line == line]
    return _unit(own[lengths(own).argmax()])


def _summed_over_union(spans: list[tuple[float, float]]) -> float:
    summed, union, reached = 0.0, 0.0, -np.inf
    for start, end in sorted(spans):
        summed += end - start
        union += max(0.0, end - max(start, reached))
        reached = max(reached, end)
    return summed / union
