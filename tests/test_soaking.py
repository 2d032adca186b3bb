"""Random steps of everything that can be made: nothing breaks, and what is restored goes on."""

from __future__ import annotations

import pytest

from cogmap_gym import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.soaking import Case, cases, faults, soak

PLANS = {name: FloorPlan.load(name) for name in ("thesis_office", "office:1001")}
CASES = [case for case in cases(PLANS) if case.map == "office:1001" or case.name[7:13] == "Thesis"]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_nothing_breaks_and_what_was_pickled_goes_on_with_the_same_bits(case: Case) -> None:
    assert soak(case.made(PLANS[case.map]), 1000, 60, {}) == []


def test_every_id_control_and_level_is_driven() -> None:
    kinds = {(case.name, case.control, case.dynamics) for case in CASES}
    assert len(kinds) == 3 * 2 * 5 + 2 * 2 * 3


def test_a_robot_inside_a_wall_is_told() -> None:
    env = CASES[0].made(plan := PLANS[CASES[0].map])
    env.reset(seed=1000)
    env.world._body.pose = Pose(*plan.wall_segments()[0].mean(axis=0))
    assert any("inside walls" in fault for fault in faults(env, env.step([0, -1, -1]), {}))
