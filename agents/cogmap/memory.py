"""All that the robot remembers, as one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.association import Beams
from agents.cogmap.exits import NOWHERE, Book, Exit
from agents.cogmap.locate import NO_PAIRS
from agents.cogmap.mapper import BLANK, Mapping
from agents.cogmap.mfis import FORGOTTEN, UNTAGGED, tag
from agents.cogmap.places import Network
from agents.cogmap.view import EMPTY_VIEW
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments

NO_POINTS: Points = np.zeros((0, 2))
NO_POINTS.setflags(write=False)
NO_CELLS: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
NO_CELLS.setflags(write=False)

FIRST_PLACE = 1
"""The id of the place in which the robot's life begins."""
LOOK, SPOT, EXIT, CHECK, GAP, MARK = "look", "spot", "exit", "check", "gap", "mark"
"""Kinds of intent: look round, go to a spot to look round, cross an exit, go before one seen once
to see it again, reach a gap or a mark."""
TRAIL = "trail"
"""And this one: go back along the path."""


@dataclass(frozen=True, slots=True, eq=False)
class Intent:
    """What the robot is about, until it is done or given up."""

    kind: str
    target: Points
    """(2,) in the MFIS; the middle of the exit for an exit."""
    exit: int = 0
    """Id of the exit to cross, or 0."""
    steps: int = 0
    """Steps spent on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Leads:
    """What a place still hides, and what was done about it."""

    gaps: Segments = field(default_factory=lambda: NO_SEGMENTS)
    """(G, 2, 2) in the MFIS: gaps not yet explored, what they hide on the right."""
    dim: Segments = field(default_factory=lambda: NO_SEGMENTS)
    """(D, 2, 2) in the MFIS: walls seen too sparsely to show a door."""
    lit: Points = field(default_factory=lambda: NO_POINTS)
    """(L, 2) in the MFIS: walls once seen densely."""
    done: Points = field(default_factory=lambda: NO_POINTS)
    """(K, 2) in the MFIS: targets reached or given up."""
    seen: NDArray[np.int64] = field(default_factory=lambda: NO_CELLS)
    """(C,): cells of the MFIS seen to be free from this place, in order (``free_cells``)."""


@dataclass(frozen=True, slots=True, eq=False)
class Stay:
    """The time in one place, from the crossing of its entry."""

    place: int
    known: bool
    """Whether the place is one of the network, not a provisional id."""
    entry: int
    """Id of the exit by which the robot came, 0 where it started."""
    came_from: int
    """The place left by that exit, or 0."""
    began: int
    """Step of the crossing."""
    path: Points
    """(P, 2) in the MFIS, from the entry to the present position."""
    beams: tuple[Beams, ...] = ()
    """Beams of the last views of the stay, in the MFIS."""
    settled: bool = False
    """Whether the robot has found itself by the surfaces of this place."""
    views: int = 0
    """Views taken in this stay."""
    looked: bool = False
    """Whether the robot has looked round."""
    turned: float = 0.0
    """How far it has turned in looking round [rad]."""
    leads: Leads = field(default_factory=Leads)
    """What this place still hides."""
    search: Segments = field(default_factory=lambda: NO_SEGMENTS)
    """(S, 2, 2) in the MFIS: walls still to be looked at squarely for new exits."""
    searching: int = -1
    """Steps spent on looking for new exits here; -1 before it began."""
    search_end: float = np.inf
    """Metres driven in all at which looking for new exits here is no longer worth it."""


@dataclass(frozen=True, slots=True, eq=False)
class Mark:
    """A remembered spot."""

    id: int
    place: int
    point: Points
    """(2,) in the MFIS."""


@dataclass(frozen=True, slots=True)
class Journey:
    """The way to a mark, and what was learned on it."""

    mark: int
    """Id of the mark."""
    blocked: frozenset[int] = frozenset()
    """Exits found shut or out of reach since it began."""
    failed: frozenset[int] = frozenset()
    """Those of them that could not be reached, though they were not seen to be shut."""
    searched: frozenset[int] = frozenset()
    """Places searched for another way since it began."""
    retried: bool = False
    """Whether the failed exits were given another chance."""
    lost: int = 0
    """Steps spent without a known way."""
    lost_at: int = -1
    """The last of them."""
    there: int = 0
    """Steps spent in the goal's place."""
    retraced: int = 0
    """Steps spent on going back along the path."""
    cut: tuple[tuple[float, float], ...] = ()
    """Spots (x, y) in the MFIS on the path that could not be reached."""
    looking: bool = True
    """Whether the robot still looks round, before it sets out, for what has changed."""


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """The MFIS, the network of ASRs, and what the robot is doing."""

    mapping: Mapping
    obstacles: Points
    """(P, 2) in the MFIS."""
    book: Book
    network: Network
    stay: Stay
    path: Points
    """(T, 3): the last poses in the MFIS, as they were believed then."""
    travelled: float
    """Metres driven, by odometry."""
    departures: tuple[tuple[int, float], ...]
    """(place, metres driven when it was last left)."""
    marks: tuple[Mark, ...]
    intent: Intent | None
    route: tuple[int, ...] | None
    """Exits still to cross on a journey."""
    status: str
    leads: tuple[tuple[int, Leads], ...] = ()
    """(place, what was left unexplored in it) of the places left so far."""
    journey: Journey | None = None
    """The present journey, or None while exploring."""

    @property
    def pose(self) -> Pose:
        """``mfis_from_robot``."""
        return self.mapping.mfis_from_robot

    def mark(self, mark_id: int) -> Mark | None:
        """The mark of this id, or None."""
        return next((m for m in self.marks if m.id == mark_id), None)

    def exit(self, exit_id: int) -> Exit:
        """The exit of this id."""
        return self.book[exit_id - 1]

    def leads_of(self, place: int) -> Leads:
        """What was left unexplored in a place."""
        return next((leads for p, leads in self.leads if p == place), Leads())

    def since_left(self, place: int) -> float:
        """Metres driven since the place was last left."""
        return next((self.travelled - at for p, at in self.departures if p == place), np.inf)

    def with_stay(self, **changes: object) -> Memory:
        """The memory with fields of the present stay changed."""
        return replace(self, stay=replace(self.stay, **changes))  # type: ignore[arg-type]

    def with_leads(self, **changes: object) -> Memory:
        """The memory with fields of the present place's leads changed."""
        return self.with_stay(leads=replace(self.stay.leads, **changes))  # type: ignore[arg-type]


def place_of(memory: Memory, mark: Mark) -> int:
    """The place in which a mark lies: that whose boundary holds it, else where it was given.

    A mark may be given before the robot has noticed that it has crossed an exit.
    """
    holds = [
        a.id
        for a in memory.network.asrs
        if a.closed and shapely.contains_xy(shapely.Polygon(a.boundary), *mark.point)
    ]
    return mark.place if not holds or mark.place in holds else holds[0]


def back_home(memory: Memory) -> Memory:
    """The memory of a robot that was carried back to where, and as, its life began.

    That is the origin of the MFIS, in its first place. Of the way there it knows nothing; what it
    saw last, in a place it had not left yet, belongs to that place if it was known.
    """
    stay, mfis = memory.stay, memory.mapping.mfis
    last = (mfis.born >= stay.began) & (mfis.asr == UNTAGGED)
    mapping = replace(
        memory.mapping,
        mfis=tag(mfis, np.flatnonzero(last), stay.place if stay.known else FORGOTTEN),
        mfis_from_robot=Pose(),
        view=EMPTY_VIEW,
        ids=NO_CELLS,
        pairs=NO_PAIRS,
    )
    left = (*(x for x in memory.leads if x[0] != stay.place), (stay.place, stay.leads))
    memory = replace(memory, mapping=mapping, obstacles=NO_POINTS, leads=left)
    home = Stay(
        FIRST_PLACE,
        known=True,
        entry=0,
        came_from=NOWHERE,
        began=mapping.step + 1,
        path=NO_POINTS,
        settled=True,
        looked=True,
        leads=memory.leads_of(FIRST_PLACE),
    )
    return replace(memory, stay=home, intent=None, route=None, journey=None, status="back home")


NEWBORN = Memory(
    mapping=BLANK,
    obstacles=NO_POINTS,
    book=(),
    network=Network((), 1),
    stay=Stay(FIRST_PLACE, False, 0, NOWHERE, 0, NO_POINTS),
    path=np.zeros((0, 3)),
    travelled=0.0,
    departures=(),
    marks=(),
    intent=None,
    route=None,
    status="newborn",
)
