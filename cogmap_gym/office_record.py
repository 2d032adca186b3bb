"""An episode in an office as the scores need it: what was true and what was believed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points
from cogmap_gym.topology import Crossing, Visit, true_crossings, visits

NO_ROUTE = "no route"
"""A robot that thinks its goal cannot be reached has these words in its status."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What was true and what was believed after the robot took in one observation."""

    phase: int
    """How many phases were over."""
    pose: Array
    """(3,) true x, y [m], theta [rad]."""
    coverage: float
    """Share of the free area seen so far."""
    mark: int
    """The mark given now, or 0."""
    declared: bool
    """Whether the robot said "I am there"."""
    status: str
    """What it says it is about."""
    seconds: float
    """CPU time that the robot took to decide [s]."""
    believed: Array
    """(3,) pose in the map's frame."""
    place: int
    """The place where the robot thinks it is."""
    known: bool
    """Whether it takes that for a place it has been in before."""
    entry: int
    """The exit by which it thinks it came, or 0."""
    came_from: int
    """The place it thinks it left by that exit, or 0."""
    began: int
    """The step at which it thinks it crossed that exit."""
    places: int
    """How many places it has cut so far."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """How a phase with a goal came out."""

    phase: int
    """How many phases were over when it began."""
    mark: int
    """Which mark was the goal."""
    room: str
    """The room of the mark."""
    success: bool
    """Whether the first declaration was right."""
    reachable: bool
    """Whether there was a way."""
    distance: float
    """How far from the mark it ended [m]; -1 where the mark was never given."""
    spl: float
    """Success weighted by path length, or -1."""
    spl_learning: float
    """The same against the shortest walk that learns of a block on seeing it, or -1."""


@dataclass(frozen=True, eq=False)
class OfficeRecord:
    """An episode in an office, with the truth."""

    plan: FloorPlan
    moments: Sequence[Moment]
    outcomes: Sequence[Outcome]
    """Of the goals that are over."""
    coverage: float
    """Share of the free area seen in the end."""
    boundaries: Mapping[int, Points]
    """Of each place cut, (K, 2) in the map's frame; (0, 2) where it is open."""

    @cached_property
    def poses(self) -> Array:
        """(T, 3) true poses."""
        return np.array([moment.pose for moment in self.moments])

    @cached_property
    def believed(self) -> Array:
        """(T, 3) poses in the map's frame."""
        return np.array([moment.believed for moment in self.moments])

    @cached_property
    def visits(self) -> list[Visit]:
        """The true stays."""
        return visits(self.plan, self.poses)

    @cached_property
    def rooms(self) -> list[str]:
        """At each step the true room; empty before the first."""
        found = [""] * (self.visits[0].first if self.visits else len(self.moments))
        for visit in self.visits:
            found += [visit.room] * (visit.last + 1 - visit.first)
        return found

    @cached_property
    def crossings(self) -> list[Crossing]:
        """The doors truly crossed, in order."""
        return true_crossings(self.plan, self.poses)
