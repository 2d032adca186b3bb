"""Write maps/thesis_office.yaml: the rooms are cut out of one solid block, so no wall leaks.

The geometry is ours; it has the topology of the thesis's office (Fig. 1.2): a ring of six
local spaces, and two chords whose doors are shut at first. Lengths are metres.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon, box
from shapely.geometry.polygon import orient
from shapely.ops import unary_union

from cogmap_gym import plan_file
from cogmap_gym.floor_plan import FloorPlan

DECIMALS = 4
"""Decimals of a coordinate in the file [-]."""
TOUCH = 1e-6
"""Largest gap of things that touch [m]."""
Box = tuple[float, float, float, float]

SPACES: dict[str, str] = {
    "ASR1": "0.2 13, 8.6 13, 8.6 17.5, 9.2 17.5, 9.2 19.5, 8.6 19.5, "
    "8.6 24, 7.2 24, 7.2 27.6, 2.8 27.6, 2.8 25.2, 0.2 25.2",
    "ASR2": "3.5 27.8, 26.5 27.8, 26.5 29.8, 3.5 29.8",
    "ASR3": "20.4 18, 24.6 18, 24.6 13.2, 29.8 13.2, 29.8 26.4, 28.4 26.4, "
    "28.4 27.6, 20.4 27.6, 20.4 26, 19.8 26, 19.8 24, 20.4 24",
    "ASR4": "22.8 2.4, 29.8 2.4, 29.8 13, 20.8 13, 20.8 7.8, "
    "20.2 7.8, 20.2 6.2, 20.8 6.2, 20.8 4.4",
    "ASR5": "3.5 0.2, 26.5 0.2, 26.5 2.2, 3.5 2.2",
    "ASR6": "0.2 2.4, 11.2 2.4, 12.2 3.4, 12.2 7.4, 8 7.4, 8 12.8, 1.4 12.8, 1.4 11.8, 0.2 11.8",
    "ASR7": "16.6 2.4, 19.6 2.4, 19.6 12, 20.2 12, 20.2 21.5, 15.6 21.5, 15.6 13, 16.6 13",
    "ASR8": "8.8 7.6, 13 7.6, 14.2 8.8, 14.2 15.6, 12.6 15.6, "
    "12.6 27.6, 10.4 27.6, 10.4 15.6, 8.8 15.6",
}
"""Corners, x and y, counter-clockwise; ASR2 and ASR5 are alike after half a turn."""

PILLARS: dict[str, str] = {
    "ASR1": "6.2 15.6 6.6 16",
    "ASR2": "8 29.55 8.5 29.8, 16.9 27.8 17.4 28.05, 20.6 29.55 21.1 29.8",
    "ASR3": "26.9 19.2 27.3 19.6",
    "ASR4": "27.2 7 27.6 7.4, 23.2 9.6 23.6 10",
    "ASR5": "21.5 0.2 22 0.45, 12.6 1.95 13.1 2.2, 8.9 0.2 9.4 0.45",
    "ASR6": "5.6 8.2 6 8.6",
    "ASR8": "11.3 11.4 11.7 11.8",
}
"""Free-standing pillars, and pilasters against a wall: x least, y least, x most, y most."""

PASSAGES: dict[str, tuple[str, str, Box]] = {
    "E1": ("ASR1", "ASR2", (4.55, 27.6, 5.45, 27.8)),
    "E2": ("ASR2", "ASR3", (24.55, 27.6, 25.45, 27.8)),
    "E3": ("ASR3", "ASR4", (26.9, 13.0, 27.8, 13.2)),
    "E4": ("ASR4", "ASR5", (24.55, 2.2, 25.45, 2.4)),
    "E5": ("ASR5", "ASR6", (4.55, 2.2, 5.45, 2.4)),
    "E6": ("ASR6", "ASR1", (2.5, 12.8, 3.4, 13.0)),
    "E7": ("ASR5", "ASR7", (18.05, 2.2, 18.95, 2.4)),
    "E8": ("ASR3", "ASR7", (20.2, 19.9, 20.4, 20.8)),
    "E9": ("ASR2", "ASR8", (11.05, 27.6, 11.95, 27.8)),
    "E10": ("ASR6", "ASR8", (10.05, 7.4, 10.95, 7.6)),
}
"""Doorways through a wall: the rooms on both sides, and the box of the opening."""

SHUT = ("E7", "E8", "E9", "E10")
"""Shut at first, the leaf flush with the ring, so that it looks like a wall."""

FURNITURE: dict[str, str] = {
    "ASR1": "0.2 20 0.8 22.2, 1.8 15.8 3.4 16.8, 7.7 13.8 8.6 15.8, 7 21.4 8.6 22.2",
    "ASR2": "13.5 29.4 15.1 29.8",
    "ASR3": "22.6 22 24.6 23.4, 29.2 21.4 29.8 23.8, 22 18 23.9 18.8, 28.2 15.4 29.8 16.2",
    "ASR4": "23 6 25.2 7.2, 20.8 9.4 21.8 11.2, 29.2 3.6 29.8 5.8, 22.4 12.5 24.6 13",
    "ASR5": "14.9 0.2 16.5 0.6",
    "ASR6": "0.2 4.6 0.7 6.8, 2.2 6.4 4 7.4, 7 9.8 8 11.6, 8.4 2.4 10.4 2.9",
    "ASR7": "15.6 15 16.1 17.2, 18.5 8 19.6 9",
    "ASR8": "13.4 10.2 14.2 12.2",
}
"""Tables in the open; cupboards, desks and sofas against a wall; boxes as above."""

BARRIERS = {"B5": [[23.9, 2.2], [26.5, 1.3]]}
"""B5 parts E4 from the rest of ASR5, wherever in ASR5 the robot stands."""
HOME = [4.4, 18.6, 90.0]


def numbers(rows: str) -> list[list[float]]:
    """Rows of numbers, parted by commas."""
    return [[float(number) for number in row.split()] for row in rows.split(",")]


def boxes(by_room: dict[str, str]) -> list[Polygon]:
    """The boxes of all rooms."""
    return [box(*row) for rows in by_room.values() for row in numbers(rows)]


def space(room: str) -> Polygon:
    """The outline of a room, without its doorways."""
    return Polygon(numbers(SPACES[room]))


def shares(name: str) -> tuple[list[list[float]], dict[str, Polygon]]:
    """The leaf of a door, and the part of the doorway on either side of it, by room."""
    first, second, (x0, y0, x1, y1) = PASSAGES[name]
    across = np.array((0.0, y1 - y0) if x1 - x0 > y1 - y0 else (x1 - x0, 0.0))
    sill = np.array(((x0, y0), (x1, y1) - across))
    if space(first).distance(LineString(sill)) > TOUCH:
        sill, across = sill + across, -across
    leaf = sill + (0.0 if name in SHUT else 0.5) * across
    sides = (sill, leaf), (leaf, sill + across)
    parts = {
        room: Polygon(np.concatenate((near, far[::-1]))).buffer(0.0)
        for room, (near, far) in zip((first, second), sides, strict=True)
    }
    return leaf.round(DECIMALS).tolist(), parts


def outline(polygon: Polygon) -> list[list[list[float]]]:
    """The rings of a polygon, free space on the left, first ring the outer one."""
    tidy = orient(polygon.simplify(0.0))
    rings = (tidy.exterior, *tidy.interiors)
    return [shapely.get_coordinates(ring).round(DECIMALS).tolist() for ring in rings]


def office() -> FloorPlan:
    """The plan: every room is its outline and its share of the doorways."""
    leaves = {name: shares(name) for name in PASSAGES}
    rooms = {
        room: unary_union(
            [space(room), *(parts[room] for _, parts in leaves.values() if room in parts)]
        )
        for room in SPACES
    }
    free = unary_union([*rooms.values()]).difference(unary_union(boxes(PILLARS)))
    assert isinstance(free, Polygon), "the doors join all rooms"
    return FloorPlan.from_mapping(
        {
            "name": "thesis_office",
            "walls": outline(free),
            "furniture": [outline(piece)[0][:-1] for piece in boxes(FURNITURE)],
            "doors": {name: leaf for name, (leaf, _) in leaves.items()},
            "closed": list(SHUT),
            "barriers": BARRIERS,
            "rooms": {room: outline(polygon)[0][:-1] for room, polygon in rooms.items()},
            "home": HOME,
        }
    )


if __name__ == "__main__":
    office().save(plan_file.maps_folder() / "thesis_office.yaml")
