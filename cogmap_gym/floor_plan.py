"""The plan of a building: walls, furniture, doors, barriers, rooms and the robot's home.

Lengths are metres in the plan's own frame, x to the right and y up on a drawing. A plan
is frozen and its arrays are read-only. Files are read and written in ``cogmap_gym.plan_file``,
their keys checked in ``cogmap_gym.plan_schema``; ``maps/README.md`` describes the format.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Point, Polygon, box

from cogmap_gym import importers, plan_file, plan_schema
from cogmap_gym.free_space import free_space
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments, point_segment_distances
from cogmap_gym.observation import RobotSpec

DOOR_REACH = 0.05
"""How far an end of a door may lie from the nearest wall [m]. Ours: drawing precision."""
DEGREE_DECIMALS = 12
"""Decimals of a heading in a file, so that 30 degrees stays 30.0 [-]. Ours."""

_NAMED = ("doors", "barriers", "rooms")
"""The fields that map names to points."""


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """A building as the world and the scores know it; each way to make one checks it."""

    name: str
    """What the plan is called."""
    walls: tuple[Points, ...]
    """Polylines, each (K, 2) with K >= 2 [m]; thin lines, or outlines of thick walls."""
    furniture: tuple[Points, ...]
    """Polygons, each (K, 2) with K >= 3 [m]."""
    doors: Mapping[str, Points]
    """Door leaves when shut, each (2, 2) [m]."""
    closed: tuple[str, ...]
    """Names of the doors that are shut at first."""
    barriers: Mapping[str, Points]
    """What an event may place to block a way, each (2, 2) [m]."""
    rooms: Mapping[str, Points]
    """The true local spaces, polygons (K, 2) with K >= 3 [m]; for scores alone."""
    home: Pose
    """Where a robot starts."""
    origin: str = "plan"
    """Where the plan comes from, for messages: a file, or ``"mapping"``."""

    def __post_init__(self) -> None:
        """Freeze the fields and check how they lie to one another.

        Raises:
            ValueError: naming the origin, the key and the value.
        """
        for key in ("walls", "furniture"):
            object.__setattr__(self, key, tuple(map(_frozen, getattr(self, key))))
        for key in _NAMED:
            frozen = {name: _frozen(points) for name, points in getattr(self, key).items()}
            object.__setattr__(self, key, MappingProxyType(frozen))
        object.__setattr__(self, "closed", tuple(self.closed))
        plan_schema.parse(self.to_mapping(), self.origin)
        _check_doors(self)
        _check_home(self)

    def __reduce__(self) -> tuple[Any, ...]:
        fields = {**self.__dict__, **{key: dict(getattr(self, key)) for key in _NAMED}}
        return _restored, ({k: v for k, v in fields.items() if k != "_room_polygons"},)

    @staticmethod
    def load(source: str | Path | Mapping[str, Any] | FloorPlan) -> FloorPlan:
        """The plan that ``source`` stands for.

        Args:
            source: a name under ``maps/`` such as ``"thesis_office"``, the path of a plan in a
                format that ``cogmap_gym.importers`` reads, ``"office:SEED"`` for a generated
                one, the mapping of a plan or of a bitmap, or a plan, returned as it is.

        Raises:
            ValueError: no such plan, or one that breaks the format; names file, key, value.
        """
        if isinstance(source, FloorPlan):
            return source
        return FloorPlan.from_mapping(*importers.mapping_of(source))

    @staticmethod
    def from_mapping(mapping: Mapping[str, Any], origin: str = "mapping") -> FloorPlan:
        """The plan of a mapping with the keys of the file format.

        Args:
            mapping: lists of numbers in metres; the heading of ``home`` in degrees.
            origin: what messages call the mapping.

        Raises:
            ValueError: naming the origin, the key and the value.
        """
        fields = plan_schema.parse(mapping, origin)
        x, y, degrees = fields.pop("home")
        turn = math.remainder(degrees, 360.0)
        home = Pose(x, y, math.radians(turn if turn > -180.0 else 180.0))
        return FloorPlan(**fields, home=home, origin=origin)

    def to_mapping(self) -> dict[str, Any]:
        """The JSON-able mapping that ``from_mapping`` turns into this very plan."""
        degrees = round(math.degrees(self.home.theta), DEGREE_DECIMALS)
        return {
            "name": self.name,
            "walls": [points.tolist() for points in self.walls],
            "furniture": [points.tolist() for points in self.furniture],
            "doors": _lists(self.doors),
            "closed": list(self.closed),
            "barriers": _lists(self.barriers),
            "rooms": _lists(self.rooms),
            "home": [float(self.home.x), float(self.home.y), degrees],
        }

    def save(self, path: str | Path) -> None:
        """Write the plan as YAML; ``path`` holds the old or the whole new file, never a part."""
        plan_file.write(self.to_mapping(), Path(path))

    @property
    def door_names(self) -> tuple[str, ...]:
        """In the order of the file."""
        return tuple(self.doors)

    @property
    def barrier_names(self) -> tuple[str, ...]:
        """Names of the barriers, in the order of the file."""
        return tuple(self.barriers)

    @cached_property
    def room_names(self) -> tuple[str, ...]:
        """Names of the rooms, in the order of the file."""
        return tuple(self.rooms)

    def wall_segments(self) -> Segments:
        """The edges of all wall polylines, shape (N, 2, 2)."""
        return _edges(self.walls)

    def furniture_segments(self) -> Segments:
        """The edges of all furniture, free space on their left, shape (N, 2, 2)."""
        rings = (Polygon(points).normalize().exterior for points in self.furniture)
        return _edges(shapely.get_coordinates(ring) for ring in rings)

    def walls_and_furniture(self) -> Segments:
        """What stands still and stops a beam or a body: walls, then furniture, (N, 2, 2)."""
        return np.concatenate((self.wall_segments(), self.furniture_segments()))

    def door_segments(self) -> Segments:
        """The leaves of all doors, in the order of ``door_names``, shape (N, 2, 2)."""
        return np.array(list(self.doors.values())).reshape(-1, 2, 2)

    def barrier_segments(self) -> Segments:
        """All barriers, in the order of ``barrier_names``, shape (N, 2, 2)."""
        return np.array(list(self.barriers.values())).reshape(-1, 2, 2)

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """The box about the walls: x least, y least, x most, y most [m]."""
        points = np.concatenate(self.walls)
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        return float(x0), float(y0), float(x1), float(y1)

    @property
    def area(self) -> float:
        """Area of the free space [m^2]."""
        return float(self.free_space().area)

    def free_space(self) -> Polygon:
        """Where a point gets to from home, all doors open: see ``cogmap_gym.free_space``."""
        return self._free_space

    def room_free_space(self, name: str) -> shapely.Geometry:
        """The polygon of a room less furniture and what walls stand in it.

        Raises:
            ValueError: no room of that name.
        """
        if name not in self.rooms:
            raise ValueError(f"rooms: expected one of {self.room_names}, got {name!r}")
        return Polygon(self.rooms[name]).intersection(self._free_space)

    def room_at(self, x: float, y: float) -> str | None:
        """Name of the first room that holds the point (x, y) [m], its edge included."""
        if not self.rooms:
            return None
        hits = shapely.intersects_xy(self._room_polygons, x, y)
        first = int(hits.argmax())
        return self.room_names[first] if hits[first] else None

    @cached_property
    def _room_polygons(self) -> NDArray[np.object_]:
        polygons = np.array([Polygon(points) for points in self.rooms.values()], dtype=object)
        shapely.prepare(polygons)
        return polygons

    @cached_property
    def _free_space(self) -> Polygon:
        return free_space(self.walls, self.furniture, self.home.position)


def _restored(fields: dict[str, Any]) -> FloorPlan:
    """A plan that was pickled: it was checked when it was made."""
    plan = object.__new__(FloorPlan)
    for key, value in fields.items():
        if key in ("walls", "furniture"):
            value = tuple(map(_frozen, value))
        elif key in _NAMED:
            value = MappingProxyType({name: _frozen(line) for name, line in value.items()})
        object.__setattr__(plan, key, value)
    return plan


def _frozen(points: Any) -> Points:
    array = np.array(points, dtype=np.float64)
    array.setflags(write=False)
    return array


def _lists(named: Mapping[str, Points]) -> dict[str, Any]:
    return {name: points.tolist() for name, points in named.items()}


def _edges(polylines: Iterable[Points]) -> Segments:
    edges = [np.stack((line[:-1], line[1:]), axis=1) for line in polylines]
    return np.concatenate(edges) if edges else NO_SEGMENTS.copy()


def _check_doors(plan: FloorPlan) -> None:
    walls = plan.wall_segments()
    for name, ends in plan.doors.items():
        gaps = point_segment_distances(ends, walls).min(axis=1)
        if gaps.max() > DOOR_REACH:
            raise ValueError(
                f"{plan.origin}: doors.{name}: expected each end within {DOOR_REACH} m of a wall, "
                f"got {ends.tolist()}, {gaps.max():.3f} m away"
            )


def _check_home(plan: FloorPlan) -> None:
    where, radius = plan.home.position, RobotSpec().radius
    point, wrong = Point(where), ""
    if point_segment_distances(where[None], plan.walls_and_furniture()).min() < radius:
        wrong = f"{radius} m or more from walls and furniture"
    elif any(Polygon(points).covers(point) for points in plan.furniture):
        wrong = "outside the furniture"
    elif not box(*plan.bounds).covers(point):
        wrong = "between the outer walls"
    elif plan.rooms and not any(plan.room_free_space(name).area for name in plan.rooms):
        wrong = "outside the walls"
    if wrong:
        raise ValueError(f"{plan.origin}: home: expected {wrong}, got {where.tolist()}")
