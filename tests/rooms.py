"""Small plans built by hand, for tests: every one is closed, so no beam leaves it."""

from __future__ import annotations

from typing import Any

from cogmap_gym.floor_plan import FloorPlan


def plan(**fields: Any) -> FloorPlan:
    """A plan of the given fields; what is left out is empty, home is (1, 1, 0)."""
    empty: dict[str, Any] = {
        "name": "room",
        "walls": [],
        "furniture": [],
        "doors": {},
        "closed": [],
        "barriers": {},
        "rooms": {},
        "home": [1, 1, 0],
    }
    return FloorPlan.from_mapping(empty | fields)


def square_room(side: float = 6.0) -> FloorPlan:
    """One empty square room R1 with a corner at (0, 0); home is its middle."""
    ring = [[0, 0], [side, 0], [side, side], [0, side]]
    return plan(
        walls=[[*ring, ring[0]]], rooms={"R1": ring}, home=[side / 2, side / 2, 0], name="square"
    )


def corridor(length: float = 20.0, width: float = 2.0) -> FloorPlan:
    """One bare corridor R1 along x; home is 1 m from its west end, looking along it."""
    ring = [[0, 0], [length, 0], [length, width], [0, width]]
    return plan(
        walls=[[*ring, ring[0]]], rooms={"R1": ring}, home=[1, width / 2, 0], name="corridor"
    )


def room_with_pillar() -> FloorPlan:
    """A room of 6 x 6 m with a pillar of 1 m in its middle and a cupboard in a corner."""
    ring = [[0, 0], [6, 0], [6, 6], [0, 6]]
    pillar = [[2.5, 2.5], [2.5, 3.5], [3.5, 3.5], [3.5, 2.5], [2.5, 2.5]]
    return plan(
        walls=[[*ring, ring[0]], pillar],
        furniture=[[[5, 5], [6, 5], [6, 6], [5, 6]]],
        rooms={"R1": ring},
        name="pillar",
    )


def l_room() -> FloorPlan:
    """An L of 8 x 8 m whose upper right quarter of 4 x 4 m is missing."""
    ring = [[0, 0], [8, 0], [8, 4], [4, 4], [4, 8], [0, 8]]
    return plan(walls=[[*ring, ring[0]]], rooms={"R1": ring}, name="l_room")


def thin_rooms() -> FloorPlan:
    """Two rooms of 4 x 5 m parted by a wall drawn as lines, with the door E1 in it."""
    return plan(
        walls=[
            [[0, 0], [8, 0], [8, 5], [0, 5], [0, 0]],
            [[4, 0], [4, 2]],
            [[4, 3], [4, 5]],
        ],
        doors={"E1": [[4, 2], [4, 3]]},
        barriers={"B1": [[4, 4], [8, 4]]},
        rooms={
            "R1": [[0, 0], [4, 0], [4, 5], [0, 5]],
            "R2": [[4, 0], [8, 0], [8, 5], [4, 5]],
        },
        home=[2, 2.5, 0],
        name="thin_rooms",
    )


def ring_of_four() -> FloorPlan:
    """A ring of four rooms R1..R4 round a core, clockwise from the lower left.

    The building is 10 x 10 m, the core 2 x 2 m; the doors E1..E4 of 1 m lie half way along
    the sides, Ek between Rk and the room after it.
    """
    jambs = [
        [[[0, 5], [1.5, 5]], [[2.5, 5], [4, 5]]],
        [[[5, 10], [5, 8.5]], [[5, 7.5], [5, 6]]],
        [[[10, 5], [8.5, 5]], [[7.5, 5], [6, 5]]],
        [[[5, 0], [5, 1.5]], [[5, 2.5], [5, 4]]],
    ]
    return plan(
        walls=[
            [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]],
            [[4, 4], [4, 6], [6, 6], [6, 4], [4, 4]],
            *(wall for pair in jambs for wall in pair),
        ],
        doors={f"E{k + 1}": [outer[1], inner[0]] for k, (outer, inner) in enumerate(jambs)},
        rooms={
            "R1": [[0, 0], [5, 0], [5, 4], [4, 4], [4, 5], [0, 5]],
            "R2": [[0, 5], [4, 5], [4, 6], [5, 6], [5, 10], [0, 10]],
            "R3": [[5, 10], [5, 6], [6, 6], [6, 5], [10, 5], [10, 10]],
            "R4": [[10, 5], [6, 5], [6, 4], [5, 4], [5, 0], [10, 0]],
        },
        home=[2, 2, 90],
        name="ring_of_four",
    )
