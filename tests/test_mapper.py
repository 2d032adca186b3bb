"""Algorithm 3: from views and odometry to the MFIS, and the proof that nothing old is moved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.cogmap.landmarks import compare
from agents.cogmap.mapper import BLANK, Mapper, update
from agents.cogmap.mfis import Edit
from agents.cogmap.params import Frame, Landmarks, Lines, Params, Transfer
from cogmap_gym.geometry import Pose, Segments, headings, lengths, point_segment_distances
from cogmap_gym.observation import LaserSpec
from tests.rooms import corridor, l_room, ring_of_four, room_with_pillar, square_room
from tests.simulated import SYMMETRIC, along, drive, mirrored, same_rows, scan, solid

LITERAL = Params(
    lines=Lines(literal=True),
    frame=Frame(kind="nearest"),
    landmarks=Landmarks(literal=True),
    transfer=Transfer(literal=True),
)
BLIND = replace(Params(), frame=Frame(kind="odometry"))
KINDS = pytest.mark.parametrize(
    "params", [Params(), LITERAL, BLIND], ids=["consensus", "literal", "odometry"]
)
LAP = np.array([[2, 2], [2, 7.5], [8, 7.5], [8, 2.2], [2, 2.2]], dtype=float)
"""A lap of ``ring_of_four`` through all its doors, from home."""


def replayed(edits: Sequence[Edit]) -> dict[int, Segments]:
    """The map that the edit log alone tells of; asserts that old surfaces only lengthen."""
    told: dict[int, Segments] = {}
    for edit in edits:
        if edit.before is None:
            assert edit.id not in told, "a surface is entered once"
            assert edit.sighted <= edit.step
        else:
            assert (edit.before == told[edit.id]).all(), "an edit begins where the last one ended"
            u = edit.before[1] - edit.before[0]
            u = u / np.linalg.norm(u)
            off = edit.after - edit.before[0]
            assert np.abs(u[0] * off[:, 1] - u[1] * off[:, 0]).max() < 1e-9, "on its own line"
            assert off[0] @ u <= 1e-9
            assert (edit.after[1] - edit.before[1]) @ u >= -1e-9, "no end is taken back"
            assert off[0] @ u < off[1] @ u, "it is not turned round"
        told[edit.id] = edit.after
    return told


def off_walls(mapper: Mapper, walls: Segments, first: Pose) -> np.ndarray:
    """Distance of each surface's ends to the nearest wall, the map laid at the first pose."""
    ends = first.apply(mapper.surfaces).reshape(-1, 2)
    return point_segment_distances(ends, walls).min(axis=1)


@KINDS
@pytest.mark.parametrize("seed", [0, 1])
def test_the_edit_log_tells_the_map_and_old_surfaces_only_lengthen(
    params: Params, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    walls = solid(ring_of_four())
    mapper, edits = drive(walls, along(LAP), params, rng=rng, turn_error=0.01, scale_error=0.02)
    told, mfis = replayed(edits), mapper.mapping.mfis
    assert sorted(told) == mfis.ids[mfis.entered].tolist()
    assert (np.array([told[i] for i in sorted(told)]) == mfis.surfaces[mfis.entered]).all()
    assert mfis.entered.mean() > 0.9
    assert params is BLIND or any(edit.before is not None for edit in edits)


def test_a_lap_with_drifting_odometry_ends_where_it_began() -> None:
    walls, poses = solid(ring_of_four()), along(LAP)
    rng = np.random.default_rng(0)
    mapper, _ = drive(walls, poses, rng=rng, turn_error=0.01, scale_error=0.02)
    blind, _ = drive(walls, poses, BLIND, turn_error=0.01, scale_error=0.02)
    true = poses[0].inverse() @ poses[-1]
    assert mapper.pose.distance(true) < 0.15
    assert blind.pose.distance(true) > 5 * mapper.pose.distance(true)


def test_a_lap_leaves_one_surface_a_wall_and_they_lie_on_the_walls() -> None:
    walls, poses = solid(ring_of_four()), along(LAP)
    rng = np.random.default_rng(1)
    mapper, _ = drive(walls, poses, rng=rng, turn_error=0.005, scale_error=0.01)
    assert off_walls(mapper, walls, poses[0]).max() < 0.3
    assert np.median(off_walls(mapper, walls, poses[0])) < 0.06
    # Directed: both faces of a thin wall may stand, but no face twice.
    s = mapper.surfaces
    both = compare(s, s, Landmarks())
    twice = (np.abs(both.turn) < 0.1) & (np.abs(both.offset) < 0.2) & ~np.eye(len(s), dtype=bool)
    assert np.maximum(both.overlap[twice], 0.0).sum() / 2 < 0.05 * lengths(s).sum()


def test_a_second_lap_draws_no_second_map() -> None:
    walls = solid(ring_of_four())
    once, _ = drive(walls, along(LAP), rng=np.random.default_rng(2), turn_error=0.005)
    two_laps = np.concatenate((LAP, LAP[1:]))
    twice, _ = drive(walls, along(two_laps), rng=np.random.default_rng(2), turn_error=0.005)
    assert len(twice.surfaces) <= 1.2 * len(once.surfaces)
    assert lengths(twice.surfaces).sum() <= 1.1 * lengths(once.surfaces).sum()


@KINDS
def test_the_same_view_twice_adds_nothing(params: Params) -> None:
    mapper = Mapper(params, SYMMETRIC)
    ranges = scan(solid(room_with_pillar()), Pose(1.2, 1.1, 0.3))
    mapper.observe(ranges, Pose())
    before = mapper.surfaces
    edits = mapper.observe(ranges, Pose())
    if params is BLIND:
        assert all(edit.before is None for edit in edits)
        return
    assert list(edits) == []
    assert (mapper.surfaces == before).all()
    assert mapper.pose.distance(Pose()) < 1e-3


def test_the_map_does_not_depend_on_where_the_building_stands() -> None:
    walls, moved = solid(l_room()), Pose(13.0, -7.0, 2.1)
    poses = along(np.array([[1, 1], [6, 1.5], [2, 2], [2, 6]], dtype=float))
    here, _ = drive(walls, poses, turn_error=0.005)
    there, _ = drive(moved.apply(walls), [moved @ p for p in poses], turn_error=0.005)
    assert there.surfaces == pytest.approx(here.surfaces, abs=1e-3)
    assert there.pose.distance(here.pose) < 1e-3


def test_the_map_of_a_mirrored_building_is_the_mirrored_map() -> None:
    walls = solid(l_room())
    poses = along(np.array([[1, 1], [6, 1.5], [2, 2], [2, 6]], dtype=float))
    mirror = np.array((1.0, -1.0))
    here, _ = drive(walls, poses, turn_error=0.005)
    there, _ = drive(walls * mirror, [Pose(p.x, -p.y, -p.theta) for p in poses], turn_error=-0.005)
    assert same_rows(there.surfaces, mirrored(here.surfaces), 0.05)


@KINDS
@pytest.mark.parametrize("value", [math.nan, 0.0, -3.0, math.inf, -math.inf, 32.0, 1e9], ids=str)
def test_scans_without_evidence_invent_nothing_and_forget_nothing(
    params: Params, value: float
) -> None:
    mapper = Mapper(params, SYMMETRIC)
    garbage = np.full(SYMMETRIC.beams, value)
    assert list(mapper.observe(garbage, Pose())) == []
    assert mapper.surfaces.shape == (0, 2, 2)
    mapper.observe(scan(solid(l_room()), Pose(1.5, 1.5, 0.2)), Pose(0.1, 0.0, 0.0))
    before = mapper.surfaces
    edits = mapper.observe(garbage, Pose(0.5, 0.0, 0.1))
    assert all(e.before is None and e.sighted == 1 for e in edits), "only what waited is entered"
    assert (mapper.surfaces == before).all()
    assert mapper.pose.distance(Pose(0.6, 0.0, 0.0)) < 1e-9, "without evidence, odometry alone"


@KINDS
def test_a_view_after_one_without_evidence_finds_its_place_again(params: Params) -> None:
    walls, at, moved = solid(l_room()), Pose(1.5, 1.5, 0.2), Pose(0.2, 0.0, 0.05)
    mapper = Mapper(params, SYMMETRIC)
    mapper.observe(scan(walls, at), Pose())
    mapper.observe(np.full(SYMMETRIC.beams, np.nan), moved)
    mapper.observe(scan(walls, at @ moved @ moved), moved)
    assert mapper.pose.distance(moved @ moved) < (0.02 if params is not LITERAL else 0.1)


@KINDS
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_readings_leave_a_sound_map(params: Params, seed: int) -> None:
    rng = np.random.default_rng(seed)
    mapper, edits = Mapper(params, SYMMETRIC), []
    for _ in range(6):
        ranges = rng.uniform(0.0, 40.0, SYMMETRIC.beams)
        ranges[rng.random(SYMMETRIC.beams) < 0.2] = rng.choice([np.nan, np.inf, 0.0, -1.0, 32.0])
        edits += mapper.observe(ranges, Pose(*rng.normal(0.0, (1.0, 0.2, 0.5))))
    assert np.isfinite(mapper.surfaces).all()
    assert np.isfinite((mapper.pose.x, mapper.pose.y, mapper.pose.theta)).all()
    replayed(edits)


def test_one_beam_makes_no_map() -> None:
    laser = LaserSpec(first_angle=0.0, beams=1)
    mapper, _ = drive(solid(square_room()), along(np.array([[1, 1], [4, 4.0]])), laser=laser)
    assert mapper.surfaces.shape == (0, 2, 2)


def test_surfaces_that_may_not_be_recognised_are_not() -> None:
    walls, at = solid(l_room()), Pose(1.5, 1.5, 0.2)
    first = Mapper(Params(), SYMMETRIC)
    first.observe(scan(walls, at), Pose())
    count = len(first.surfaces)
    view = first.mapping.view
    none = np.zeros(count, dtype=np.bool_)
    wrong = Pose(0.1, 0.1, 0.05)
    now, _ = update(first.mapping, view, wrong, Params(), none)
    assert now.mfis_from_robot.distance(wrong) < 1e-9
    assert len(now.pairs) == 0
    free, _ = update(first.mapping, view, wrong, Params())
    assert free.mfis_from_robot.distance(Pose()) < 0.01


def test_a_step_changes_no_state_but_returns_a_new_one() -> None:
    walls, at = solid(l_room()), Pose(1.5, 1.5, 0.2)
    first = Mapper(Params(), SYMMETRIC)
    first.observe(scan(walls, at), Pose())
    last = first.mapping
    copies = [np.copy(a) for a in (last.mfis.surfaces, last.mfis.seen, last.mfis.physical)]
    view = Mapper(Params(), SYMMETRIC)
    view.observe(scan(walls, at @ Pose(1.0, 0.3, 0.4)), Pose())
    update(last, view.mapping.view, Pose(1.0, 0.3, 0.4), Params())
    now = (last.mfis.surfaces, last.mfis.seen, last.mfis.physical)
    assert all((a == b).all() for a, b in zip(copies, now, strict=True))
    assert len(BLANK.mfis) == 0


def test_two_parallel_corridor_walls_stay_parallel_and_their_distance() -> None:
    poses = along(np.array([[1, 1], [18, 1.0]]), 1.0)
    mapper, _ = drive(
        solid(corridor(20.0, 2.0)), poses, rng=np.random.default_rng(4), turn_error=0.005
    )
    long = mapper.surfaces[lengths(mapper.surfaces) > 5.0]
    assert len(long) == 2
    assert np.abs(np.sin(np.diff(headings(long)))).max() < 0.01
    gap = (long[1].mean(axis=0) - long[0].mean(axis=0)) @ np.array(
        (-math.sin(headings(long)[0]), math.cos(headings(long)[0]))
    )
    assert abs(gap) == pytest.approx(2.0, abs=0.05)
