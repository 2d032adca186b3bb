"""What a learned robot perceives, how it can move, and its network: what its weights are for."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

MARKS: Final = 10
"""How many values ``goal`` and ``mark`` take, as in ``cogmap_gym.observation`` [-]."""


@dataclass(frozen=True, slots=True)
class Percepts:
    """Sizes of what the network is shown; all of it comes from scans, odometry and marks.

    Raises:
        ValueError: a size that is not above 0, naming it.
    """

    sectors: int = 36
    """Sectors of the scan, the nearest return of each [-]."""
    stride: int = 2
    """Every so many beams one is drawn into the memory [beams]."""
    cell: float = 0.25
    """Side of a cell of the memory [m]."""
    side: int = 512
    """Cells along a side of the memory; the robot begins in the middle [-]."""
    reach: float = 12.0
    """Beams are drawn, and the memory is looked through, up to here [m]."""
    directions: int = 32
    """All around the robot, in which the memory is looked through [-]."""
    near_cells: int = 12
    """Fields along a side of the near picture [-]."""
    near_size: float = 2.0
    """Side of such a field [m]."""
    far_cells: int = 8
    """Fields along a side of the far picture [-]."""
    far_size: float = 6.0
    """Side of such a field [m]."""
    samples: int = 8
    """Points along a side of a field at which the memory is read [-]."""

    def __post_init__(self) -> None:
        """Check that there is something of everything."""
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"Percepts.{name}: expected above 0, got {value!r}")

    @property
    def size(self) -> int:
        """How many numbers the network is shown."""
        pictures = 3 * (self.near_cells**2 + self.far_cells**2)
        return self.sectors + 2 * self.directions + pictures + OTHERS


OTHERS: Final = 8
"""Contact, three of odometry, and four of the goal [-]."""


@dataclass(frozen=True, slots=True)
class Moves:
    """The moves that the network chooses among: a turn, and a drive after it."""

    turns: tuple[float, ...] = (-30.0, -20.0, -12.0, -6.0, -2.0, 0.0, 2.0, 6.0, 12.0, 20.0, 30.0)
    """Turns to the left [degrees]."""
    drives: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0)
    """Drives [m]."""
    arrived: float = 0.5
    """A mark believed as near as this is declared [m]; the network has no say in it."""

    temperature: float = 0.5
    """Of the robot's draws: training draws at 1, less makes the likelier moves more often [-]. On
    offices 1900 to 1903, two seeds, ppo saw 0.73 of the area over the budget at 0.5, 0.63 at 1
    and 0.67 at 0.25."""

    def __post_init__(self) -> None:
        """Check that there is a choice.

        Raises:
            ValueError: no turns or drives, or no temperature above 0.
        """
        if not (self.turns and self.drives and self.temperature > 0.0):
            raise ValueError(f"Moves: expected turns, drives and a temperature, got {self}")

    @property
    def counts(self) -> tuple[int, int]:
        """How many turns and drives there are."""
        return len(self.turns), len(self.drives)


@dataclass(frozen=True, slots=True)
class Network:
    """Widths of the layers.

    Raises:
        ValueError: a negative width, naming it.
    """

    shared: int = 192
    """Of the layer on the percepts, which actor and critic share [units]."""
    heads: int = 96
    """Of the layer of its own that each has after it [units]."""
    lstm: int = 0
    """Of the memory between them [units]; 0 for a network without one."""

    def __post_init__(self) -> None:
        """Check the widths."""
        for name, least in (("shared", 1), ("heads", 1), ("lstm", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                raise ValueError(f"Network.{name}: expected an int from {least}, got {value!r}")


@dataclass(frozen=True, slots=True)
class Config:
    """All that must be known to run a set of weights."""

    percepts: Percepts = Percepts()
    moves: Moves = Moves()
    network: Network = Network()

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """As JSON can hold it."""
        return asdict(self)

    @classmethod
    def of(cls, given: Any, where: str) -> Config:
        """The configuration that ``to_dict`` made.

        Args:
            given: what was read.
            where: it was read, for the error.

        Raises:
            ValueError: a part or a number is missing, unknown or out of bounds.
        """
        parts = {"percepts": Percepts, "moves": Moves, "network": Network}
        if not isinstance(given, dict) or set(given) != set(parts):
            raise ValueError(f"{where}: config: expected the parts {sorted(parts)}, got {given!r}")
        try:
            made = {name: kind(**_tuples(given[name])) for name, kind in parts.items()}
        except (TypeError, ValueError) as error:
            raise ValueError(f"{where}: config: {error}") from error
        return cls(**made)


def _tuples(values: dict[str, Any]) -> dict[str, Any]:
    """JSON knows lists alone."""
    return {key: tuple(v) if isinstance(v, list) else v for key, v in values.items()}
