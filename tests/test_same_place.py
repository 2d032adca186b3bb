"""A new place that goes on into a known one is that one; beyond a door it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from agents.cogmap.asr import ASR
from agents.cogmap.association import Beams
from agents.cogmap.exits import Book, Exit
from agents.cogmap.free_space import cells_of, middles_of
from agents.cogmap.mapper import BLANK
from agents.cogmap.memory import NEWBORN, Leads, Memory
from agents.cogmap.mfis import EMPTY_MFIS, MFIS
from agents.cogmap.params import Params
from agents.cogmap.places import Network
from agents.cogmap.same_place import hangs_together
from cogmap_gym.geometry import Points, Pose, Segments
from tests.simulated import segments

P = Params()
SIDES = segments((12, 2, 0, 2), (0, 0, 12, 0))
"""A corridor 2 m wide; its left half, x < 6, is place 1."""
KNOWN = segments((6, 2, 0, 2), (0, 2, 0, 0), (0, 0, 6, 0))
WALL = segments((6, 0, 6, 0.5), (6, 1.5, 6, 2))
"""Across it, with a door in its middle."""
DOOR = Exit(2, segments((6, 0.5, 6, 1.5))[0], 0, 0, 2, -1)
ENTRY = Exit(1, segments((9, 2, 10, 2))[0], 2, 3, 2, 1)
PATH = np.array([[9.5, 2.4], [9.5, 1.4], [9.0, 1.0], [9.0, 1.0]])


def table(surfaces: Segments, place: int) -> MFIS:
    count = len(surfaces)
    zeros = np.zeros(count, dtype=np.int64)
    return replace(
        EMPTY_MFIS,
        surfaces=surfaces,
        physical=np.ones((count, 2), dtype=np.bool_),
        anchor=surfaces.mean(axis=1),
        anchor_sd=np.zeros(count),
        heading_sd=np.zeros(count),
        born=zeros,
        seen=zeros,
        asr=np.full(count, place),
        entered=np.ones(count, dtype=np.bool_),
        sighting=surfaces,
        sighted=zeros,
        ids=np.arange(1, count + 1),
    )


def beams_to(surfaces: Segments, eye: Points) -> Beams:
    """Beams from a spot to points along surfaces."""
    t = np.linspace(0.05, 0.95, 20)[:, None]
    ends = np.concatenate([a + t * (b - a) for a, b in surfaces])
    return Beams(np.broadcast_to(eye, ends.shape), ends)


def entered(book: Book = (ENTRY,), solid: Segments = SIDES) -> Memory:
    """In the unknown place 2, the corridor's right half, come from place 3 by the entry."""
    x, y = np.meshgrid(np.arange(1, 12, 0.1), np.arange(0.1, 2, 0.1))
    seen = np.unique(cells_of(np.stack((x, y), axis=-1), P.curiosity))
    stay = replace(NEWBORN.stay, place=2, entry=1, came_from=3, path=PATH, leads=Leads(seen=seen))
    ids = np.arange(0)
    ring = np.array([[0, 0], [6, 0], [6, 2], [0, 2.0]])
    known = ASR(1, ring, ids, ids, np.zeros((0, 2)), np.zeros((0, 2, 2)))
    spots = np.concatenate([np.linspace(a, b, 100) for a, b in solid])
    return replace(
        NEWBORN,
        mapping=replace(BLANK, mfis=table(KNOWN, 1)),
        network=Network((known,), 3),
        book=book,
        stay=stay,
        obstacles=spots,
    )


def found(memory: Memory, beams: Beams) -> bool:
    known = memory.network.asr(1)
    assert known is not None
    return hangs_together(memory, known, beams, P) is not None


def test_the_other_half_of_a_corridor_is_the_same_corridor() -> None:
    assert found(entered(), beams_to(KNOWN, PATH[-1]))


def test_beyond_a_door_a_place_is_another() -> None:
    across = np.concatenate((SIDES, WALL))
    assert not found(entered((ENTRY, DOOR), across), beams_to(KNOWN, PATH[-1]))


def test_a_passage_as_narrow_as_a_door_joins_nothing_though_no_exit_is_known() -> None:
    assert not found(entered((ENTRY,), np.concatenate((SIDES, WALL))), beams_to(KNOWN, PATH[-1]))


def test_what_does_not_end_on_its_walls_is_not_that_place() -> None:
    elsewhere = KNOWN + np.array((0.0, 0.6))
    assert not found(entered(), beams_to(elsewhere * (1.0, 0.5), PATH[-1]))


def test_without_beams_into_it_nothing_is_claimed() -> None:
    assert not found(entered(), beams_to(segments((12, 2, 9, 2)), PATH[-1]))


def test_a_place_not_seen_into_is_not_tried() -> None:
    memory = entered()
    blind = replace(memory, stay=replace(memory.stay, leads=Leads()))
    assert not found(blind, beams_to(KNOWN, PATH[-1]))


def test_the_drift_is_told() -> None:
    off = Pose(0.0, 0.15, 0.0)
    memory, seen = entered(), beams_to(KNOWN, PATH[-1])
    known = memory.network.asr(1)
    assert known is not None
    whole = hangs_together(memory, known, seen.moved(off), P)
    assert whole is not None
    assert whole.shift.y == pytest.approx(-0.15, abs=0.05)


def test_the_middles_of_cells_lie_in_them() -> None:
    cells = cells_of(np.array([[-3.1, 2.2], [0.1, -0.1], [7.0, 7.0]]), P.curiosity)
    assert np.array_equal(cells_of(middles_of(cells, P.curiosity), P.curiosity), cells)
