"""The proof that a map is never corrected: old surfaces only lengthen along their own lines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from cogmap_gym.geometry import Segments, cross, lengths

ON_LINE_M = 1e-6
"""Rounding allowed in the proof that a surface stays on its line [m]."""


class Edit(Protocol):
    """One change of a map, as the robot's log has it."""

    @property
    def step(self) -> int:
        """When."""

    @property
    def id(self) -> int:
        """Which surface, from 1."""

    @property
    def before(self) -> Segments | None:
        """(2, 2) in the map's frame; None when the surface was entered."""

    @property
    def after(self) -> Segments:
        """(2, 2) in the map's frame."""

    @property
    def in_view(self) -> Segments:
        """(2, 2) in the robot's frame: the sighting that made it."""

    @property
    def sighted(self) -> int:
        """The step of that sighting."""


def edit_violations(edits: Iterable[Edit], surfaces: Mapping[int, Segments]) -> list[str]:
    """Where an edit log breaks the law that an old surface only lengthens along its own line.

    Each surface is entered once; every later edit begins with what the last one left, keeps
    the line and takes nothing off; and the map is what the log says. Nothing returned is
    the proof that no old surface was ever moved or turned.

    Args:
        edits: the whole log, in order.
        surfaces: the map at its end, (2, 2) by id.
    """
    now: dict[int, Segments] = {}
    wrong: list[str] = []
    for edit in edits:
        name, last = f"step {edit.step}, surface {edit.id}", now.get(edit.id)
        if (edit.before is None) != (last is None):
            wrong.append(f"{name}: entered twice, or changed before it was entered")
        elif edit.before is not None and last is not None:
            if not np.array_equal(edit.before, last):
                wrong.append(f"{name}: changed outside the log")
            wrong += [f"{name}: {fault}" for fault in _faults(edit.before, edit.after)]
        now[edit.id] = edit.after
    for number in sorted(now.keys() | surfaces.keys()):
        if number not in now or number not in surfaces:
            wrong.append(f"at the end, surface {number}: not in both the log and the map")
        elif not np.array_equal(now[number], surfaces[number]):
            wrong.append(f"at the end, surface {number}: changed outside the log")
    return wrong


def _faults(before: Segments, after: Segments) -> list[str]:
    size = float(lengths(before[None])[0])
    unit = (before[1] - before[0]) / size
    off = np.abs(cross(unit, after - before[0])).max()
    start, end = (after - before[0]) @ unit
    faults = [f"left its line by {off:.2g} m"] if off > ON_LINE_M else []
    if start > ON_LINE_M or end < size - ON_LINE_M:
        faults.append(f"shortened from 0..{size:.3f} to {start:.3f}..{end:.3f} m")
    return faults
