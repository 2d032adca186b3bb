"""Exits that part nothing are found out; doors stay doors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents.cogmap.asr import ASR
from agents.cogmap.exits import NOWHERE, Exit
from agents.cogmap.false_exits import doubt_exit, parts, rejoin
from agents.cogmap.free_space import Cells, cells_of
from agents.cogmap.mapper import BLANK
from agents.cogmap.memory import NEWBORN, Leads, Mark, Memory
from agents.cogmap.mfis import EMPTY_MFIS, MFIS
from agents.cogmap.navigator import sample_surfaces
from agents.cogmap.params import Params
from agents.cogmap.places import Network
from cogmap_gym.geometry import Points, Pose, Segments
from tests.simulated import segments

P = Params()
HALL = segments((-4, -3, 4, -3), (4, -3, 4, 3), (4, 3, -4, 3), (-4, 3, -4, -3))
GAP = segments((0, 2, 0, 3))[0]
"""Between the table and the upper wall."""
TABLE = segments((-0.6, 0.8, 0.6, 0.8), (0.6, 0.8, 0.6, 2), (0.6, 2, -0.6, 2), (-0.6, 2, -0.6, 0.8))
WALL = segments((0, -3, 0, -1.5), (0, -0.5, 0, 2))
"""A wall across the hall with a door at its lower part and one at its end, the gap."""
WIDE_APART = np.array([[0.0, -1.5], [0.0, -0.5]])


def seen_in_hall(moved: Pose = Pose()) -> Cells:  # noqa: B008 - a Pose is frozen
    """All cells of the hall but those of the table, the hall being moved."""
    c = P.curiosity.cell / 2.0
    x, y = np.meshgrid(np.arange(-4, 4, c), np.arange(-3, 3, c))
    spots = np.stack((x, y), axis=-1).reshape(-1, 2) + 0.5 * c
    low, high = TABLE.min(axis=(0, 1)), TABLE.max(axis=(0, 1))
    in_table = ((spots > low) & (spots < high)).all(axis=1)
    return np.unique(cells_of(moved.apply(spots[~in_table]), P.curiosity))


def standing(things: Segments, *lines: Segments, seen: Cells | None = None) -> Memory:
    """In place 1, the hall, among things, with exits seen at these lines; all seen to be free."""
    book = tuple(Exit(k + 1, line, 1, NOWHERE, 2, -1) for k, line in enumerate(lines))
    stay = replace(
        NEWBORN.stay,
        place=1,
        leads=Leads(seen=seen_in_hall() if seen is None else seen),
    )
    obstacles = sample_surfaces(np.concatenate((HALL, things)), 0.05)
    return replace(NEWBORN, book=book, stay=stay, obstacles=obstacles)


def is_real(memory: Memory, number: int = 1) -> bool:
    return parts(memory, memory.exit(number), memory.stay.leads.seen, P)


def test_between_a_table_and_a_wall_there_is_no_exit() -> None:
    memory = standing(TABLE, GAP)
    assert not is_real(memory)
    assert doubt_exit(memory, 1, P).book[0].false


def test_which_way_an_exit_is_written_down_does_not_matter() -> None:
    assert not is_real(standing(TABLE, GAP[::-1]))
    assert is_real(standing(WALL, GAP[::-1]))


def test_a_door_with_another_door_beside_it_is_real() -> None:
    memory = standing(WALL, GAP, WIDE_APART)
    assert is_real(memory, 1)
    assert is_real(memory, 2)
    assert doubt_exit(memory, 1, P) is memory


def test_a_thin_piece_of_wall_between_a_door_and_an_unknown_one_is_no_thing() -> None:
    assert is_real(standing(WALL, GAP))


def test_an_exit_is_real_while_the_way_round_was_not_seen_to_be_free() -> None:
    assert is_real(standing(TABLE, GAP, seen=seen_in_hall()[:0]))


def test_no_way_round_leads_through_what_stands_about() -> None:
    across = segments((0, -3, 0, 0.8))
    assert is_real(standing(np.concatenate((TABLE, across)), GAP))


@pytest.mark.parametrize("turns", range(1, 4))
def test_a_quarter_turn_of_the_scene_changes_no_verdict(turns: int) -> None:
    moved = Pose(1.0, 2.0, turns * np.pi / 2)
    seen = seen_in_hall(moved)
    for things, real in ((TABLE, False), (WALL, True)):
        here = standing(things, moved.apply(GAP), seen=seen)
        there = replace(here, obstacles=moved.apply(here.obstacles))
        assert is_real(there) == real


def beyond(things: Segments) -> Memory:
    """In the provisional place 2, come from 1 by the gap."""
    memory = standing(things, GAP)
    crossed = replace(memory.book[0], right=2, crossed=5)
    left = Leads(seen=memory.stay.leads.seen, done=np.array([[1.0, 1.0]]))
    stay = replace(
        memory.stay, place=2, known=False, entry=1, came_from=1,
        leads=Leads(done=np.array([[2.0, 2.0]])),
    )  # fmt: skip
    marks = (Mark(1, 1, np.zeros(2)), Mark(2, 2, np.ones(2)))
    return replace(memory, book=(crossed,), stay=stay, leads=((1, left),), marks=marks)


def test_beyond_an_exit_that_parts_nothing_the_robot_is_still_in_the_place_it_left() -> None:
    memory = rejoin(beyond(TABLE), P)
    stay, exit_ = memory.stay, memory.book[0]
    assert (stay.place, stay.known, stay.settled, stay.entry, stay.came_from) == (
        1,
        True,
        True,
        0,
        0,
    )
    assert exit_.false
    assert (exit_.left, exit_.right) == (1, 1)
    assert not exit_.trusted(P.exits)
    assert [m.place for m in memory.marks] == [1, 1]
    assert memory.stay.leads.done.tolist() == [[1.0, 1.0], [2.0, 2.0]]
    assert np.array_equal(memory.stay.leads.seen, seen_in_hall())


def test_beyond_a_door_the_robot_stays_in_the_new_place() -> None:
    memory = beyond(WALL)
    assert rejoin(memory, P) is memory


def round_the_wall(path: Points, looks: Points) -> Memory:
    """In the provisional place 2, come from 1 by a door; where 1 was looked at from is known."""
    memory = beyond(WALL)
    ring = np.array([[-4, -3], [0, -3], [0, 3], [-4, 3.0]])
    ids = np.arange(0)
    left = ASR(1, ring, ids, ids, np.zeros((0, 2)), np.zeros((0, 2, 2)), looks)
    walls = replace(BLANK, mfis=mfis_of(WALL))
    return replace(
        memory, mapping=walls, network=Network((left,), 2), stay=replace(memory.stay, path=path)
    )


def mfis_of(surfaces: Segments) -> MFIS:
    count = len(surfaces)
    return replace(
        EMPTY_MFIS,
        surfaces=surfaces,
        asr=np.ones(count, dtype=np.int64),
        ids=np.arange(1, count + 1),
    )


def test_a_robot_that_came_back_into_the_place_it_left_by_no_exit_is_still_there() -> None:
    path = np.array([[0.4, 2.5], [1.0, 0.0], [-1.0, 0.0], [-1.5, 0.0], [-2.0, 0.0]])
    assert rejoin(round_the_wall(path, np.zeros((0, 2))), P).stay.place == 1
    assert rejoin(round_the_wall(path[:2], np.zeros((0, 2))), P).stay.place == 2


def test_a_spot_stood_on_before_is_in_the_same_place_unless_a_wall_is_between() -> None:
    path = np.array([[0.4, 2.5], [0.6, 0.5], [0.6, 0.5]])
    near = np.array([[1.2, 0.5]])
    behind = np.array([[-0.2, 0.5]])
    assert rejoin(round_the_wall(path, near), P).stay.place == 1
    assert rejoin(round_the_wall(path, behind), P).stay.place == 2
