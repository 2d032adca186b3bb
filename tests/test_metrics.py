"""Scores of an episode against the truth, on hand-computed cases."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cogmap_gym.edit_log import edit_violations
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.map_metrics import (
    NO_WALL,
    Origin,
    cover_ratios,
    origins,
    shows_again,
    true_lines,
    wall_faces,
)
from cogmap_gym.metrics import dead_reckoning, position_error, score, wilson
from cogmap_gym.run_record import Record, Step
from cogmap_gym.score_table import rates_table
from cogmap_gym.topology import (
    Crossing,
    Visit,
    boundary_ious,
    noticed,
    rooms_of_places,
    topology_faults,
    true_crossings,
    true_links,
    visits,
)

PLAN = FloorPlan.load("two_rooms")
FACES = wall_faces(PLAN)
BOTTOM = np.array([[1.0, 0.0], [3.0, 0.0]])
"""On the lower wall of R1, seen from above."""
LONGER = np.array([[1.0, 0.0], [3.5, 0.0]])
RING = true_links(PLAN, ("R1", "R2"))


@dataclass(frozen=True, eq=False)
class Change:
    """An edit as a robot's log has it."""

    step: int
    id: int
    before: np.ndarray | None
    after: np.ndarray
    in_view: np.ndarray
    sighted: int


def line_of(*surfaces, shut=()):
    return true_lines(np.array(surfaces, dtype=float), FACES, shut).tolist()


def by(surface, x, y):
    return surface + np.array((x, y))


def path(*points):
    return np.array([(*point, 0.0) for point in points])


# Wilson's interval


def test_wilsons_interval_agrees_with_the_published_example():
    # Newcombe, Statistics in Medicine 17 (1998): 81 of 263 gives 0.2553 to 0.3662
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)


def test_wilsons_interval_of_no_failure_ends_at_one():
    low, high = wilson(10, 10)
    assert low == pytest.approx(10 / (10 + 1.959964**2))
    assert high == pytest.approx(1.0)


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilsons_interval_holds_the_rate_and_mirrors(rate):
    k, n = rate
    low, high = wilson(k, n)
    assert -1e-12 <= low <= k / n + 1e-12
    assert k / n - 1e-12 <= high <= 1.0
    assert wilson(n - k, n) == pytest.approx((1 - high, 1 - low))


# True walls


def test_a_surface_shows_the_face_nearest_to_it_on_its_free_side():
    bottom, shifted, cupboard, back = line_of(
        BOTTOM, by(BOTTOM, 0.0, 0.1), [[2.0, 4.5], [1.0, 4.5]], BOTTOM[::-1]
    )
    assert bottom == shifted != NO_WALL
    assert cupboard not in (bottom, NO_WALL)
    assert back == NO_WALL


def test_a_surface_in_the_middle_of_a_room_shows_no_wall():
    assert line_of([[1.0, 2.5], [2.0, 2.5]]) == [NO_WALL]


def test_walls_beside_a_doorway_are_one_line_and_those_of_two_rooms_are_not():
    below, above = [[3.9, 0.0], [3.9, 2.0]], [[3.9, 3.0], [3.9, 5.0]]
    other_side = [[4.1, 2.0], [4.1, 0.0]]
    one, two, three = line_of(below, above, other_side)
    assert one == two != three
    lower_1, lower_2 = line_of(BOTTOM, [[5.0, 0.0], [7.0, 0.0]])
    assert lower_1 != lower_2


def test_a_door_leaf_is_a_wall_only_while_it_is_shut():
    leaf = [[4.0, 2.1], [4.0, 2.9]]
    jamb_line = line_of([[3.9, 0.0], [3.9, 2.0]])
    assert line_of(leaf, shut=("E1",)) == jamb_line
    assert not FACES.present(()).all()
    assert FACES.present(("E1",)).all()


def test_a_surface_shows_again_what_it_showed_only_where_it_was():
    wall = np.array([[0.0, 0.0], [1.0, 0.0]])
    line = line_of(wall)[0]
    known = Origin(0, line, wall, wall)
    assert shows_again(by(wall, 0.5, 0.0), line, known, wall, FACES)
    assert shows_again(by(wall, 2.2, 0.0), line, known, wall, FACES)  # 1.2 m farther along
    assert not shows_again(by(wall, 2.5, 0.0), line, known, wall, FACES)
    assert shows_again(by(wall, 2.5, 0.0), line, known, np.array([[0, 0], [2.0, 0]]), FACES)
    assert not shows_again(wall, line + 1, known, wall, FACES)


def test_the_origin_of_a_surface_is_found_under_the_true_pose_of_its_sighting():
    # The robot stood at (2, 2), looking up; it believed to stand at (9, 9), looking right.
    seen = Pose(2.0, 2.0, math.pi / 2).inverse().apply(BOTTOM)
    longer = Pose(2.0, 2.0, math.pi / 2).inverse().apply(LONGER)
    entered = Change(1, 1, None, Pose(9.0, 9.0, 0.0).apply(longer), seen, 0)
    poses = np.array([[2.0, 2.0, math.pi / 2], [3.0, 3.0, 0.0]])
    mapped = np.array([[9.0, 9.0, 0.0], [8.0, 8.0, 0.0]])
    found = origins([entered], poses, mapped, [(), ()], FACES)[1]
    assert found.step == 1
    assert found.line == line_of(BOTTOM)[0]
    np.testing.assert_allclose(found.in_plan, LONGER, atol=1e-12)


def test_cover_is_summed_length_over_union_along_each_wall():
    # 0..2 and 1..3 on the lower wall: 4 m over 3 m; one surface on the left wall: 1.
    low = np.array([[[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.05], [3.0, 0.05]], [[0.0, 4.0], [0.0, 1.0]]])
    known = {
        row + 1: Origin(0, line, surface, surface)
        for row, (line, surface) in enumerate(zip(line_of(*low), low, strict=True))
    }
    ratios = cover_ratios(low, np.array([1, 2, 3]), known, FACES)
    assert sorted(ratios) == pytest.approx([1.0, 4 / 3])
    assert cover_ratios(low[[0, 2]], np.array([1, 3]), known, FACES) == pytest.approx([1.0, 1.0])


def test_cover_counts_what_a_surface_has_grown_to():
    entered = np.array([[0.0, 0.0], [1.0, 0.0]])
    line = line_of(entered)[0]
    known = {1: Origin(0, line, entered, entered), 2: Origin(0, line, BOTTOM, BOTTOM)}
    grown = np.array([[[0.0, 0.0], [2.0, 0.0]], BOTTOM])  # 0..2 and 1..3
    assert cover_ratios(grown, np.array([1, 2]), known, FACES) == pytest.approx([4 / 3])


# The edit log


def log(*changes):
    return [Change(k, number, before, after, after, k) for k, (number, before, after) in
            enumerate(changes)]  # fmt: skip


def test_lengthening_along_the_line_breaks_no_law():
    longer = np.array([[0.5, 0.0], [4.0, 0.0]])
    assert edit_violations(log((1, None, BOTTOM), (1, BOTTOM, longer)), {1: longer}) == []


@pytest.mark.parametrize(
    ("after", "fault"),
    [
        (by(BOTTOM, 0.0, 0.01), "left its line"),
        (np.array([[1.0, 0.0], [3.0, 0.01]]), "left its line"),
        (np.array([[1.5, 0.0], [4.0, 0.0]]), "shortened"),
        (BOTTOM[::-1], "shortened"),
    ],
)
def test_moving_turning_and_shortening_are_found(after, fault):
    faults = edit_violations(log((1, None, BOTTOM), (1, BOTTOM, after)), {1: after})
    assert len(faults) == 1
    assert fault in faults[0]


def test_changes_behind_the_back_of_the_log_are_found():
    entered = log((1, None, BOTTOM))
    assert edit_violations(entered, {1: BOTTOM + 0.1})
    assert edit_violations(entered, {})
    assert edit_violations(entered, {1: BOTTOM, 2: BOTTOM})
    longer = np.array([[1.0, 0.0], [4.0, 0.0]])
    assert edit_violations(log((1, None, BOTTOM), (1, BOTTOM + 0.1, longer)), {1: longer})
    assert edit_violations(log((1, None, BOTTOM), (1, None, BOTTOM)), {1: BOTTOM})


# Rooms and doors


def test_a_crossing_counts_from_035_m_beyond_the_door():
    there = path((3, 2.5), (4.2, 2.5), (4.36, 2.5), (6, 2.5))
    assert true_crossings(PLAN, there) == [Crossing(2, "E1")]
    turned_back = path((3, 2.5), (4.3, 2.5), (3, 2.5))
    assert true_crossings(PLAN, turned_back) == []
    both_ways = path((3, 2.5), (5, 2.5), (3, 2.5))
    assert true_crossings(PLAN, both_ways) == [Crossing(1, "E1"), Crossing(2, "E1")]


def test_a_stay_ends_when_the_robot_is_clearly_in_the_next_room():
    there = path((3, 2.5), (4.2, 2.5), (4.35, 2.5), (6, 2.5), (3, 2.5))
    assert visits(PLAN, there) == [Visit("R1", 0, 1), Visit("R2", 2, 3), Visit("R1", 4, 4)]


def test_crossings_are_paired_with_beliefs_near_in_time():
    true = [Crossing(10, "E1"), Crossing(20, "E2"), Crossing(30, "E1")]
    result = noticed(true, [11, 15, 27])
    assert result.pairs == ((0, 0), (2, 2))
    assert (result.true, result.false) == (3, 1)


def test_a_place_is_the_room_in_which_most_of_its_steps_were():
    rooms = ["R1", "R1", "R2", "R2", "R2", "R1"]
    assert rooms_of_places([1, 1, 1, 2, 2, 2], rooms, until=4) == {1: "R1", 2: "R2"}


def test_the_true_links_join_two_rooms_by_a_door():
    assert {(frozenset(("R1", "R2")), "E1")} == RING
    assert true_links(PLAN, ("R1",)) == frozenset()


def test_the_true_network_has_no_fault():
    assert topology_faults([1, 2], [(1, 7, 2)], {1: "R1", 2: "R2"}, {7: "E1"}, RING) == []


@pytest.mark.parametrize(
    ("places", "links", "rooms", "doors"),
    [
        ([1], [], {1: "R1"}, {}),
        ([1, 2, 3], [(1, 7, 2)], {1: "R1", 2: "R2", 3: "R1"}, {7: "E1"}),
        ([1, 2, 3], [(1, 7, 2)], {1: "R1", 2: "R2"}, {7: "E1"}),
        ([1, 2], [], {1: "R1", 2: "R2"}, {7: "E1"}),
        ([1, 2], [(1, 7, 2), (1, 8, 2)], {1: "R1", 2: "R2"}, {7: "E1", 8: "E1"}),
        ([1, 2], [(1, 8, 2)], {1: "R1", 2: "R2"}, {7: "E1"}),
        ([1, 2], [(1, 7, 2)], {1: "R1", 2: "R1"}, {7: "E1"}),
    ],
    ids=["lost", "split", "unplaced", "unlinked", "twice", "no_door", "same_room"],
)
def test_a_wrong_network_is_found_wrong(places, links, rooms, doors):
    assert topology_faults(places, links, rooms, doors, RING)


def test_iou_leaves_furniture_out_of_both():
    plan_from_map = Pose(1.0, 2.0, 0.3)
    drawn = plan_from_map.inverse().apply(np.array(PLAN.rooms["R2"]))
    half = plan_from_map.inverse().apply(np.array([[4.1, 0], [6.1, 0], [6.1, 5], [4.1, 5]]))
    found = boundary_ious(
        {1: drawn, 2: half, 3: drawn[:0]}, dict.fromkeys((1, 2, 3), "R2"), plan_from_map, PLAN
    )
    assert set(found) == {1, 2}
    assert found[1] == pytest.approx(1.0)
    # Free: 3.9 x 5 m and the doorway of 0.1 m2, less 0.4 x 0.4 m of furniture, all of it right
    # of x = 6.1; drawn: 10 m2
    assert found[2] == pytest.approx(10.0 / (19.5 + 0.1 - 0.16))


# Poses


def test_dead_reckoning_adds_up_motions_in_the_robots_frame():
    motions = np.array([[0, 0, 0], [1, 0, math.pi / 2], [2, 0, 0]])
    np.testing.assert_allclose(dead_reckoning(motions)[-1], (1.0, 2.0, math.pi / 2))


def test_the_error_of_a_pose_is_measured_from_the_true_start():
    start = np.array([4.0, 5.0, math.pi / 2])
    assert position_error(start, np.array([4.0, 8.0, 0.0]), np.array([3.0, 0.4, 0.0])) == (
        pytest.approx(0.4)
    )


# A whole episode: out of R1 and back, twice, then home


def episode() -> Record:
    """A perfect robot; each view shows the lower and the left wall of R1 from inside R1."""
    walls = np.array([BOTTOM, [[0.0, 4.0], [0.0, 1.0]]])
    x = [2.0, 6.0, 2.0, 6.0, 2.0, 2.0]
    phase = [0, 0, 1, 1, 2, 2]
    plan_from_map = Pose(*path((2.0, 2.5))[0])
    steps = []
    for k in range(6):
        pose = np.array([x[k], 2.5, 0.0])
        here = k % 2 == 0 or k == 5
        steps.append(
            Step(
                phase=phase[k],
                pose=pose,
                shut=frozenset(),
                odometry=np.array([1.1 * (x[k] - x[max(k - 1, 0)]), 0.0, 0.0]),
                mapped=pose - (2.0, 2.5, 0.0),
                believed=pose - (2.0, 2.5, 0.0),
                seen=walls - pose[:2] if here else walls[:0],
                names=np.array([1, 2] if here else [], dtype=np.int64),
                surfaces=plan_from_map.inverse().apply(walls),
                entered=np.array([True, True]),
                tags=np.array([0, 0] if k == 0 else [1, 1]),
                place=1 if here else 2,
                entry=0 if k == 0 else 7,
                began=min(k, 4),
                boundaries={1: np.array(PLAN.rooms["R1"]) - (2.0, 2.5)} if k else {},
                links=((1, 7, 2),) if k else (),
            )
        )
    first = plan_from_map.inverse().apply(walls)
    edits = [Change(0, k + 1, None, first[k], walls[k] - (2.0, 2.5), 0) for k in (0, 1)]
    tasks = ("explore", "explore", "home")
    return Record(PLAN, ("R1", "R2"), steps, edits, tasks, (True, True, True), 0.0)


def changed(record: Record, **changes) -> Record:
    """The record with fields of the steps from the second on changed."""
    return replace(
        record, steps=[record.steps[0], *(replace(s, **changes) for s in record.steps[1:])]
    )


def test_a_perfect_episode_is_scored_as_one():
    record = episode()
    # The second place is not cut before the robot leaves it: give it a boundary.
    both = {**record.steps[1].boundaries, 2: np.array(PLAN.rooms["R2"]) - (2.0, 2.5)}
    row = score(changed(record, boundaries=both))
    assert [row[q] for q in "abcd"] == [True] * 4
    assert (row["named"], row["asrs"], row["closed"]) == (2, 2, 2)
    assert row["ious"] == pytest.approx([1.0, 1.0])
    assert (row["crossings"], row["noticed"], row["false_crossings"]) == (4, 4, 0)
    assert row["cover"] == pytest.approx(1.0)
    assert row["mfis_error"] == pytest.approx(0.0)
    assert row["reckoning_error"] == pytest.approx(0.0)  # 10 % too far out, 10 % too far back
    assert row["edit_violations"] == []
    assert row["false_names"] == 0


def test_swapped_names_are_wrong_names():
    record = episode()
    swapped = replace(record.steps[2], names=record.steps[2].names[::-1])
    row = score(replace(record, steps=[*record.steps[:2], swapped, *record.steps[3:]]))
    assert not row["a"]
    assert row["a_why"] == "0 named; wrong: [1, 2]"


def test_a_home_that_was_not_recognised_is_no_closed_loop():
    row = score(changed(episode(), tags=np.array([3, 3])))
    assert (row["a"], row["a_why"]) == (False, "0 named")


def test_a_failed_lap_fails_all_that_hangs_on_it():
    row = score(replace(episode(), successes=(False, True, True)))
    assert [row[q] for q in "abcd"] == [False, False, False, True]


def test_a_second_map_on_top_of_the_first_is_found():
    record = episode()
    again = [*record.edits]
    for number, edit in enumerate(record.edits, start=3):
        again.append(replace(edit, id=number, step=4, sighted=4))  # type: ignore[type-var]
    late = replace(
        record.steps[4],
        surfaces=np.concatenate((record.steps[4].surfaces,) * 2),
        entered=np.ones(4, dtype=np.bool_),
        tags=np.ones(4, dtype=np.int64),
    )
    last = replace(late, pose=record.steps[5].pose)
    row = score(replace(record, edits=again, steps=[*record.steps[:4], late, last]))
    assert (row["c"], row["c_why"]) == (False, "covered 2.00x; +100% surfaces")


def test_the_table_shows_rates_intervals_and_failures():
    key = {"experiment": 1, "odometry": "medium", "literal": False}
    good = key | {"seed": 1} | score(episode())
    bad = key | {"seed": 2} | score(replace(episode(), successes=(True, True, False)))
    table = rates_table([bad, good])
    assert "| (d) home within 1.0 m | 1/2 = 50.0% | 9.5% to 90.5% | >= 92% |" in table
    assert "- seed 2: (b)" in table
    assert "(d) way home 1 failed" in table
