"""Doors that no view showed are noticed by having gone through them; gaps beside things are not."""

from __future__ import annotations

import numpy as np
import pytest

from agents.cogmap.navigator import sample_surfaces
from agents.cogmap.params import Passages
from agents.cogmap.passages import passages
from cogmap_gym.geometry import Points, Pose, Segments
from tests.simulated import segments

P = Passages()
WALL = segments((-4, 0, -0.45, 0), (0.45, 0, 4, 0), (-4, 0.2, -0.45, 0.2), (0.45, 0.2, 4, 0.2))
"""Both faces of a wall, with a door 0.9 m wide about the origin."""
ROOMS = segments((-4, -3, 4, -3), (4, -3, 4, 3), (4, 3, -4, 3), (-4, 3, -4, -3))


def points(*walls: Segments) -> Points:
    return sample_surfaces(np.concatenate(walls), 0.04)


def through(slant: float) -> Points:
    """A path through the door, turned by ``slant`` against its normal."""
    ahead = np.array((np.sin(slant), np.cos(slant)))
    return np.array((0.0, 0.1)) + np.linspace(-1.4, 1.4, 8)[:, None] * ahead


@pytest.mark.parametrize("slant", [-0.35, -0.2, 0.0, 0.2, 0.35])
def test_a_door_gone_through_is_noticed_however_slanted_the_path(slant: float) -> None:
    found = passages(through(slant), points(WALL, ROOMS), P)
    assert len(found) == 1
    line = found[0]
    assert np.hypot(*(line[1] - line[0])) == pytest.approx(0.9, abs=0.15)
    assert np.hypot(*(line.mean(axis=0) - (0.0, 0.1))) < 0.25
    assert line[0, 0] > line[1, 0], "from the jamb at the right to the one at the left"


def test_between_two_things_there_is_no_door() -> None:
    things = segments(
        (-1.0, -0.3, -0.45, -0.3), (-0.45, -0.3, -0.45, 0.3), (-0.45, 0.3, -1.0, 0.3),
        (0.45, 0.3, 0.45, -0.3), (0.45, -0.3, 1.0, -0.3), (1.0, 0.3, 0.45, 0.3),
    )  # fmt: skip
    assert len(passages(through(0.0), points(things, ROOMS), P)) == 0


def test_along_a_corridor_as_narrow_as_a_door_there_is_no_door() -> None:
    sides = segments((-0.5, -3, -0.5, 3), (0.5, 3, 0.5, -3))
    assert len(passages(through(0.0), points(sides), P)) == 0


def test_a_path_that_stays_on_one_side_meets_no_door() -> None:
    assert len(passages(through(0.0)[:4] - (0.0, 0.5), points(WALL, ROOMS), P)) == 0


def test_a_door_is_found_in_its_wall_wherever_the_scene_lies() -> None:
    move = Pose(-7.0, 3.0, 2.1)
    here = passages(through(0.2), points(WALL, ROOMS), P)
    there = passages(move.apply(through(0.2)), move.apply(points(WALL, ROOMS)), P)
    np.testing.assert_allclose(move.apply(here), there, atol=0.2)  # the wall's thickness


def test_without_a_move_nothing_is_found() -> None:
    assert passages(np.zeros((3, 2)), points(WALL), P).shape == (0, 2, 2)
    assert passages(np.zeros((0, 2)), points(WALL), P).shape == (0, 2, 2)


@pytest.mark.parametrize("nib", [0.25, 0.4])
def test_a_door_beside_a_wall_across_its_own_is_noticed(nib: float) -> None:
    end = -0.45 - nib
    wall = segments(
        (end, 0, -0.45, 0), (0.45, 0, 4, 0), (end, 0.2, -0.45, 0.2), (0.45, 0.2, 4, 0.2)
    )
    outer = segments((end, -3, end, 0), (end, 0.2, end, 3))
    found = passages(through(0.0), points(wall, outer, ROOMS), P)
    assert len(found) == 1
    assert np.hypot(*(found[0][1] - found[0][0])) == pytest.approx(0.9, abs=0.15)


def test_between_a_thing_and_a_wall_there_is_no_door() -> None:
    thing = segments((0.45, -0.3, 0.45, 0.3), (0.45, 0.3, 1.0, 0.3), (1.0, 0.3, 1.0, -0.3))
    outer = segments((-0.7, -3, -0.7, 3))
    assert len(passages(through(0.0), points(thing, outer, ROOMS), P)) == 0
