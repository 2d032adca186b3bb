"""The network of ASRs: which exits lead from where to where, and the routes over it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.asr import ASR
from agents.cogmap.exits import NOWHERE, Book, Exit
from cogmap_gym.geometry import Points


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """ASRs cut so far and the places they are linked to; links are the crossed exits."""

    asrs: tuple[ASR, ...] = ()
    last_id: int = 0
    """The last id given to a place."""

    def asr(self, asr_id: int) -> ASR | None:
        """The ASR of this id, or None while it was never cut."""
        return next((a for a in self.asrs if a.id == asr_id), None)

    def with_asr(self, asr: ASR) -> Network:
        """The network with this ASR put in or replaced; an open boundary replaces no closed one."""
        old = self.asr(asr.id)
        if old is not None and old.closed and not asr.closed:
            return self
        rest = tuple(a for a in self.asrs if a.id != asr.id)
        return Network(tuple(sorted((*rest, asr), key=lambda a: a.id)), self.last_id)


@dataclass(frozen=True, slots=True)
class Route:
    """A way over known links."""

    exits: tuple[int, ...]
    """Ids of the exits to cross, in order."""
    length: float
    """Metres, from spot to spot in straight lines."""


def within(asr: ASR, points: Points, depth: float) -> NDArray[np.bool_]:
    """Which points (P, 2) lie at least so deep [m] inside a place with a boundary, (P,)."""
    low, high = asr.boundary.min(axis=0) + depth, asr.boundary.max(axis=0) - depth
    inside = np.asarray(((points >= low) & (points <= high)).all(axis=1))
    if inside.any():
        core = shapely.Polygon(asr.boundary).buffer(-depth)
        shapely.prepare(core)
        inside[inside] = shapely.contains_xy(core, *points[inside].T)
    return inside


def links(book: Book) -> list[tuple[int, int, int]]:
    """(asr, exit, asr) of every exit that was crossed, in order of exit id."""
    return [
        (min(e.left, e.right), e.id, max(e.left, e.right))
        for e in book
        if e.crossed >= 0 and NOWHERE not in (e.left, e.right) and e.left != e.right
    ]


def seen_from(book: Book, asr: int) -> set[int]:
    """The places linked to this one that lie in one piece of the MFIS with it."""
    beside = [e for e in book if e.crossed >= 0 and asr in (e.left, e.right) and not e.seam]
    return {e.beyond(asr) for e in beside} - {NOWHERE, asr}


def exits_of(book: Book, asr: int) -> list[Exit]:
    """The exits that have this ASR on one side."""
    return [e for e in book if asr in (e.left, e.right) and e.left != e.right]


def linked(book: Book, start: int, hidden: frozenset[int]) -> set[int]:
    """The places that can be reached from one over known links, itself among them.

    Args:
        book: all exits; those crossed before are the links.
        start: the place.
        hidden: ids of exits not to use.
    """
    graph: nx.Graph[int] = nx.Graph()
    graph.add_node(start)
    graph.add_edges_from((a, b) for a, e, b in links(book) if e not in hidden)
    return set(nx.node_connected_component(graph, start))


def route(
    book: Book, start: Points, here: int, goal: Points, goal_asr: int, hidden: frozenset[int]
) -> Route | None:
    """The shortest way over known links, exit by exit, and its length [m].

    Args:
        book: all exits; those crossed before are the links.
        start: (2,), where the robot is, in ASR ``here``.
        here: its ASR.
        goal: (2,), where it wants to be, in ASR ``goal_asr``.
        goal_asr: the goal's ASR.
        hidden: ids of exits not to use.

    Returns:
        The exits to cross, none when it is there already; None without a way.
    """
    graph: nx.Graph[str | int] = nx.Graph()
    known = [e for e in book if e.crossed >= 0 and e.id not in hidden and e.left != e.right]
    spots: dict[int, list[tuple[str | int, Points]]] = {}
    for e in known:
        spots.setdefault(e.left, []).append((e.id, e.middle))
        spots.setdefault(e.right, []).append((e.id, e.middle))
    spots.setdefault(here, []).append(("start", start))
    spots.setdefault(goal_asr, []).append(("goal", goal))
    for place in spots.values():
        for k, (a, p) in enumerate(place):
            for b, q in place[k + 1 :]:
                length = float(np.hypot(*(p - q)))
                if not graph.has_edge(a, b) or graph[a][b]["weight"] > length:
                    graph.add_edge(a, b, weight=length)
    try:
        way = nx.dijkstra_path(graph, "start", "goal")
    except (nx.NetworkXNoPath, nx.NodeNotFound):
        return None
    whole = sum(graph[a][b]["weight"] for a, b in pairwise(way))
    return Route(tuple(n for n in way if isinstance(n, int)), float(whole))
