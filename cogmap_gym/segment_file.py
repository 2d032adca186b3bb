"""Files of line walls: AMRL's vectormap and ARIA's 2D-Map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cogmap_gym.geometry import Segments
from cogmap_gym.plan_schema import MAX_COORDINATE, shown

MAX_FILE = 2**26
"""Largest file that is read [bytes]. Ours: some 10^6 lines."""
MAX_LINES = 200_000
"""Most walls of a file [-]. Ours: thirty times the largest sample."""
MAX_SIDE_M = 500.0
"""Longest side of a plan [m]. Ours: cells of 0.1 m over it take some 100 MB."""
MM = 0.001
"""Metres of a millimetre, the unit of ARIA's files."""
ARIA_HEAD = "2D-Map"
"""The first line of an ARIA map."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """What a file of lines says."""

    name: str
    """What the plan is called."""
    segments: Segments
    """(N, 2, 2) [m], each longer than nothing."""
    home: tuple[float, float, float] | None
    """x, y [m] and degrees, if given."""


def read_vectormap(path: Path) -> Drawing:
    """An AMRL vectormap: ``x1,y1, x2,y2`` a line, in metres; empty lines do not matter.

    Raises:
        ValueError: naming the file, the line and what it says.
    """
    lines = _lines(path)
    _check_most(len(lines), path)
    numbers = [
        _numbers(line.split(","), f"{path}: line {row}: expected x1,y1,x2,y2 in metres")
        for row, line in enumerate(lines, 1)
        if line.strip()
    ]
    name = path.name.removesuffix(path.suffix).removesuffix(".vectormap")
    return Drawing(name, _segments(numbers, path, 1.0), None)


def read_aria(path: Path) -> Drawing:
    """An ARIA map: the lines of its section ``LINES`` and its ``RobotHome``, in millimetres.

    Laser points, goals and forbidden areas do not matter.

    Raises:
        ValueError: naming the file, the line and what it says.
    """
    lines = [line.strip() for line in _lines(path)]
    if not lines or lines[0] != ARIA_HEAD:
        raise ValueError(f"{path}: expected the first line {ARIA_HEAD!r}, got {shown(lines[:1])}")
    if "LINES" not in lines:
        raise ValueError(f"{path}: expected a section LINES, got none")
    start = lines.index("LINES") + 1
    end = lines.index("DATA", start) if "DATA" in lines[start:] else len(lines)
    _check_most(end - start, path)
    numbers = [
        _numbers(line.split(), f"{path}: line {row}: expected x1 y1 x2 y2 in millimetres")
        for row, line in enumerate(lines[start:end], start + 1)
        if line
    ]
    _check_count(lines[:start], len(numbers), path)
    return Drawing(path.stem, _segments(numbers, path, MM), _robot_home(lines[:start], path))


def _lines(path: Path) -> list[str]:
    size = path.stat().st_size
    if size > MAX_FILE:
        raise ValueError(f"{path}: expected a file of at most {MAX_FILE} bytes, got {size}")
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (ValueError, OSError) as error:
        raise ValueError(f"{path}: expected text, got: {error}") from error


def _check_most(count: int, path: Path) -> None:
    if count > MAX_LINES:
        raise ValueError(f"{path}: expected at most {MAX_LINES} lines, got {count}")


def _numbers(words: Sequence[str], expected: str, count: int = 4) -> list[float]:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ValueError(f"{expected}, got {shown(' '.join(words))}")
    return numbers


def _segments(numbers: list[list[float]], path: Path, unit: float) -> Segments:
    if not numbers:
        raise ValueError(f"{path}: expected lines, got none")
    segments = unit * np.array(numbers).reshape(-1, 2, 2)
    low, high = segments.min(axis=(0, 1)), segments.max(axis=(0, 1))
    if max(-low.min(), high.max()) > MAX_COORDINATE or (high - low).max() > MAX_SIDE_M:
        raise ValueError(
            f"{path}: expected a plan of at most {MAX_SIDE_M:g} m, "
            f"got x, y from {low.tolist()} to {high.tolist()} m"
        )
    kept = segments[(segments[:, 0] != segments[:, 1]).any(axis=1)]
    if not len(kept):
        raise ValueError(f"{path}: expected lines, got points alone")
    return np.asarray(kept)


def _check_count(head: Sequence[str], count: int, path: Path) -> None:
    for line in head:
        if line.startswith("NumLines:"):
            told = line.removeprefix("NumLines:").strip()
            if told != str(count):
                raise ValueError(f"{path}: NumLines: expected {shown(told)} lines, got {count}")


def _robot_home(head: Sequence[str], path: Path) -> tuple[float, float, float] | None:
    """The first ``Cairn: RobotHome``: x, y [m] and degrees."""
    for line in head:
        words = line.split()
        if words[:2] == ["Cairn:", "RobotHome"]:
            expected = f"{path}: RobotHome: expected x y in millimetres and degrees"
            x, y, degrees = _numbers(words[2:5], expected, 3)
            return MM * x, MM * y, degrees
    return None
