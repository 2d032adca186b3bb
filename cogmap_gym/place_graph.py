"""How a believed network of places agrees with the rooms and doors that a robot has truly used.

The truth is the rooms in which the robot has been and the doors through which it has gone. A
believed place stands for the room in which the robot mostly was while it believed to be there. Of
parallel doors between two rooms one counts: graphs here are simple.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import networkx as nx
import numpy as np
import shapely

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points
from cogmap_gym.topology import rooms_of_places, true_crossings, true_links, visits

TIMEOUT_S = 5.0
"""How long an edit distance may be searched for [s]. Ours: with rooms for labels it takes 0.1 s."""
FEWEST_EXITS = 3
"""Two exits are always in the right cyclic order [-]."""


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A network of places, and which true room each stands for."""

    graph: nx.Graph[int]
    """Places by id, each with its ``room``; an edge where there is a link."""
    exits: tuple[tuple[int, Points, Sequence[int]], ...]
    """Of each place with a boundary: its id, that boundary (K, 2), and its exits' ids."""
    links: tuple[tuple[int, int, int], ...]
    """(place, exit, place)."""
    lines: Mapping[int, Points]
    """Where each exit is, (2, 2), in the frame of the boundaries."""


def believed_network(sketch: Mapping[str, Any], room_of: Mapping[int, str]) -> Network:
    """The network of a robot's sketch; places in which it never was are left out.

    Args:
        sketch: as ``Agent.sketch`` gives it.
        room_of: the true room of each place.
    """
    graph: nx.Graph[int] = nx.Graph()
    for asr in sketch["asrs"]:
        if asr["id"] in room_of:
            graph.add_node(asr["id"], room=room_of[asr["id"]])
    links = tuple((a, e, b) for a, e, b in sketch["links"] if a in graph and b in graph)
    graph.add_edges_from((a, b) for a, _, b in links)
    bounded = [asr for asr in sketch["asrs"] if asr["id"] in graph and len(asr["boundary"]) > 2]
    exits = tuple((a["id"], np.array(a["boundary"], float), a["exits"]) for a in bounded)
    lines = {e["id"]: np.array((e["p"], e["q"]), float) for e in sketch["exits"]}
    return Network(graph, exits, links, lines)


def true_network(plan: FloorPlan, poses: Array) -> nx.Graph[str]:
    """The rooms of a path and the doors that it went through, as a graph of rooms.

    Args:
        plan: the truth.
        poses: (T, 3) true poses.
    """
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from((visit.room, {"room": visit.room}) for visit in visits(plan, poses))
    used = {crossing.door for crossing in true_crossings(plan, poses)}
    for sides, door in true_links(plan, graph.nodes):
        if door in used:
            graph.add_edge(*sorted(sides), door=door)
    return graph


def network_scores(
    sketch: Mapping[str, Any],
    places: Sequence[int],
    rooms: Sequence[str],
    plan: FloorPlan,
    poses: Array,
) -> dict[str, float | None]:
    """All scores of this module; None for a robot that believes in no places.

    Args:
        sketch: at the end.
        places: (T,), where the robot believed to be at each step.
        rooms: (T,), where it truly was.
        plan: the truth.
        poses: (T, 3), true poses.

    Returns:
        ``rooms_found``: share of the true rooms for which there is exactly one place;
        ``link_precision`` and ``link_recall``, of pairs of rooms (C. J. van Rijsbergen,
        "Information Retrieval", 1979); ``edit_distance`` and ``exit_order``, as below.
    """
    none = ("rooms_found", "link_precision", "link_recall", "edit_distance", "exit_order")
    if not sketch["asrs"]:
        return dict.fromkeys(none)
    told = [k for k, room in enumerate(rooms) if room]
    room_of = rooms_of_places([places[k] for k in told], [rooms[k] for k in told], len(told))
    believed, true = believed_network(sketch, room_of), true_network(plan, poses)
    names = list(nx.get_node_attributes(believed.graph, "room").values())
    pairs = _pairs(believed.graph.edges, room_of)
    wanted = {frozenset(edge) for edge in true.edges}
    right = sum(pair in wanted for pair in pairs)
    return {
        "rooms_found": sum(names.count(room) == 1 for room in true) / max(len(true), 1),
        "link_precision": right / len(pairs) if pairs else None,
        "link_recall": len(wanted & set(pairs)) / len(wanted) if wanted else None,
        "edit_distance": edit_distance(believed.graph, true),
        "exit_order": exit_order(believed, true, room_of, plan),
    }


def edit_distance(believed: nx.Graph[Any], true: nx.Graph[Any]) -> float | None:
    """How many places and links must be added or taken away to make one network the other.

    Graph edit distance (A. Sanfeliu and K.-S. Fu, IEEE SMC 13, 1983), by the search of Z.
    Abu-Aisheh, R. Raveaux, J.-Y. Ramel and P. Martineau, "An exact graph edit distance algorithm
    for solving pattern recognition problems", ICPRAM 2015. To let a place stand for another room
    than its own costs as much as to add one.

    Returns:
        None where it was not found in time.
    """
    told = nx.graph_edit_distance(
        believed, true, node_match=lambda a, b: a["room"] == b["room"], timeout=TIMEOUT_S
    )
    return None if told is None else float(told)


def exit_order(
    believed: Network, true: nx.Graph[str], room_of: Mapping[int, str], plan: FloorPlan
) -> float | None:
    """Share of the places whose exits go round in the true cyclic order.

    The thesis keeps the exits of a place in their order along its boundary; mirrored or crossed
    exits are out of order. Exits count that lead to another place by a door that was gone through.

    Returns:
        None where no place has three such exits and a boundary.
    """
    right = []
    for place, boundary, exits in believed.exits:
        room = room_of[place]
        doors = {}
        for a, leave, b in believed.links:
            sides = (room_of[a], room_of[b])
            if place in (a, b) and leave in exits and true.has_edge(*sides):
                doors[leave] = true.edges[sides]["door"]
        if len(set(doors.values())) < max(len(doors), FEWEST_EXITS):
            continue
        mine = _round(boundary, {door: believed.lines[e] for e, door in doors.items()})
        theirs = _round(plan.rooms[room], {door: plan.doors[door] for door in doors.values()})
        right.append(_is_same_cycle(mine, theirs))
    return sum(right) / len(right) if right else None


def _pairs(edges: Iterable[tuple[int, int]], room_of: Mapping[int, str]) -> list[frozenset[str]]:
    """The rooms that links join; two places of one room join it with itself."""
    return [frozenset((room_of[a], room_of[b])) for a, b in edges]


def _round(boundary: Points, lines: Mapping[str, Points]) -> list[str]:
    """Names of lines in the order of their middles along a boundary, counter-clockwise."""
    ring = shapely.LinearRing(boundary)
    ring = ring if ring.is_ccw else ring.reverse()
    along = {name: ring.project(shapely.Point(line.mean(axis=0))) for name, line in lines.items()}
    return sorted(along, key=lambda name: along[name])


def _is_same_cycle(one: Sequence[str], other: Sequence[str]) -> bool:
    start = list(other).index(one[0])
    return list(one) == [*other[start:], *other[:start]]
