"""Loose lines become a closed world: cracks and openings shut, what nobody sees left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, Segments


def house(gap: float, beyond: bool = False) -> Segments:
    """A house of 8 x 6 m with a gap in the south wall; beyond it, if wanted, a fence."""
    left, right = 4.0 - gap / 2.0, 4.0 + gap / 2.0
    lines = [
        [[0.0, 0.0], [left, 0.0]], [[right, 0.0], [8.0, 0.0]], [[8.0, 0.0], [8.0, 6.0]],
        [[8.0, 6.0], [0.0, 6.0]], [[0.0, 6.0], [0.0, 0.0]],
    ]  # fmt: skip
    fence = [[[-4.0, -5.0], [12.0, -5.0]]]
    return np.array(lines + fence if beyond else lines)


def plan_of(segments: Segments, folder: Path) -> FloorPlan:
    path = folder / "house.vectormap.txt"
    path.write_text("\n".join(",".join(map(str, row)) for row in segments.reshape(-1, 4).tolist()))
    return FloorPlan.load(path)


@pytest.mark.parametrize("gap", [0.005, 0.05, 0.11, 0.5, 1.0, 2.0, 2.9])
@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0])
def test_cracks_and_openings_to_the_outside_are_shut(
    gap: float, turn: float, tmp_path: Path
) -> None:
    moved = Pose(30.0, -20.0, turn).apply(house(gap, beyond=True))
    plan = plan_of(moved, tmp_path)
    assert plan.area == pytest.approx(48.0, abs=0.1)
    assert len(plan.rooms) == 1
    home = Pose(30.0, -20.0, turn).inverse().apply(plan.home.position)
    assert 2.9 < home[1] < 3.1, "home is as open as it can be, inside"


def test_a_wider_opening_stays_and_the_box_about_all_lines_closes_the_world(
    tmp_path: Path,
) -> None:
    plan = plan_of(house(4.0, beyond=True), tmp_path)
    assert plan.area == pytest.approx(16.0 * 11.0, abs=0.2)
    assert plan.bounds == pytest.approx((-4.0, -5.0, 12.0, 6.0))


def test_a_doorway_inside_stays_open(tmp_path: Path) -> None:
    inner = np.array([[[4.0, 0.0], [4.0, 2.5]], [[4.0, 3.4], [4.0, 6.0]]])
    plan = plan_of(np.concatenate((house(0.005), inner)), tmp_path)
    assert plan.area == pytest.approx(48.0, abs=0.1)
    assert len(plan.rooms) == 2
    assert plan.room_at(1.0, 1.0) != plan.room_at(7.0, 1.0)


def test_the_order_and_the_sense_of_the_lines_do_not_matter(tmp_path: Path) -> None:
    lines = house(1.0, beyond=True)
    one, other = plan_of(lines, tmp_path), plan_of(lines[::-1, ::-1], tmp_path)
    assert one.home.position == pytest.approx(other.home.position)
    assert one.free_space().symmetric_difference(other.free_space()).area < 0.02
