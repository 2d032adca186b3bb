"""What a plan file may say, checked key by key.

How walls, doors and home lie to one another is checked in ``cogmap_gym.floor_plan``. Every
message names the file, the key and the value.
"""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from shapely.geometry import Polygon

from cogmap_gym.geometry import Points

KEYS = ("name", "walls", "furniture", "doors", "closed", "barriers", "rooms", "home")
"""The keys of a plan, all of them needed."""
MAX_POINTS = 1_000_000
"""Most points in one plan [-]. Ours: ten times the largest world that was timed."""
MAX_COORDINATE = 1e5
"""Largest coordinate [m]. Ours: 100 km; more is a wrong unit."""
SHOWN = 120
"""Most characters of a value that a message repeats [-]. Ours."""
_BRIEF = reprlib.Repr()
_BRIEF.maxlevel, _BRIEF.maxstring = 4, SHOWN


def parse(mapping: Mapping[str, Any], origin: str) -> dict[str, Any]:
    """Check every key by itself and turn lists of points into arrays.

    Args:
        mapping: what a file holds.
        origin: what messages call it.

    Returns:
        The same keys: ``walls`` and ``furniture`` tuples of (K, 2) arrays [m], ``doors``,
        ``barriers`` and ``rooms`` dicts of arrays, ``home`` as (x, y, degrees).

    Raises:
        ValueError: naming the origin, the key and the value.
    """
    _check_keys(mapping, origin)
    count = 0
    fields: dict[str, Any] = {
        "name": _name(mapping["name"], f"{origin}: name"),
        "closed": _closed(mapping["closed"], mapping["doors"], f"{origin}: closed"),
        "home": tuple(_row(mapping["home"], 3, f"{origin}: home")),
    }
    for key, (fewest, most, is_polygon) in _SHAPES.items():
        checked = {}
        for name, value in _items(mapping[key], key, origin):
            where = f"{origin}: {key}.{name}"
            count += len(value) if isinstance(value, (list, tuple)) else 0
            if count > MAX_POINTS:
                raise ValueError(f"{where}: expected at most {MAX_POINTS} points in all")
            checked[name] = _points(value, fewest, most, where)
            if is_polygon:
                _check_polygon(checked[name], where)
        fields[key] = checked if key in _NAMED else tuple(checked.values())
    if not fields["walls"]:
        raise ValueError(f"{origin}: walls: expected at least one polyline, got []")
    return fields


_SHAPES = {
    "walls": (2, MAX_POINTS, False),
    "furniture": (3, MAX_POINTS, True),
    "doors": (2, 2, False),
    "barriers": (2, 2, False),
    "rooms": (3, MAX_POINTS, True),
}
"""By key: fewest points, most points, whether the points make a polygon."""
_NAMED = ("doors", "barriers", "rooms")


def _check_keys(mapping: Mapping[str, Any], origin: str) -> None:
    if not isinstance(mapping, Mapping):
        raise ValueError(f"{origin}: expected a mapping of {KEYS}, got {shown(mapping)}")
    missing = [key for key in KEYS if key not in mapping]
    if missing:
        raise ValueError(f"{origin}: {missing[0]}: missing; a plan has the keys {KEYS}")
    unknown = [key for key in mapping if key not in KEYS]
    if unknown:
        value = shown(mapping[unknown[0]])
        raise ValueError(
            f"{origin}: {unknown[0]}: unknown, got {value}; a plan has the keys {KEYS}"
        )


def _items(value: Any, key: str, origin: str) -> list[tuple[Any, Any]]:
    if key not in _NAMED:
        if not isinstance(value, (list, tuple)):
            raise ValueError(f"{origin}: {key}: expected a list, got {shown(value)}")
        return list(enumerate(value))
    if not isinstance(value, Mapping):
        raise ValueError(f"{origin}: {key}: expected names with points, got {shown(value)}")
    for name in value:
        _name(name, f"{origin}: {key}")
    return list(value.items())


def _points(value: Any, fewest: int, most: int, where: str) -> Points:
    if not isinstance(value, (list, tuple)) or not fewest <= len(value) <= most:
        raise ValueError(f"{where}: expected {_number_of(fewest, most)}, got {shown(value)}")
    points = np.array([_row(row, 2, where) for row in value], dtype=np.float64)
    if (np.diff(points, axis=0) == 0.0).all(axis=1).any():
        raise ValueError(f"{where}: expected no piece of zero length, got {shown(value)}")
    return points


def _row(value: Any, width: int, where: str) -> list[float]:
    if not isinstance(value, (list, tuple)) or len(value) != width:
        raise ValueError(f"{where}: expected {width} numbers, got {shown(value)}")
    for number in value:
        is_number = isinstance(number, (int, float)) and not isinstance(number, bool)
        if not is_number or not abs(number) <= MAX_COORDINATE:
            raise ValueError(
                f"{where}: expected finite numbers within {MAX_COORDINATE:g}, got {shown(value)}"
            )
    return [float(number) for number in value]


def _check_polygon(points: Points, where: str) -> None:
    polygon = Polygon(points)
    if not polygon.is_valid or polygon.area == 0.0:
        raise ValueError(
            f"{where}: expected a polygon with an area that does not cross or touch itself, "
            f"got {shown(points.tolist())}"
        )


def _name(value: Any, where: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{where}: expected a name (text), got {shown(value)}")
    return value


def _closed(value: Any, doors: Any, where: str) -> tuple[str, ...]:
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{where}: expected a list of doors, got {shown(value)}")
    for name in value:
        if not isinstance(name, str) or name not in doors or value.count(name) > 1:
            raise ValueError(f"{where}: expected names of doors, each once, got {shown(name)}")
    return tuple(value)


def _number_of(fewest: int, most: int) -> str:
    return f"{fewest} points" if fewest == most else f"a list of {fewest} or more points"


def shown(value: Any) -> str:
    """The value as a message repeats it: short, whatever it is."""
    text = _BRIEF.repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."
