"""Doors now open in walls the robot knows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.cogmap.params import Gaps
from agents.cogmap.wall_openings import wall_openings
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments
from tests.simulated import SYMMETRIC, mirrored, scan, segments

P = Gaps()
KNOWN = segments((8, 0, 0, 0))
"""The wall as it is known: whole, the robot's space at y < 0."""
AROUND = segments((-4, -4, 12, -4), (12, -4, 12, 4), (12, 4, -4, 4), (-4, 4, -4, -4))
OPEN = np.concatenate((AROUND, segments((-4, 0, 3.5, 0), (4.5, 0, 12, 0))))
SHUT = np.concatenate((AROUND, segments((-4, 0, 12, 0))))
SQUARELY, ASLANT = Pose(4.0, -2.5, np.pi / 2), Pose(1.5, -2.5, np.pi / 4)


def beams(walls: Segments, pose: Pose) -> tuple[Points, Points]:
    """Where the beams come from (2,), and end (B, 2)."""
    laser = pose @ SYMMETRIC.robot_from_laser
    ranges, turns = scan(walls, pose), SYMMETRIC.first_angle + SYMMETRIC.step * np.arange(361)
    rays = np.stack((np.cos(turns), np.sin(turns)), axis=-1) * ranges[:, None]
    return laser.position, laser.apply(rays)


def seen(walls: Segments, pose: Pose, known: Segments = KNOWN) -> Segments:
    return wall_openings(known, *beams(walls, pose), P)


@pytest.mark.parametrize("pose", [SQUARELY, ASLANT], ids=["squarely", "from 45 degrees"])
def test_a_door_now_open_in_a_known_wall_is_an_opening(pose: Pose) -> None:
    (opening,) = seen(OPEN, pose)
    assert opening == pytest.approx(np.array([[4.5, 0.0], [3.5, 0.0]]), abs=0.12)


@pytest.mark.parametrize("pose", [SQUARELY, ASLANT], ids=["squarely", "from 45 degrees"])
def test_a_shut_door_is_no_opening(pose: Pose) -> None:
    assert len(seen(SHUT, pose)) == 0


@pytest.mark.parametrize("pose", [SQUARELY, ASLANT], ids=["squarely", "from 45 degrees"])
def test_a_person_before_a_whole_wall_is_no_opening(pose: Pose) -> None:
    ahead = pose.apply(np.array((1.2, 0.0)))
    ring = 0.25 * np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) + ahead
    person = np.stack((ring, np.roll(ring, -1, axis=0)), axis=1)
    assert len(seen(np.concatenate((SHUT, person)), pose)) == 0


def test_a_niche_or_a_gap_of_another_width_is_no_door() -> None:
    niche = segments((-4, 0, 3.5, 0), (3.5, 0, 3.5, 0.6), (3.5, 0.6, 4.5, 0.6),
                     (4.5, 0.6, 4.5, 0), (4.5, 0, 12, 0))  # fmt: skip
    assert len(seen(np.concatenate((AROUND, niche)), SQUARELY)) == 0
    narrow = np.concatenate((AROUND, segments((-4, 0, 3.8, 0), (4.2, 0, 12, 0))))
    wide = np.concatenate((AROUND, segments((-4, 0, 3.0, 0), (5.0, 0, 12, 0))))
    assert len(seen(narrow, SQUARELY)) == 0
    assert len(seen(wide, SQUARELY)) == 0


def test_a_short_wall_and_one_seen_from_behind_tell_of_no_door() -> None:
    assert len(seen(OPEN, SQUARELY, segments((4.9, 0, 3.1, 0)))) == 0
    assert len(seen(OPEN, SQUARELY, KNOWN[:, ::-1])) == 0


def test_without_walls_or_beams_there_is_no_opening() -> None:
    eye, ends = beams(OPEN, SQUARELY)
    assert wall_openings(NO_SEGMENTS, eye, ends, P).shape == (0, 2, 2)
    assert wall_openings(KNOWN, eye, ends[:0], P).shape == (0, 2, 2)


@settings(max_examples=20)
@given(
    moved=st.builds(Pose, st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1)),
    seed=st.integers(0, 99),
)
def test_openings_do_not_depend_on_the_origin_nor_on_the_order_of_beams(
    moved: Pose, seed: int
) -> None:
    eye, ends = beams(OPEN, ASLANT)
    here = wall_openings(KNOWN, eye, ends, P)
    mixed = np.random.default_rng(seed).permutation(ends)
    there = wall_openings(moved.apply(KNOWN), moved.apply(eye), moved.apply(mixed), P)
    assert there == pytest.approx(moved.apply(here), abs=1e-6)


def test_a_mirrored_wall_has_the_mirrored_opening() -> None:
    (eye, ends), flip = beams(OPEN, ASLANT), np.array((1.0, -1.0))
    here = wall_openings(KNOWN, eye, ends, P)
    there = wall_openings(mirrored(KNOWN), eye * flip, ends * flip, P)
    assert there == pytest.approx(mirrored(here), abs=1e-9)
