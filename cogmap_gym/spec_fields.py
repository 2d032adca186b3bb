"""Checks on mappings that stand for a spec, as keywords of an environment give them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from numbers import Real
from typing import Any


def number_of(value: object, name: str) -> float:
    """Read a number.

    Raises:
        ValueError: naming it, if it is none (truth values are none).
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name}: expected a number, got {value!r}")
    return float(value)


def known_fields(value: object, spec: type[Any]) -> dict[str, Any]:
    """Read a mapping of the fields of a dataclass.

    Raises:
        ValueError: naming a field that is unknown, or missing and without default.
    """
    if not isinstance(value, Mapping):
        raise ValueError(f"{spec.__name__}: expected a mapping of its fields, got {value!r}")
    known = {field.name: field for field in fields(spec)}
    for name in value:
        if name not in known:
            raise ValueError(f"{spec.__name__}: unknown field {name!r}; known: {sorted(known)}")
    for name, field in known.items():
        if field.default is MISSING and name not in value:
            raise ValueError(f"{spec.__name__}: missing field {name!r}")
    return dict(value)
