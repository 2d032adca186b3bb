"""Whether surfaces are recognised rightly."""

from __future__ import annotations

from dataclasses import dataclass

from cogmap_gym.geometry import Pose
from cogmap_gym.map_metrics import shows_again, true_lines
from cogmap_gym.run_record import Record


@dataclass(frozen=True, slots=True)
class Names:
    """Old surfaces named in the views of some steps."""

    right: frozenset[int]
    """Ids that were always named rightly."""
    wrong: frozenset[int]
    """Ids that were named wrongly at least once."""
    total: int
    """How many names were given."""
    false: int
    """How many of them were wrong."""


def old_names(record: Record, first: int, last: int, before: int, place: int | None) -> Names:
    """Judge the names that surfaces of views got from surfaces entered before.

    A name is right if the surface of the view truly shows again the piece of wall that the
    old surface showed when it was entered, with what it has grown to since; see
    ``cogmap_gym.map_metrics.shows_again``.

    Args:
        record: the episode.
        first: the first step judged.
        last: the last step judged.
        before: old is what was entered before this step.
        place: only old surfaces of this place; None for all.
    """
    right: set[int] = set()
    wrong: set[int] = set()
    total = false = 0
    for at, step in enumerate(record.steps[first : last + 1], start=first):
        rows = [
            row
            for row, name in enumerate(step.names.tolist())
            if name in record.origins
            and record.origins[name].step < min(at, before)
            and place in (None, int(step.tags[name - 1]))
        ]
        true = Pose(*(float(v) for v in step.pose)).apply(step.seen[rows])
        lines = true_lines(true, record.faces, step.shut)
        for name, seen, line in zip(step.names[rows].tolist(), true, lines.tolist(), strict=True):
            known, now = record.origins[name], step.surfaces[name - 1]
            same = shows_again(seen, line, known, now, record.faces)
            (right if same else wrong).add(name)
            total, false = total + 1, false + (not same)
    return Names(frozenset(right - wrong), frozenset(wrong), total, false)
