"""How the keywords of an environment and the options of ``reset`` are read."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose


def most_moves(asked: int | None, default: int) -> int:
    """After how many steps an episode is cut: what was asked for, or the default.

    Raises:
        ValueError: not an int of at least 1.
    """
    if asked is None:
        return default
    if isinstance(asked, bool) or not isinstance(asked, int) or asked < 1:
        raise ValueError(f"max_moves: expected an int of at least 1, got {asked!r}")
    return asked


def home_of(options: Mapping[str, Any] | None, default: Pose) -> Pose:
    """Where the options of ``reset`` put home.

    Raises:
        ValueError: an unknown option, or not three finite numbers.
    """
    unknown = set(options or ()) - {"home"}
    if unknown:
        raise ValueError(f"options: expected only 'home', got {sorted(unknown)}")
    if not options:
        return default
    numbers = np.asarray(options["home"], dtype=np.float64)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"options: home: expected [x, y, degrees], got {options['home']!r}")
    x, y, degrees = map(float, numbers)
    return Pose() @ Pose(x, y, math.radians(degrees))


def jsonable(value: Any) -> Any:
    """A keyword as JSON can hold it: specs and plans as mappings, paths as strings."""
    if isinstance(value, FloorPlan):
        return value.to_mapping()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    return str(value) if isinstance(value, Path) else value
