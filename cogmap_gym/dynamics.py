"""The levels of a living office: what moves in it but the robot, and how much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Dynamics:
    """How much moves in an office."""

    box_area: float = 0.0
    """Free area for which there is one box or chair [m^2]; 0: none."""
    person_area: float = 0.0
    """Free area for which there is one person [m^2]; 0: nobody."""
    doors: bool = False
    """Whether doors shut and open by themselves."""

    @property
    def lives(self) -> bool:
        """Whether anything moves at all."""
        return self.box_area > 0.0 or self.person_area > 0.0 or self.doors


LEVELS: Final = {
    "off": Dynamics(),
    "furniture": Dynamics(box_area=15.0),
    "doors": Dynamics(doors=True),
    "people": Dynamics(person_area=60.0),
    "busy": Dynamics(box_area=15.0, person_area=40.0, doors=True),
}
"""The levels by name."""
BLOCKING: Final = ("shortcut", "thesis")
"""Tasks that shut doors themselves; a schedule would undo what they do."""


def dynamics_level(name: str, task: str) -> Dynamics:
    """The level of a name, for a task.

    Raises:
        ValueError: no such level, or one whose doors would undo the blocks of the task.
    """
    if name not in LEVELS:
        raise ValueError(f"dynamics: expected one of {sorted(LEVELS)}, got {name!r}")
    if LEVELS[name].doors and task in BLOCKING:
        raise ValueError(
            f"dynamics: expected a level without doors on a schedule, for {task!r} shuts doors "
            f"itself, got {name!r}"
        )
    return LEVELS[name]
