"""Plans turned, shifted and mirrored."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

import cogmap_gym  # noqa: F401 - registers the environments
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec
from cogmap_gym.plan_motion import drawn_motion, mirrored, moved

PLAN = FloorPlan.load("two_rooms")
MOTION = Pose(-30.0, 12.0, 2.5)
ONE_STEP = np.array((0.3, -0.2, 0.0), dtype=np.float32)


def first_views(plan: FloorPlan, laser: LaserSpec, action: np.ndarray) -> list[np.ndarray]:
    env = gym.make("CogMap/Explore-v0", map=plan, odometry="perfect", laser=laser)
    return [env.reset(seed=1)[0]["scan"], *(env.step(action)[0]["scan"] for _ in range(3))]


def test_a_moved_plan_has_the_same_rooms_and_area_elsewhere() -> None:
    plan = moved(PLAN, MOTION)
    assert plan.area == pytest.approx(PLAN.area)
    assert plan.room_at(*MOTION.apply(np.array((6.0, 3.0)))) == "R2"
    assert plan.room_at(plan.home.x, plan.home.y) == PLAN.room_at(PLAN.home.x, PLAN.home.y)


def test_moving_there_and_back_gives_the_plan_again() -> None:
    plan = moved(moved(PLAN, MOTION), MOTION.inverse())
    assert np.allclose(plan.walls_and_furniture(), PLAN.walls_and_furniture())
    assert np.allclose(plan.door_segments(), PLAN.door_segments())
    assert plan.home.position == pytest.approx(PLAN.home.position)


def test_a_mirror_of_a_mirror_gives_the_plan_again() -> None:
    assert mirrored(mirrored(PLAN)).to_mapping() == PLAN.to_mapping()


def test_a_robot_sees_the_same_in_a_moved_plan() -> None:
    laser = LaserSpec(sd=0.0)
    here, there = (first_views(p, laser, ONE_STEP) for p in (PLAN, moved(PLAN, MOTION)))
    assert np.allclose(here, there, atol=1e-4)


def test_a_robot_with_a_symmetric_fan_sees_the_reverse_in_a_mirror() -> None:
    laser = LaserSpec(first_angle=np.radians(-89.75), sd=0.0)
    here = first_views(PLAN, laser, ONE_STEP)
    there = first_views(mirrored(PLAN), laser, ONE_STEP * np.array((-1, 1, 1), dtype=np.float32))
    assert np.allclose(here, np.array(there)[:, ::-1], atol=1e-4)


def test_a_drawn_motion_is_the_same_for_the_same_seed_and_keeps_to_its_bounds() -> None:
    one, same, other = (drawn_motion(np.random.default_rng(seed), 5.0) for seed in (3, 3, 4))
    assert one == same != other
    assert max(abs(one.x), abs(one.y)) <= 5.0


def test_generated_offices_can_be_moved_and_mirrored() -> None:
    plan = FloorPlan.load("office:1000")
    for changed in (moved(plan, MOTION), mirrored(plan)):
        assert changed.area == pytest.approx(plan.area)
        assert changed.door_names == plan.door_names
