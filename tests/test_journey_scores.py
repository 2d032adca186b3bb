"""Scores of experiment 3 against the truth, on episodes built by hand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.journey_scores import (
    STAGES,
    doors_by_phase,
    route_fault,
    score_journeys,
    without_turn_backs,
)
from cogmap_gym.metrics import score
from cogmap_gym.run_record import Record, Step
from cogmap_gym.score_table import broken, rates_table, reasons
from cogmap_gym.thesis_tasks import GOAL_MOVES, OWN_DOORS, PHASES, RING
from cogmap_gym.topology import true_crossings, true_links

OFFICE, TWO_ROOMS = FloorPlan.load("thesis_office"), FloorPlan.load("two_rooms")
SIDES = {door: sides for sides, door in true_links(OFFICE, OFFICE.rooms)}
LAP = ("E1", "E2", "E3", "E4", "E5", "E6")
WAYS = [LAP, (), LAP[::-1], *OWN_DOORS[3:]]
ROUND_ABOUT = [*WAYS[:4], ("E5", "E6", "E1", "E2"), ("E2", "E1"), ("E6", "E10", "E9")]
"""Back round the ring instead of through ASR7, and home by E1."""


def beside(door: str, room: str, far: float = 0.5) -> np.ndarray:
    """The point before the middle of a door in one of its rooms, this far from its line."""
    start, end = OFFICE.doors[door]
    aside = np.array((start[1] - end[1], end[0] - start[0])) / np.hypot(*(end - start))
    middle = 0.5 * (start + end)
    sides = [middle + k * far * aside for k in (-1.0, 1.0)]
    return next(point for point in sides if OFFICE.room_at(*point) == room)


def walk(ways: Sequence[Sequence[str]]) -> Iterator[tuple[int, np.ndarray, str, str]]:
    """Phase, position, room and the door just crossed or ``""``, step by step from home.

    The move through the last door of a lap ends it: its end belongs to the next phase.
    """
    room, at = RING[0], np.array((OFFICE.home.x, OFFICE.home.y))
    yield 0, at, room, ""
    for phase, doors in enumerate(ways):
        lap = not PHASES[3][phase].goal
        for number, door in enumerate(doors):
            yield phase, beside(door, room), room, ""
            (room,) = SIDES[door] - {room}
            at = beside(door, room)
            ends = lap and number == len(doors) - 1
            yield phase + ends, at, room, door
        if not lap:
            yield phase, at, room, ""


def journey(ways: Sequence[Sequence[str]] = WAYS, ok: Sequence[bool] = (True,) * 7) -> Record:
    """A robot that believes what is true and goes these ways."""
    steps: list[Step] = []
    entry, began, inside = 0, 0, RING[0]
    links: dict[str, tuple[int, int, int]] = {}
    left: dict[int, np.ndarray] = {}
    for phase, at, room, door in walk(ways):
        if door:
            entry, began = int(door[1:]), len(steps)
            left[int(inside[3:])] = np.array(OFFICE.rooms[inside])
            links.setdefault(door, (int(inside[3:]), entry, int(room[3:])))
            inside = room
        pose = np.array((*at, 0.0))
        steps.append(
            Step(
                phase=phase, pose=pose, shut=frozenset(), odometry=np.zeros(3), mapped=pose,
                believed=pose, seen=np.zeros((0, 2, 2)), names=np.zeros(0, dtype=np.int64),
                surfaces=np.zeros((0, 2, 2)), entered=np.zeros(0, dtype=np.bool_),
                tags=np.zeros(0, dtype=np.int64), place=int(room[3:]), entry=entry, began=began,
                boundaries=dict(left), links=tuple(links.values()),
            )
        )  # fmt: skip
    return Record(OFFICE, RING, steps, [], [p.task for p in PHASES[3]], ok, 0.0)


def believing(record: Record, since: int, **changes: Any) -> Record:
    """The record with other beliefs from a phase on."""
    steps = [replace(s, **changes) if s.phase >= since else s for s in record.steps]
    return replace(record, steps=steps)


# Doors


def test_doors_are_counted_in_the_phase_in_which_the_move_was_decided_on() -> None:
    assert [tuple(doors) for doors in doors_by_phase(journey())] == [tuple(way) for way in WAYS]


@pytest.mark.parametrize(
    ("x", "doors"),
    [
        ((3.0, 4.4, 4.9, 3.5), []),  # turned back 0.9 m from the door
        ((3.0, 4.4, 5.1, 3.5), ["E1", "E1"]),  # 1.1 m
        ((3.0, 4.4, 3.5, 4.4), ["E1"]),  # back and through it again
        ((3.0, 4.9, 3.1, 4.9, 3.1), []),
        ((3.0, 4.4, 6.0), ["E1"]),
    ],
)
def test_a_turn_back_near_a_door_is_no_crossing(x: tuple[float, ...], doors: list[str]) -> None:
    poses = np.array([(value, 2.5, 0.0) for value in x])
    crossings = true_crossings(TWO_ROOMS, poses)
    assert without_turn_backs(TWO_ROOMS, poses, crossings) == doors


def test_a_turn_back_is_near_the_door_and_not_only_near_its_line() -> None:
    path = ((3.0, 2.5), (4.4, 2.5), (4.4, 4.5), (4.4, 2.5), (3.0, 2.5))
    poses = np.array([(*point, 0.0) for point in path])
    crossings = true_crossings(TWO_ROOMS, poses)
    assert without_turn_backs(TWO_ROOMS, poses, crossings) == ["E1", "E1"]


@pytest.mark.parametrize(
    ("crossed", "fault"),
    [
        ("E7 E8", ""),
        ("E7 E7 E7 E8", "extra crossing of E7"),
        ("E7 E8 E2", "extra crossing of E2"),
        ("E4 E3", "took E4 instead of E7"),
        ("E7", "did not cross E8"),
        ("", "did not cross E7"),
    ],
)
def test_a_way_is_told_by_its_first_fault(crossed: str, fault: str) -> None:
    assert route_fault(crossed.split(), ("E7", "E8")) == fault


# Whole episodes


def test_the_way_of_the_thesis_with_a_true_map_is_right_in_all() -> None:
    row = score_journeys(journey())
    assert [row[q] for q in ("goals", "phases", "doors", "network", "thesis")] == [True] * 5
    assert row["failures"] == []
    assert (row["asrs"], row["closed"]) == (8, 8)


def test_another_way_and_the_links_it_never_learned_are_told_by_stage() -> None:
    row = score_journeys(journey(ROUND_ABOUT))
    assert (row["goals"], row["doors"], row["network"], row["thesis"]) == (True, *[False] * 3)
    stages = {(stage, cause) for stage, cause, _ in row["failures"]}
    assert stages == {
        ("5 goto:3", "took E5 instead of E7"),
        ("5 goto:3", "place missing"),
        ("5 goto:3", "link missing"),
        ("6 home", "took E1 instead of E9"),
    }
    assert row["failures"][0] == [
        "5 goto:3",
        "took E5 instead of E7",
        "took E5 instead of E7 (E5 E6 E1 E2, not E7 E8)",
    ]


def test_a_doubled_place_is_told_in_the_stage_since_which_it_stood() -> None:
    record = journey()
    steps = [
        replace(s, boundaries={**s.boundaries, 15: np.zeros((0, 2))},
                place=15 if s.phase == 3 and s.place == 5 else s.place) if s.phase >= 3 else s
        for s in record.steps
    ]  # fmt: skip
    row = score_journeys(replace(record, steps=steps))
    assert row["failures"] == [["4 goto:2", "place doubled", "ASR5 is 2 places"]]
    assert (row["doors"], row["network"], row["thesis"]) == (True, False, False)


def test_a_fault_that_is_mended_later_is_none() -> None:
    record = journey()
    steps = [replace(s, links=()) if s.phase < 5 else s for s in record.steps]
    assert score_journeys(replace(record, steps=steps))["network"]


@pytest.mark.parametrize(
    ("links", "cause"),
    [
        ((1, 1, 3), "link wrong"),
        ((1, 11, 2), "link wrong"),
        ((2, 1, 1), "link doubled"),
    ],
    ids=["other_place", "no_door", "twice"],
)
def test_a_link_too_many_is_found(links: tuple[int, int, int], cause: str) -> None:
    record = journey()
    more = (*record.steps[-1].links, links)
    row = score_journeys(believing(record, 6, links=more))
    assert [(stage, kind) for stage, kind, _ in row["failures"]] == [("7 goto:4", cause)]


def test_a_declaration_in_the_wrong_place_is_told_apart_from_a_used_up_budget() -> None:
    record = journey([*WAYS[:6], ("E6",)], (*(True,) * 6, False))
    row = score_journeys(record)
    assert not row["goals"]
    stage, cause, text = row["failures"][0]
    assert (stage, cause) == ("7 goto:4", "declared in the wrong place")
    assert text.startswith("declared in ASR6 at (")
    last = [step for step in record.steps if step.phase == 6]
    late = replace(record, steps=[*record.steps, *last[-1:] * (GOAL_MOVES - len(last))])
    stage, cause, text = score_journeys(late)["failures"][0]
    assert (stage, cause) == ("7 goto:4", "budget used up")
    assert text.startswith("not done in 200 moves, last in ASR6")


def test_a_failed_lap_is_no_failed_goal() -> None:
    row = score_journeys(journey(ok=(True, True, False, *(True,) * 4)))
    assert (row["goals"], row["phases"], row["thesis"]) == (True, False, True)
    assert row["failures"][0][:2] == ["3 lap", "budget used up"]


def test_a_goal_whose_mark_was_never_given_was_never_begun() -> None:
    record = journey(WAYS[:6], (*(True,) * 6, False))
    assert ["7 goto:4", "never begun"] in [f[:2] for f in score_journeys(record)["failures"]]


# The table


def test_the_table_counts_failures_by_stage_and_cause() -> None:
    key = {"experiment": 3, "odometry": "medium", "literal": False}
    drive = journey(ROUND_ABOUT)
    rest = score(replace(drive, successes=(False,) * 7))
    good = {**key, "seed": 1, **rest, **score_journeys(journey())}
    bad = {**key, "seed": 2, **rest, **score_journeys(drive)}
    lost = {**key, "seed": 3, **broken(3, "raised KeyError(1)", STAGES[0]), "raised": "KeyError(1)"}
    table = rates_table([bad, lost, good])
    assert "| all goals met | 2/3 = 66.7% | 20.8% to 93.9% | >= 80% |" in table
    assert "| own doors in order and the network right | 1/3 = 33.3% |" in table
    assert "| ASR boundaries closed at the end | 15/15 = 100.0% |" in table
    assert "| 5 goto:3 | took E5 instead of E7 | 1 | 1 |" in table
    assert "| 6 home | took E1 instead of E9 | 1 | 0 |" in table
    assert "| 1 lap | raised | 1 | 1 |" in table
    assert "- seed 3: 1 lap: raised KeyError(1)" in table
    assert reasons(good) == []


def test_a_broken_run_of_the_ring_fails_its_four_questions() -> None:
    row = {"experiment": 1, **broken(1, "raised KeyError(1)", "")}
    assert reasons(row) == [f"({q}) raised KeyError(1)" for q in "abcd"]
