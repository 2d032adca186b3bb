"""What changes in a living office from one moment to the next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from cogmap_gym.boxes import Box
from cogmap_gym.people import Person
from cogmap_gym.world import WorldState


@dataclass(frozen=True, slots=True)
class Life:
    """Where all is that moves by itself or by a push."""

    boxes: tuple[Box, ...] = ()
    people: tuple[Person, ...] = ()
    shut: str = ""
    """The door that is shut for a while; empty: none."""
    change_in: float = 0.0
    """When the next door shuts or that one opens [s]."""


@dataclass(frozen=True, slots=True)
class LivingState(WorldState):
    """All that changes, and the chance that is to come."""

    life: Life = field(default_factory=Life)
    chance: Any = None
    """State of the bit generator; None: nothing is drawn yet."""
