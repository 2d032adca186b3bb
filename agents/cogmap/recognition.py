"""Recognising on re-entry that an unknown place is one of the network (thesis 4.2.2, 4.3.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from agents.cogmap.asr import ASR
from agents.cogmap.association import Beams, Hypothesis, best_hypothesis
from agents.cogmap.exits import NOWHERE, Book, Exit, match_exit, rename_place, replace_exit
from agents.cogmap.false_exits import rejoin, together
from agents.cogmap.landmarks import find_landmarks
from agents.cogmap.memory import Leads, Mark, Memory
from agents.cogmap.mfis import FORGOTTEN, MFIS, UNTAGGED, tag
from agents.cogmap.params import Association, Params
from agents.cogmap.same_place import hangs_together
from cogmap_gym.geometry import Pose, segments_cross


def recognise_place(memory: Memory, params: Params, last_chance: bool = False) -> Memory:
    """Close the loop if the evidence of the last views says so.

    Args:
        memory: after a view in the present stay.
        params: all thresholds.
        last_chance: try now, since the place is about to be cut as a new ASR.
    """
    p, stay = params.association, memory.stay
    if p.literal:
        return _recognise_by_names(memory, params)
    if stay.settled or not stay.entry or not (last_chance or _due(stay.views, p)):
        return memory
    if not stay.known:
        memory = rejoin(memory, params)
        if memory.stay is not stay:
            return memory
    beams = _beams_inside(memory)
    tried = [
        best_hypothesis(a.id, _surfaces(memory, a), beams, memory.since_left(a.id), p)
        for a in _candidates(memory, p)
        if len(beams.ends)
    ]
    tried = [h for h in tried if h.holds(p) and _possible(memory, h, p)]
    tried.sort(key=lambda h: h.score(p), reverse=True)
    clear = len(tried) == 1 or (
        len(tried) > 1 and tried[0].score(p) - tried[1].score(p) >= p.margin
    )
    if clear:
        return _accept(memory, tried[0], params)
    whole = None if stay.known else _part_of(memory, beams, params)
    if whole is not None:
        partly = not _drifted(whole, params.association)
        memory = _accept(memory, whole, params, partly=partly)
        return memory if partly else memory.with_stay(looked=False, turned=0.0)
    # A known place that cannot be confirmed is taken as it is believed to lie.
    late = stay.known and (last_chance or stay.views >= p.dense_views)
    return memory.with_stay(settled=True) if late else memory


def _part_of(memory: Memory, beams: Beams, params: Params) -> Hypothesis | None:
    """The one known place that the present one turns out to be a part of, or None."""
    found = []
    for asr in memory.network.asrs:
        if asr.id != memory.stay.came_from and asr.closed:
            whole = hangs_together(memory, asr, beams, params)
            if whole is not None and not _elsewhere(memory, whole):
                found.append(whole)
    return found[0] if len(found) == 1 else None


def _recognise_by_names(memory: Memory, params: Params) -> Memory:
    """As written: landmarks that belong to an ASR say that the robot is in it (thesis 4.2.2)."""
    stay, mapping = memory.stay, memory.mapping
    if stay.known or not stay.entry:
        return memory.with_stay(settled=True)
    rows = mapping.mfis.rows_of(np.unique(mapping.ids[mapping.ids > 0]))
    tags = mapping.mfis.asr[rows]
    named = np.bincount(tags[tags > 0], minlength=1)
    named[min(stay.came_from, len(named) - 1)] = 0
    if named.max() < params.association.literal_names:
        return memory
    return _accept(memory, Hypothesis(int(named.argmax()), Pose(), 1.0, 0.0, 0.0), params)


def _candidates(memory: Memory, p: Association) -> list[ASR]:
    """The places this one may be: where the exit is known to lead, else any that is not too far."""
    stay = memory.stay
    if stay.known:
        return [a for a in memory.network.asrs if a.id == stay.place and a.closed]
    return [a for a in memory.network.asrs if a.id != stay.came_from and _reachable(memory, a, p)]


def _due(views: int, p: Association) -> bool:
    if views <= p.dense_views:
        return views >= p.first_view
    return (views - p.dense_views) % p.later_every == 0


def _beams_inside(memory: Memory) -> Beams:
    """Beams of the last views of this stay that do not look back through its entry."""
    origins = np.concatenate([b.origins for b in memory.stay.beams])
    ends = np.concatenate([b.ends for b in memory.stay.beams])
    entry = memory.exit(memory.stay.entry).line[None]
    back = segments_cross(np.stack((origins, ends), axis=1), entry)[:, 0]
    return Beams(origins[~back], ends[~back])


def _reachable(memory: Memory, asr: ASR, p: Association) -> bool:
    """Whether the robot or the exit it crossed may lie at the place, given the drift allowed.

    A place of which only a part was seen may be entered far from that part.
    """
    if not asr.closed:
        return False
    drift = min(p.base_shift + p.shift_per_metre * memory.since_left(asr.id), p.max_shift)
    at, middle = memory.pose.position, memory.exit(memory.stay.entry).middle
    reach = drift + p.door_distance
    low, high = asr.boundary.min(axis=0) - reach, asr.boundary.max(axis=0) + reach
    near = [bool((low <= q).all() and (q <= high).all()) for q in (at, middle)]
    if not any(near):
        return False  # the bounds alone say so
    polygon = shapely.Polygon(asr.boundary)
    inside = shapely.distance(polygon, shapely.Point(at)) <= drift
    at_edge = shapely.distance(polygon.exterior, shapely.Point(middle)) <= reach
    return bool(inside or at_edge)


def _surfaces(memory: Memory, asr: ASR) -> NDArray[np.float64]:
    """The surfaces of a known place, (M, 2, 2)."""
    mfis = memory.mapping.mfis
    return np.asarray(mfis.surfaces[mfis.asr == asr.id])


def _possible(memory: Memory, hypothesis: Hypothesis, p: Association) -> bool:
    """Whether the path and the crossed exit fit the place, and no link contradicts it."""
    asr = memory.network.asr(hypothesis.place)
    assert asr is not None, "a hypothesis names an ASR of the network"
    polygon = shapely.Polygon(asr.boundary)
    shapely.prepare(polygon)
    path = shapely.points(hypothesis.shift.apply(memory.stay.path))
    inside = np.mean(shapely.distance(polygon, path) <= p.inside_slack)
    entry = memory.exit(memory.stay.entry)
    door = hypothesis.shift.apply(entry.middle)
    at_edge = shapely.distance(polygon.exterior, shapely.Point(door)) <= p.door_distance
    fits = hypothesis.sure(p) or (inside >= p.min_inside and at_edge)
    return bool(fits and not _elsewhere(memory, hypothesis))


def _elsewhere(memory: Memory, hypothesis: Hypothesis) -> bool:
    """Whether the exit crossed is one of the known place that is known to lead elsewhere."""
    entry = memory.exit(memory.stay.entry)
    twin = None if memory.stay.known else _twin(memory, entry, hypothesis)
    return (
        twin is not None
        and twin.crossed >= 0
        and twin.beyond(hypothesis.place) not in (NOWHERE, memory.stay.came_from)
    )


def _twin(memory: Memory, entry: Exit, hypothesis: Hypothesis) -> Exit | None:
    """The exit of the known place that the crossed exit is, seen from the other side."""
    door = hypothesis.shift.apply(entry.middle)
    near = [
        e
        for e in memory.book
        if e.id != entry.id
        and hypothesis.place in (e.left, e.right)
        and e.left != e.right
        and float(np.hypot(*(e.middle - door))) < float(np.hypot(*(e.line[1] - e.line[0])))
    ]
    return min(near, key=lambda e: float(np.hypot(*(e.middle - door))), default=None)


def _accept(
    memory: Memory, hypothesis: Hypothesis, params: Params, *, partly: bool = False
) -> Memory:
    """Be in the known place: shift the robot, not the map, and forget what was seen twice.

    The MFIS may have a seam here: on the way round, its parts drifted apart, and no part is moved.

    Args:
        memory: before.
        hypothesis: the place, and the shift.
        params: all thresholds.
        partly: whether what was seen since the crossing adds to the place.
    """
    stay, shift, place = memory.stay, hypothesis.shift, hypothesis.place
    entry = memory.exit(stay.entry)
    twin = None if stay.known else _twin(memory, entry, hypothesis)
    mapping = replace(
        memory.mapping,
        mfis=_forget_and_part(memory, hypothesis, params, partly=partly),
        mfis_from_robot=shift @ memory.pose,
    )
    book = memory.book
    if place != stay.place:
        book = _merged_exits(book, stay.place, shift, stay.entry, place, params)
    if twin is not None:
        book = _merge_entry(book, book[entry.id - 1], book[twin.id - 1])
    if _drifted(hypothesis, params.association):
        book = tuple(replace(e, seam=True) if e.id == stay.entry else e for e in book)
    kept = stay.entry if twin is None or twin.crossed < 0 else twin.id
    return replace(
        memory,
        mapping=mapping,
        obstacles=shift.apply(memory.obstacles),
        marks=memory.marks if place == stay.place else _moved_marks(memory, hypothesis),
        book=book,
        stay=replace(
            stay,
            place=place,
            known=True,
            settled=True,
            entry=kept,
            path=shift.apply(stay.path),
            beams=tuple(b.moved(shift) for b in stay.beams),
            looked=stay.looked or not partly,
            leads=_leads(memory, place, partly=partly),
        ),
        intent=None,
        status=f"recognised {place}",
    )


def _leads(memory: Memory, place: int, *, partly: bool) -> Leads:
    """What the place hides, as far as known."""
    own, known = memory.stay.leads, memory.leads_of(place)
    if place == memory.stay.place:
        return own
    return replace(together(known, own), seen=np.union1d(known.seen, own.seen)) if partly else known


def _moved_marks(memory: Memory, hypothesis: Hypothesis) -> tuple[Mark, ...]:
    """The marks, those given in the provisional place now in the known one."""
    return tuple(
        replace(m, place=hypothesis.place, point=hypothesis.shift.apply(m.point))
        if m.place == memory.stay.place
        else m
        for m in memory.marks
    )


def _drifted(hypothesis: Hypothesis, p: Association) -> bool:
    """Whether the robot had drifted so far that the map has a seam at the exit."""
    return hypothesis.distance > p.seam_shift or abs(hypothesis.shift.theta) > p.seam_turn


def _forget_and_part(
    memory: Memory, hypothesis: Hypothesis, params: Params, *, partly: bool
) -> MFIS:
    """Forget what was seen twice; at a seam, what waits untagged stays with the place just left."""
    mfis = tag(memory.mapping.mfis, _ghosts(memory, hypothesis, params, partly=partly), FORGOTTEN)
    if not _drifted(hypothesis, params.association):
        return mfis
    near = mfis.seen >= memory.stay.began - params.frame.recent
    return tag(mfis, np.flatnonzero(near & (mfis.asr == UNTAGGED)), memory.stay.came_from)


def _ghosts(
    memory: Memory, hypothesis: Hypothesis, params: Params, *, partly: bool
) -> NDArray[np.int64]:
    """Rows seen since the crossing, or untagged ones that the known place has already."""
    mfis = memory.mapping.mfis
    since = (mfis.born >= memory.stay.began) & (mfis.asr == UNTAGGED) & (not partly)
    untagged = np.flatnonzero((mfis.asr == UNTAGGED) & ~since)
    known = mfis.surfaces[mfis.asr == hypothesis.place]
    laid = hypothesis.shift.apply(mfis.surfaces[untagged])
    double = find_landmarks(laid, known, params.landmarks) >= 0
    return np.concatenate((np.flatnonzero(since), untagged[double]))


def _merged_exits(
    book: Book, old: int, shift: Pose, entry: int, place: int, params: Params
) -> Book:
    """Exits of the provisional place moved with the robot, and merged with those of the known."""
    own = [e for e in book if place in (e.left, e.right) and e.left != e.right]
    for e in book:
        if e.id == entry or old not in (e.left, e.right):
            continue
        line = shift.apply(e.line)
        if match_exit(tuple(own), line, params.exits) is not None:
            book = replace_exit(book, _void(e))
        else:
            book = replace_exit(book, replace(e, line=line))
    return rename_place(book, old, place)


def _merge_entry(book: Book, entry: Exit, twin: Exit) -> Book:
    """One exit for the crossed one and the known one: the one crossed before, else the new one."""
    if twin.crossed >= 0:
        return replace_exit(replace_exit(book, _void(entry)), replace(twin, crossed=entry.crossed))
    return replace_exit(book, _void(twin))


def _void(e: Exit) -> Exit:
    """An exit that turned out to be another one."""
    return replace(e, left=NOWHERE, right=NOWHERE, sightings=0, crossed=-1)
