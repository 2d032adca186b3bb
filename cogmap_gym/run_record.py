"""An episode of Thesis-v0 as the scores need it: what was true and what was believed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.edit_log import Edit
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points, Segments
from cogmap_gym.map_metrics import Origin, WallFaces, origins, wall_faces
from cogmap_gym.topology import (
    Crossing,
    Fault,
    Visit,
    noticed,
    rooms_of_places,
    topology_faults,
    true_crossings,
    true_links,
    visits,
)

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """What was true and what was believed after the robot took in one observation."""

    phase: int
    pose: Array
    """(3,) true x, y [m], theta [rad]."""
    shut: frozenset[str]
    """Names of the doors that are shut."""
    odometry: Array
    """(3,) measured motion since the last observation."""
    mapped: Array
    """(3,) pose in the map's frame by which the view was laid into the map."""
    believed: Array
    """(3,) pose in the map's frame in the end; another where a place was just recognised."""
    seen: Segments
    """(N, 2, 2) surfaces of the view in the robot's frame."""
    names: Ints
    """(N,) which surface of the map each is thought to be, 0 for none."""
    surfaces: Segments
    """(M, 2, 2) the map; row r has the id r + 1."""
    entered: NDArray[np.bool_]
    """(M,) which surfaces are in the map for good; the others still wait to be."""
    tags: Ints
    """(M,) the place of each surface, 0 for none yet, -1 for a surface given up."""
    place: int
    """The place where the robot thinks it is."""
    entry: int
    """The exit by which it thinks it came, or 0."""
    began: int
    """The step at which it thinks it crossed that exit."""
    boundaries: Mapping[int, Points]
    """Of each place cut so far, (K, 2) in the map's frame; (0, 2) where it is open."""
    links: tuple[tuple[int, int, int], ...]
    """(place, exit, place) of every exit crossed."""


@dataclass(frozen=True, eq=False)
class Record:
    """An episode of Thesis-v0 with the truth."""

    plan: FloorPlan
    rooms: tuple[str, ...]
    """The rooms of the ring; the first is home's."""
    steps: Sequence[Step]
    edits: Sequence[Edit]
    tasks: Sequence[str]
    """Of each finished phase its task."""
    successes: Sequence[bool]
    """And whether it came out well."""
    final_distance: float
    """How far from home the last way home ended [m], or -1."""

    @cached_property
    def poses(self) -> Array:
        """(T, 3) true poses."""
        return np.array([step.pose for step in self.steps])

    @cached_property
    def mapped(self) -> Array:
        """(T, 3) poses by which the views were laid into the map."""
        return np.array([step.mapped for step in self.steps])

    @cached_property
    def visits(self) -> list[Visit]:
        """The true stays."""
        return visits(self.plan, self.poses)

    @cached_property
    def faces(self) -> WallFaces:
        """All wall faces of the plan."""
        return wall_faces(self.plan)

    @cached_property
    def origins(self) -> dict[int, Origin]:
        """Where each surface of the map truly comes from."""
        shut = [step.shut for step in self.steps]
        return origins(self.edits, self.poses, self.mapped, shut, self.faces)

    @cached_property
    def crossings(self) -> list[Crossing]:
        """The doors it truly went through, in order."""
        return true_crossings(self.plan, self.poses)

    @cached_property
    def believed_crossings(self) -> list[int]:
        """The steps at which it thought it had crossed an exit, in order."""
        return sorted({step.began for step in self.steps if step.entry})

    @cached_property
    def door_of_exits(self) -> dict[int, str]:
        """The true door of each exit, from the crossings that were truly some."""
        began = self.believed_crossings
        pairs = noticed(self.crossings, began).pairs
        door_at = {began[k]: self.crossings[row].door for row, k in pairs}
        return {step.entry: door_at[step.began] for step in self.steps if step.began in door_at}

    def rooms_of_places(self, until: int) -> dict[int, str]:
        """The true room of each place, by the steps up to this one."""
        rooms = [visit.room for visit in self.visits for _ in range(visit.first, visit.last + 1)]
        return rooms_of_places([step.place for step in self.steps], rooms, until)

    def network_faults(self, until: int, rooms: Iterable[str]) -> list[Fault]:
        """What is wrong with its network at a step, if it should be that of these rooms."""
        step = self.steps[until]
        places, wanted = {*step.boundaries, step.place}, true_links(self.plan, rooms)
        room_of = self.rooms_of_places(until)
        return topology_faults(places, step.links, room_of, self.door_of_exits, wanted)

    def lap_ends(self) -> list[Visit | None]:
        """For each lap the true stay in the first room that ends it; None for a failed lap."""
        laps = [k for k, task in enumerate(self.tasks) if task == "explore"]
        return [self._stay_after(k) if self.successes[k] else None for k in laps]

    def _stay_after(self, phase: int) -> Visit | None:
        over = next((t for t, step in enumerate(self.steps) if step.phase > phase), None)
        return next((v for v in self.visits if over is not None and over <= v.last), None)
