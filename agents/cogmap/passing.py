"""Crossing an exit: the ASR just left is cut, and a new stay begins (thesis 3.5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from agents.cogmap.asr import ASR, compute_asr
from agents.cogmap.curiosity import worth_coming_back
from agents.cogmap.exits import (
    NOWHERE,
    Book,
    Exit,
    crossed_exit,
    give_up_exit,
    replace_exit,
    try_again,
)
from agents.cogmap.free_space import cells_of
from agents.cogmap.memory import CHECK, EXIT, GAP, MARK, Journey, Leads, Memory, Stay
from agents.cogmap.mfis import UNTAGGED, tag
from agents.cogmap.params import Params
from agents.cogmap.places import exits_of
from cogmap_gym.geometry import (
    NO_SEGMENTS,
    Points,
    Segments,
    cross,
    lengths,
    midpoints,
    point_segment_distances,
    segments_cross,
)


def notice_crossing(memory: Memory, params: Params) -> Exit | None:
    """The exit the robot has just crossed, or None."""
    stay = memory.stay
    crossed = crossed_exit(memory.book, stay.path, params.exits)
    return crossed if crossed is not None else _beyond_unnoticed(memory, params)


def _beyond_unnoticed(memory: Memory, params: Params) -> Exit | None:
    """An exit of this place the robot stands squarely before, but on the far side, or None.

    Where two exits lie close together, a stay may begin beyond the second.
    """
    at, p = memory.pose.position, params.exits
    if not (memory.stay.settled or memory.stay.views > params.association.dense_views):
        return None
    for e in exits_of(memory.book, memory.stay.place):
        off = e.middle - at
        depth = float(off @ e.normal) * e.side_of(memory.stay.place)
        aside = abs(float(cross(e.normal, off)))
        width = float(lengths(e.line[None])[0])
        before = p.beyond <= depth <= p.squarely and aside < 0.5 * width - p.slack / 2.0
        if before and e.crossed >= 0 and e.trusted(p) and _free(memory, at, e.middle, params):
            return e
    return None


def _free(memory: Memory, at: Points, target: Points, params: Params) -> bool:
    """Whether nothing seen stands between two points (2,) of the MFIS."""
    line = np.stack((at, target))[None]
    gaps = point_segment_distances(memory.obstacles, line)
    return bool(gaps.min(initial=np.inf) > params.journeys.doorway_free)


def leave(memory: Memory, crossed: Exit, params: Params) -> Memory:
    """Cut the ASR just left, link it by the exit, and begin a stay beyond.

    Args:
        memory: at the moment the crossing is noticed.
        crossed: the exit.
        params: all thresholds.
    """
    stay = memory.stay
    memory = cut(memory, crossed, params)
    ahead = crossed.beyond(stay.place) if crossed.side_of(stay.place) else NOWHERE
    known = crossed.crossed >= 0 and ahead != NOWHERE
    network = memory.network
    if not known:
        network = replace(network, last_id=network.last_id + 1)
        ahead = network.last_id
    book = replace_exit(memory.book, _entered(memory, crossed, ahead))
    departures = tuple(d for d in memory.departures if d[0] != stay.place)
    own = stay.place, _left_open(memory, params)
    return replace(
        memory,
        leads=(*(x for x in memory.leads if x[0] != stay.place), own),
        network=network,
        book=_beyond_it(try_again(book, ahead), memory, ahead),
        stay=_begun(memory, crossed, ahead, known=known),
        departures=(*departures, (stay.place, memory.travelled)),
        intent=None,
        journey=_astray(memory, crossed),
        route=_shortened(memory.route, crossed.id),
    )


def _begun(memory: Memory, crossed: Exit, ahead: int, *, known: bool) -> Stay:
    """The stay that begins in place ``ahead`` as an exit is crossed."""
    return Stay(
        ahead,
        known,
        crossed.id,
        memory.stay.place,
        memory.mapping.step,
        memory.path[-1:, :2],
        looked=known,
        leads=memory.leads_of(ahead),
    )


def _entered(memory: Memory, crossed: Exit, ahead: int) -> Exit:
    """The exit as it is now known, with place ``ahead`` beyond it."""
    place, step = memory.stay.place, memory.mapping.step
    left, right = (place, ahead) if _came_from_left(memory, crossed) else (ahead, place)
    return replace(crossed, left=left, right=right, crossed=step, failures=0, given_up=-1)


def _beyond_it(book: Book, memory: Memory, ahead: int) -> Book:
    """The book with the exit the robot was after put beyond the one its way led through.

    One crossed before stays where it is, but its way is known to be none.
    """
    intent, place = memory.intent, memory.stay.place
    if intent is None or intent.kind not in (EXIT, CHECK):
        return book
    wanted = book[intent.exit - 1]
    if wanted.side_of(place) == 0 or wanted.crossed == memory.mapping.step:
        return book
    if wanted.crossed >= 0:
        return give_up_exit(book, wanted.id, memory.mapping.step, 1)
    left = ahead if wanted.left == place else wanted.left
    right = ahead if wanted.right == place else wanted.right
    changed = replace(wanted, left=left, right=right, failures=wanted.failures + 1)
    return replace_exit(book, changed)


def _astray(memory: Memory, crossed: Exit) -> Journey | None:
    """The journey, when the robot has crossed an exit that it was not after.

    The one it was after is out of reach; a place it was searching is searched.
    """
    journey, intent = memory.journey, memory.intent
    if journey is not None and intent is not None and intent.kind == GAP:
        return replace(journey, searched=journey.searched | {memory.stay.place})
    wanted = intent.exit if intent is not None and intent.kind == MARK else NOWHERE
    if journey is None or wanted in (NOWHERE, crossed.id):
        return journey
    return replace(journey, blocked=journey.blocked | {wanted}, failed=journey.failed | {wanted})


def _left_open(memory: Memory, params: Params) -> Leads:
    """What is left unexplored in the place just left, but what lies inside another place."""
    leads, intent, done = memory.stay.leads, memory.intent, memory.stay.leads.done
    if intent is not None and intent.kind == GAP:  # its way led out of the place
        done = np.concatenate((done, intent.target[None]))
    others = [
        shapely.Polygon(a.boundary)
        for a in memory.network.asrs
        if a.closed and a.id != memory.stay.place
    ]
    elsewhere = shapely.union_all(others)
    shapely.prepare(elsewhere)

    def own(pieces: Segments) -> Segments:
        inside = shapely.contains(elsewhere, shapely.points(midpoints(pieces)))
        return np.asarray(pieces[~inside])

    gaps = worth_coming_back(own(leads.gaps), params.curiosity)
    return replace(leads, gaps=gaps, dim=own(leads.dim), done=done)


def _came_from_left(memory: Memory, crossed: Exit) -> bool:
    """Whether the robot came from the left of the exit: it now stands on the right."""
    now = float((memory.pose.position - crossed.middle) @ crossed.normal)
    start = float((memory.stay.path[0] - crossed.middle) @ crossed.normal)
    return now < 0.0 if now != 0.0 else start > 0.0


def _shortened(route: tuple[int, ...] | None, crossed: int) -> tuple[int, ...] | None:
    """A route without its first exit once that is crossed; None where the robot left it."""
    if route and route[0] == crossed:
        return route[1:]
    return None


def cut(memory: Memory, crossed: Exit, params: Params) -> Memory:
    """Algorithm 6 for the place just left, by the exit crossed; its surfaces are tagged."""
    stay, mfis = memory.stay, memory.mapping.mfis
    asr = _compute(memory, crossed, params)
    new = mfis.rows_of(np.asarray(asr.surfaces, dtype=np.int64))
    new = new[mfis.asr[new] == UNTAGGED]
    mapping = replace(memory.mapping, mfis=tag(mfis, new, stay.place))
    return replace(memory, mapping=mapping, network=memory.network.with_asr(asr))


def _compute(memory: Memory, crossed: Exit, params: Params) -> ASR:
    """The ASR of the present stay, from surfaces of no other ASR (step 3a)."""
    stay, mfis = memory.stay, memory.mapping.mfis
    rows = np.flatnonzero((mfis.asr == UNTAGGED) | (mfis.asr == stay.place))
    driven = np.stack((stay.path[:-1], stay.path[1:]), axis=1)
    # What the robot drove through was a door then shut (thesis 4.2.2, surface 8).
    solid = ~segments_cross(mfis.surfaces[rows], driven).any(axis=1)
    rows = rows[solid]
    before = memory.network.asr(stay.place)
    others = [
        e.line for e in exits_of(memory.book, stay.place)
        if e.id != crossed.id and e.trusted(params.exits)
    ]  # fmt: skip
    return compute_asr(
        stay.place,
        mfis.surfaces[rows],
        mfis.ids[rows],
        crossed.line,
        np.stack(others) if others else NO_SEGMENTS,
        stay.path,
        params.boundary,
        None if before is None else before.looks,
        lambda points: np.isin(cells_of(points, params.curiosity), stay.leads.seen),
    )
