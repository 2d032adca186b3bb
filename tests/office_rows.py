"""Hand-made moments and rows of episodes in offices."""

from __future__ import annotations

from typing import Any

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.office_record import Moment, OfficeRecord, Outcome

PLAN = FloorPlan.load("two_rooms")
LEFT, RIGHT = (2.0, 2.5), (6.0, 2.5)
"""Points in R1 and R2; the door E1 is half-way between."""


def moment(at: tuple[float, float] = LEFT, **changes: Any) -> Moment:
    """A moment of a robot that knows nothing yet and believes what is true."""
    pose = np.array((*at, 0.0))
    fields: dict[str, Any] = {
        "phase": 0, "pose": pose, "coverage": 0.5, "mark": 0, "declared": False,
        "status": "exploring", "seconds": 0.002, "believed": pose, "place": 1, "known": False,
        "entry": 0, "came_from": 0, "began": 0, "places": 0,
    }  # fmt: skip
    return Moment(**(fields | changes))


def outcome(**changes: Any) -> Outcome:
    """A goal in R2 that was met."""
    fields: dict[str, Any] = {
        "phase": 1, "mark": 2, "room": "R2", "success": True, "reachable": True,
        "distance": 0.4, "spl": 0.8, "spl_learning": 0.9,
    }  # fmt: skip
    return Outcome(**(fields | changes))


def record(moments: list[Moment], outcomes: list[Outcome], coverage: float = 1.0) -> OfficeRecord:
    """An episode in the two rooms; one closed and one open place."""
    boundary = np.array(PLAN.rooms["R1"])
    return OfficeRecord(PLAN, moments, outcomes, coverage, {1: boundary, 2: np.zeros((0, 2))})
