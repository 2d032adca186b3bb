"""Scores of an episode in an office against the truth: the figures of issue 3.

``office_score`` makes one flat row of an ``OfficeRecord``; ``cogmap_gym.office_table`` makes
tables of many rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cogmap_gym.office_record import NO_ROUTE, Moment, OfficeRecord, Outcome

COVERED = (0.8, 0.9, 0.95)
"""Shares of the free area whose moves are told [-]. Issue 3 asks for the last."""
CURVE_EVERY = 10
"""Every so many moves the share seen is told [-]."""
PLACES_A_BIN = 5
"""CPU times are told by the number of places, in bins so wide [-]."""
DIGITS = 4


def office_score(record: OfficeRecord, *, exploring: bool) -> dict[str, Any]:
    """All figures of one episode, JSON-able.

    Args:
        record: the episode.
        exploring: whether to see everything was all that was asked.
    """
    goals = [_goal(record, outcome) for outcome in record.outcomes]
    why = [f"mark {goal['mark']}: {goal['cause']}" for goal in goals if goal["cause"]]
    enough = record.coverage >= COVERED[-1]
    if exploring and not enough:
        why.append(_unseen(record))
    return {
        "success": not why and (exploring or bool(goals)),
        "why": "; ".join(why),
        "goals": goals,
        **_coverage(record),
        "doors": [[crossing.door, crossing.step] for crossing in record.crossings],
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
        what = "entered, but not clearly" if entered else "never entered"
        return "not given", f"mark never given, {outcome.room} {what}"
    last = mine[-1]
    away = f"{outcome.distance:.1f} m away, in {_room(record, last)}, mark in {outcome.room}"
    if not last.declared:
        return "budget", f"budget of {len(mine)} moves ran out {away}, saying {last.status!r}"
    if NO_ROUTE in last.status:
        return "no route", f"said no route {away}"
    return "wrong place", f"declared {away}"


def _room(record: OfficeRecord, moment: Moment) -> str:
    return record.plan.room_at(float(moment.pose[0]), float(moment.pose[1])) or "a doorway"


def _unseen(record: OfficeRecord) -> str:
    missing = sorted(set(record.plan.room_names) - {visit.room for visit in record.visits})
    never = f", never in {', '.join(missing)}" if missing else ", all rooms entered"
    return f"saw {record.coverage:.1%} in {len(record.moments)} moves{never}"


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


def _cost(moments: list[Moment] | Any) -> dict[str, Any]:
    """CPU times of the robot's steps [ms], and by how many places it knew."""
    taken = 1e3 * np.array([moment.seconds for moment in moments])
    places = np.array([moment.places for moment in moments]) // PLACES_A_BIN
    return {
        "places": int(moments[-1].places),
        "median_ms": round(float(np.median(taken)), 3),
        "p95_ms": round(float(np.quantile(taken, 0.95)), 3),
        "ms_by_places": {
            f"{PLACES_A_BIN * k}-{PLACES_A_BIN * (k + 1) - 1}": [
                round(float(np.median(taken[places == k])), 3),
                int((places == k).sum()),
            ]
            for k in np.unique(places).tolist()
        },
    }
