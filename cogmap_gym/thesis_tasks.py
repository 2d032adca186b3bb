"""The experiments of the thesis (4.2 to 4.4) as courses over a ring of six rooms.

The plan has rooms ``ASR1`` to ``ASR6``, clockwise, and doors ``E1`` to ``E6``, door k from
room k to the next; experiment 3 also needs ``ASR7``, ``ASR8``, ``E7`` to ``E10`` and the
barrier ``B5``. The robot is told of no event.

A lap forces its direction: the other door of ASR1 is shut until the robot is in the next
room but one. It ends 1.0 m beyond the last door with all six rooms visited.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogmap_gym.events import Event
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.phases import Itinerary, Lap, Phase

EXPERIMENTS = (1, 2, 3)
"""The experiments of thesis 4.2, 4.3 and 4.4."""
LAP_MOVES = 400
"""Budget of a lap: seven times what a good robot takes (FINDINGS 2: 50-60 moves)."""
GOAL_MOVES = 200
"""Budget of a way home or to a room: as long as three laps."""
RING = tuple(f"ASR{k}" for k in range(1, 7))
"""The rooms of the ring, clockwise from home."""
MARK_ROOMS = {2: "ASR5", 3: "ASR3", 4: "ASR2"}
"""Where experiment 3 gives the marks of its places, in the order in which it asks for them."""
RING_NAMES = frozenset((*RING, *(f"E{k}" for k in range(1, 7))))
CHORD_NAMES = frozenset(("ASR7", "ASR8", "E7", "E8", "E9", "E10", "B5"))


def _lap(*, clockwise: bool) -> Phase:
    """A lap from ASR1; its last door is shut until the robot is two rooms on."""
    door, last, opens = ("E6", "ASR6", "ASR3") if clockwise else ("E1", "ASR2", "ASR5")
    events = (Event("shut", door), Event("open", door, room=opens))
    lap = Lap(RING, last, door)
    return Phase("explore", 0, LAP_MOVES, lap=lap, events=events, closing=(Event("open", door),))


def _place(mark: int, events: tuple[Event, ...], closing: tuple[Event, ...] = ()) -> Phase:
    """Go to the room of a mark; anywhere in the room will do."""
    return Phase(f"goto:{mark}", mark, GOAL_MOVES, in_room=True, events=events, closing=closing)


CLOCKWISE = _lap(clockwise=True)
ANTICLOCKWISE = _lap(clockwise=False)
GO_HOME = Phase("home", 1, GOAL_MOVES)
TO_ASR5 = _place(2, (Event("place", "B5", "ASR5", "ASR6"),))
TO_ASR3_BLOCKED = _place(
    3, (Event("place", "B5"), Event("open", "E7"), Event("open", "E8")), (Event("remove", "B5"),)
)
HOME_BLOCKED = Phase(
    "home",
    1,
    GOAL_MOVES,
    events=(Event("open", "E9"), Event("open", "E10"), Event("shut", "E1", "ASR2", "ASR3")),
)
TO_ASR2_SHORTCUT = _place(4, (Event("open", "E9"), Event("open", "E10"), Event("shut", "E1")))
PHASES = {
    1: (CLOCKWISE, CLOCKWISE, GO_HOME),
    2: (ANTICLOCKWISE, GO_HOME, ANTICLOCKWISE, GO_HOME),
    3: (
        CLOCKWISE,
        GO_HOME,
        ANTICLOCKWISE,
        TO_ASR5,
        TO_ASR3_BLOCKED,
        HOME_BLOCKED,
        TO_ASR2_SHORTCUT,
    ),
}
"""The phases of each experiment, in order. DESIGN 4."""

CHORDS = {"ASR7": 4, "ASR8": 5}
"""The rooms through which the chords lead, and the phase of experiment 3, from 0, in which each
is first gone through."""
OWN_DOORS: tuple[tuple[str, ...] | None, ...] = (
    None,
    (),
    None,
    ("E6", "E5"),
    ("E7", "E8"),
    ("E2", "E9", "E10", "E6"),
    ("E6", "E10", "E9"),
)
"""Of each phase of experiment 3 the doors that the thesis's robot went through (4.4); a lap is
judged by itself alone. The first way home is none: a lap ends in home's room."""


@dataclass(frozen=True, slots=True)
class Thesis:
    """One of the thesis's three experiments."""

    experiment: int = 1
    """Which one."""

    def __post_init__(self) -> None:
        """Check the number.

        Raises:
            ValueError: there is no such experiment.
        """
        if self.experiment not in EXPERIMENTS:
            raise ValueError(f"experiment: expected one of {EXPERIMENTS}, got {self.experiment!r}")

    def check(self, plan: FloorPlan) -> None:
        """Check that the plan has the ring, and for experiment 3 the chords.

        Raises:
            ValueError: naming what is missing.
        """
        needed = RING_NAMES | (CHORD_NAMES if self.experiment == 3 else frozenset())
        missing = needed - {*plan.room_names, *plan.door_names, *plan.barrier_names}
        if missing:
            raise ValueError(
                f"Thesis experiment {self.experiment}: the plan {plan.name!r} lacks "
                f"rooms, doors or barriers: {sorted(missing)}"
            )
        if plan.room_at(plan.home.x, plan.home.y) != RING[0]:
            raise ValueError(f"Thesis: expected a home in {RING[0]}, got {plan.home}")

    def most_moves(self, plan: FloorPlan) -> int:  # noqa: ARG002
        """The sum of the budgets: no limit but those of the phases."""
        return sum(phase.budget for phase in PHASES[self.experiment])

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:  # noqa: ARG002
        """The phases of the experiment; nothing is drawn."""
        return Itinerary(PHASES[self.experiment], MARK_ROOMS if self.experiment == 3 else {})
