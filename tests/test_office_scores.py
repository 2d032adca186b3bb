"""Figures of one episode in an office."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cogmap_gym.office_scores import office_score
from tests.office_rows import LEFT, RIGHT, moment, outcome, record

THROUGH = [moment(LEFT), moment((4.5, 2.5), coverage=0.9), moment(RIGHT, coverage=0.95)]


def failed(last: dict[str, object], **goal: object) -> dict[str, object]:
    way = [*THROUGH, moment(LEFT, phase=1, **last)]
    row = office_score(record(way, [outcome(success=False, **goal)]), exploring=False)
    assert not row["success"]
    return {**row, **row["goals"][0]}


def test_exploring_succeeds_by_what_was_seen_and_tells_when() -> None:
    row = office_score(record(THROUGH, []), exploring=True)
    assert row["success"]
    assert [row[f"moves_{share}"] for share in ("80%", "90%", "95%")] == [1, 1, 2]
    assert json.loads(json.dumps(row)) == row


def test_exploring_too_little_fails_and_names_the_rooms_never_entered() -> None:
    row = office_score(record([moment()] * 80, [], coverage=0.5), exploring=True)
    assert not row["success"]
    assert "never in R2" in row["why"]
    assert "80 moves on end in R1, 80 standing in R1" in row["why"]
    assert row["moves_95%"] is None


def test_the_curve_has_every_tenth_move() -> None:
    shares = np.linspace(0.0, 0.4, 41)
    row = office_score(
        record([moment(coverage=float(s)) for s in shares], [], 0.41), exploring=True
    )
    assert row["curve"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])


def test_goals_met_make_a_success() -> None:
    row = office_score(record(THROUGH, [outcome()]), exploring=False)
    assert row["success"]
    assert row["goals"][0]["kind"] == ""


def test_a_task_whose_goals_were_never_begun_fails() -> None:
    row = office_score(record(THROUGH, []), exploring=False)
    assert (row["success"], row["why"]) == (False, "no goal was begun")


def test_a_mark_never_given_says_whether_its_room_was_entered() -> None:
    entered = failed({}, distance=-1.0)
    never = failed({}, distance=-1.0, room="R3")
    assert entered["kind"] == never["kind"] == "not given"
    assert "R2 entered, but" in entered["cause"]
    assert "R3 never entered" in never["cause"]


def test_a_wrong_declaration_says_how_far_away() -> None:
    row = failed({"declared": True, "status": "at mark 2"}, distance=4.0)
    assert row["kind"] == "wrong place"
    assert "4.0 m away, in R1" in row["cause"]


def test_a_budget_that_ran_out_says_what_the_robot_was_about() -> None:
    row = failed({"status": "looking for a new exit"})
    assert row["kind"] == "budget"
    assert "looking for a new exit" in row["cause"]


@pytest.mark.parametrize("declared", [True, False])
def test_no_route_counts_once_the_robot_declares_it(declared: bool) -> None:
    row = failed({"declared": declared, "status": "no route to mark 2"})
    assert row["no_route"] == declared
    assert row["kind"] == ("no route" if declared else "budget")


def test_doors_crossed_and_noticed_are_told() -> None:
    way = [*THROUGH, moment(RIGHT, place=2, entry=1, began=1, came_from=1)]
    row = office_score(record(way, []), exploring=True)
    assert row["doors"] == [["E1", 1]]
    assert (row["crossings"], row["noticed"], row["false_crossings"]) == (1, 1, 0)


def test_boundaries_are_compared_with_the_rooms_they_stand_for() -> None:
    row = office_score(record([moment(), moment((3.0, 1.0)), *THROUGH[1:]], []), exploring=True)
    assert (row["asrs"], row["closed"]) == (2, 1)
    assert row["ious"] == pytest.approx([1.0], abs=0.01)


def test_cpu_times_are_told_by_how_many_places_are_known() -> None:
    way = [moment(places=k, seconds=0.001 * (1 + k // 5)) for k in (0, 4, 5, 9)]
    row = office_score(record(way, []), exploring=True)
    assert row["ms_by_places"] == {"0 to 4": [1.0, 2], "5 to 9": [2.0, 2]}
