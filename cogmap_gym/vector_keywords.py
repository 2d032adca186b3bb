"""What a person gives to the vector environment, checked: keywords, seeds, masks, actions.

Every function here raises ``ValueError`` that says what was expected and what came.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array
from cogmap_gym.keywords import jsonable
from cogmap_gym.raycast_kernel import Ints
from cogmap_gym.sites import Map

Flags = NDArray[np.bool_]


def refuse(lacking: Mapping[str, Any]) -> None:
    """Refuse what only single environments have; None asks for nothing."""
    asked = {key: value for key, value in lacking.items() if value is not None}
    if asked:
        key, value = next(iter(asked.items()))
        raise ValueError(
            f"{key}: the vector environment does not have it, got {value!r}; "
            f"make_vec(..., vectorization_mode='sync') takes all that make takes"
        )


def count_of(value: Any, name: str) -> int:
    """A keyword that counts something, 1 at least."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name}: expected an int of at least 1, got {value!r}")
    return value


def mode_of(value: AutoresetMode | str) -> AutoresetMode:
    """The autoreset mode of a keyword."""
    try:
        return AutoresetMode(value)
    except ValueError:
        modes = [mode.value for mode in AutoresetMode]
        raise ValueError(f"autoreset_mode: expected one of {modes}, got {value!r}") from None


def maps_of(value: Map | Sequence[Map]) -> Sequence[Map]:
    """A list of maps, of one or of many."""
    if isinstance(value, str | Path | Mapping | FloorPlan):
        return [value]
    if not isinstance(value, Sequence) or not value:
        raise ValueError(f"map: expected a map or a list of maps, got {value!r}")
    return value


def room_table(plans: Sequence[FloorPlan], where: Ints) -> tuple[NDArray[Any], Ints]:
    """The names of all rooms, before each plan's the name of none; where each robot's begin."""
    names = np.array([name for p in plans for name in ("", *p.room_names)], dtype=object)
    ends = np.cumsum([0, *(len(p.rooms) + 1 for p in plans)])
    return names, ends[where] + 1


def seeds_of(seed: int | Sequence[int | None] | None, count: int) -> Sequence[int | None]:
    """A seed for each robot."""
    if seed is None:
        return [None] * count
    if isinstance(seed, int | np.integer):
        return [int(seed) + row for row in range(count)]
    if len(seed) != count:
        raise ValueError(f"seed: expected one for each of {count} robots, got {len(seed)}")
    return seed


def mask_of(value: Any, count: int) -> Flags:
    """Which robots are to be reset."""
    if value is None:
        return np.ones(count, dtype=np.bool_)
    mask = np.asarray(value)
    if mask.shape != (count,) or mask.dtype != np.bool_ or not mask.any():
        raise ValueError(f"options: reset_mask: expected {count} bools, one true, got {value!r}")
    return mask


def checked_actions(actions: Any, count: int) -> Array:
    """The actions (N, 3), clipped to [-1, 1]."""
    values: Array = np.asarray(actions, dtype=np.float64)
    clipped: Array = np.maximum(np.minimum(values, 1.0), -1.0)
    if values.shape != (count, 3) or math.isnan(clipped.sum()):
        raise ValueError(f"actions: expected shape ({count}, 3) without NaN, got {actions!r}")
    return clipped


def jsonable_list(value: Any) -> Any:
    """A keyword as JSON can hold it; also a list of maps, and a mode."""
    if isinstance(value, AutoresetMode):
        return value.value
    return [jsonable(one) for one in value] if isinstance(value, list | tuple) else jsonable(value)
