"""Scores of an episode in an office against the truth: the figures of issue 3.

``office_score`` makes one flat row of an ``OfficeRecord``; ``cogmap_gym.office_table`` makes
tables of many rows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from cogmap_gym.log_metrics import rigid_fit
from cogmap_gym.office_record import NO_ROUTE, Moment, OfficeRecord, Outcome
from cogmap_gym.reentries import MISSED, WRONG, entries
from cogmap_gym.topology import boundary_ious, noticed, rooms_of_places

COVERED = (0.8, 0.9, 0.95)
"""Shares of the free area whose moves are told [-]. Issue 3 asks for the last."""
CURVE_EVERY = 10
"""Every so many moves the share seen is told [-]."""
PLACES_A_BIN = 5
"""CPU times are told by the number of places, in bins so wide [-]."""
STUCK_M, STUCK_MOVES = 1.0, 40
"""A robot that stays within this [m] for so many moves [-] is said to stand. Ours."""
LINGERED_MOVES = 60
"""A failed run tells where the robot was for so many moves on end [-]. Ours."""
DIGITS = 4


def office_score(record: OfficeRecord, *, exploring: bool) -> dict[str, Any]:
    """All figures of one episode, JSON-able.

    Args:
        record: the episode.
        exploring: whether to see everything was all that was asked.
    """
    goals = [_goal(record, outcome) for outcome in record.outcomes]
    why = [f"mark {goal['mark']}: {goal['cause']}" for goal in goals if goal["cause"]]
    why += ["no goal was begun"] if not goals and not exploring else []
    if exploring and record.coverage < COVERED[-1]:
        why.append(_unseen(record))
    return {
        "success": not why,
        "why": "; ".join(why),
        "goals": goals,
        **_coverage(record),
        **_doors(record),
        **_places(record),
        "status": record.moments[-1].status,
        **_cost(record.moments),
    }


def _goal(record: OfficeRecord, outcome: Outcome) -> dict[str, Any]:
    """How one goal came out, and why it failed."""
    mine = [moment for moment in record.moments if moment.phase == outcome.phase]
    given = outcome.distance >= 0.0
    gave_up = bool(given and mine and mine[-1].declared and NO_ROUTE in mine[-1].status)
    kind, cause = _cause(record, outcome, mine)
    return {
        "mark": outcome.mark,
        "room": outcome.room,
        "success": outcome.success,
        "kind": kind,
        "cause": cause,
        "given": given,
        "reachable": outcome.reachable,
        "no_route": gave_up,
        "moves": len(mine),
        "distance": round(outcome.distance, DIGITS),
        "spl": round(outcome.spl, DIGITS),
        "spl_learning": round(outcome.spl_learning, DIGITS),
    }


def _cause(record: OfficeRecord, outcome: Outcome, mine: list[Moment]) -> tuple[str, str]:
    """Why a goal failed: in a word for tables, and in full; empty for one that was met."""
    if outcome.success:
        return "", ""
    if outcome.distance < 0.0:
        entered = any(visit.room == outcome.room for visit in record.visits)
        what = "entered, but not far enough" if entered else "never entered"
        return "not given", f"mark never given, {outcome.room} {what}{_lingered(record, 0)}"
    last = mine[-1]
    away = f"{outcome.distance:.1f} m away, in {_room(record, last)}, mark in {outcome.room}"
    if not last.declared:
        said = f"saying {last.status!r}{_lingered(record, outcome.phase)}"
        return "budget", f"budget of {len(mine)} moves ran out {away}, {said}"
    if NO_ROUTE in last.status:
        return "no route", f"said no route {away}"
    return "wrong place", f"declared {away}"


def _room(record: OfficeRecord, moment: Moment) -> str:
    return record.plan.room_at(float(moment.pose[0]), float(moment.pose[1])) or "a doorway"


def _unseen(record: OfficeRecord) -> str:
    missing = sorted(set(record.plan.room_names) - {visit.room for visit in record.visits})
    never = f", never in {', '.join(missing)}" if missing else ", all rooms entered"
    seen = f"saw {record.coverage:.1%} in {len(record.moments)} moves{never}"
    return f"{seen}, saying {record.moments[-1].status!r}{_lingered(record, 0)}"


def _lingered(record: OfficeRecord, phase: int) -> str:
    """In which room the robot was longest on end in a phase, and where it stood, if long."""
    rows = [t for t, moment in enumerate(record.moments) if moment.phase == phase]
    said, room_moves, spot_moves = "", _Longest(), _Longest()
    for t in rows:
        room_moves.add(t, same=record.rooms[t] == record.rooms[room_moves.start])
        way = record.poses[t, :2] - record.poses[spot_moves.start, :2]
        spot_moves.add(t, same=bool(np.hypot(*way) <= STUCK_M))
    if room_moves.moves >= LINGERED_MOVES:
        said += f", {room_moves.moves} moves on end in {record.rooms[room_moves.best]}"
    if spot_moves.moves >= STUCK_MOVES:
        spot = _room(record, record.moments[spot_moves.best])
        said += f", {spot_moves.moves} standing in {spot}"
    return said


class _Longest:
    """The longest stretch of steps that are alike."""

    def __init__(self) -> None:
        """With no step yet."""
        self.start = self.best = self.moves = 0
        self._any = False

    def add(self, step: int, *, same: bool) -> None:
        """Take in the next step, which is or is not like the first of the present stretch."""
        if not (same and self._any):
            self.start, self._any = step, True
        if step + 1 - self.start > self.moves:
            self.best, self.moves = self.start, step + 1 - self.start


def _coverage(record: OfficeRecord) -> dict[str, Any]:
    seen = np.array([*(moment.coverage for moment in record.moments), record.coverage])
    moves = {
        f"moves_{share:.0%}": int(np.argmax(seen >= share)) if seen[-1] >= share else None
        for share in COVERED
    }
    curve = [round(float(share), DIGITS) for share in seen[::CURVE_EVERY]]
    return {
        "coverage": round(record.coverage, DIGITS),
        "moves": len(record.moments),
        **moves,
        "curve": curve,
    }


def _doors(record: OfficeRecord) -> dict[str, Any]:
    """The doors truly crossed, and which of the crossings the robot noticed."""
    true = record.crossings
    began = sorted({moment.began for moment in record.moments if moment.entry})
    result = noticed(true, began)
    seen = {row for row, _ in result.pairs}
    claimed = {k for _, k in result.pairs}
    return {
        "doors": [[crossing.door, crossing.step] for crossing in true],
        "crossings": result.true,
        "noticed": len(result.pairs),
        "false_crossings": result.false,
        "missed_at": [f"{c.door}@{c.step}" for k, c in enumerate(true) if k not in seen],
        "false_at": [t for k, t in enumerate(began) if k not in claimed],
    }


def _places(record: OfficeRecord) -> dict[str, Any]:
    """Places recognised and not, and how their boundaries agree with the true rooms."""
    judged = entries(record.moments, record.rooms)
    room_of = rooms_of_places(
        [moment.place for moment in record.moments], record.rooms, len(record.moments) - 1
    )
    plan_from_map = rigid_fit(record.believed[:, :2], record.poses[:, :2])
    ious = boundary_ious(record.boundaries, room_of, plan_from_map, record.plan)
    return {
        "entries": dict(Counter(entry.verdict for entry in judged)),
        "faults": [
            f"{e.verdict} merge at step {e.step}: in {e.room}, taken for {e.taken_for or 'new'}"
            for e in judged
            if e.verdict in (WRONG, MISSED)
        ],
        "asrs": len(record.boundaries),
        "closed": sum(len(boundary) > 0 for boundary in record.boundaries.values()),
        "ious": [round(iou, DIGITS) for iou in ious.values()],
        "rooms": len(record.plan.rooms),
    }


def _cost(moments: Sequence[Moment]) -> dict[str, Any]:
    """CPU times of the robot's steps [ms], and by how many places it knew."""
    taken = 1e3 * np.array([moment.seconds for moment in moments])
    bins = np.array([moment.places for moment in moments]) // PLACES_A_BIN
    return {
        "median_ms": round(float(np.median(taken)), 3),
        "p95_ms": round(float(np.quantile(taken, 0.95)), 3),
        "ms_by_places": {
            f"{PLACES_A_BIN * k} to {PLACES_A_BIN * (k + 1) - 1}": [
                round(float(np.median(taken[bins == k])), 3),
                int((bins == k).sum()),
            ]
            for k in np.unique(bins).tolist()
        },
    }
