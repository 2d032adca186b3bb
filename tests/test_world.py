"""Laws of the true world: what moves, what stops it, and what the laser sees of it."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.world import World

ROBOT = RobotSpec()
RADIUS = ROBOT.radius
LASER = LaserSpec(sd=0.0)
HALL = {
    "name": "hall",
    "walls": [[[0, 0], [10, 0], [10, 6], [0, 6], [0, 0]], [[6, 0], [6, 2.5]], [[6, 3.5], [6, 6]]],
    "furniture": [],
    "doors": {"D": [[6, 2.5], [6, 3.5]]},
    "closed": [],
    "barriers": {"B": [[2, 4], [4, 4]]},
    "rooms": {"R1": [[0, 0], [6, 0], [6, 6], [0, 6]], "R2": [[6, 0], [10, 0], [10, 6], [6, 6]]},
    "home": [2, 3, 0],
}


@pytest.fixture
def hall() -> World:
    return World(FloorPlan.load(HALL), ROBOT)


def overlap(world: World) -> float:
    """How deep the body sits in anything [m]."""
    at = world.pose.position[None]
    return RADIUS - float(point_segment_distances(at, world.solid_segments).min())


def test_a_free_move_ends_exactly_where_it_should(hall: World) -> None:
    motion = hall.move(0.0, 3.0)
    assert (motion.bump, motion.turned) == (False, 0.0)
    assert motion.driven == pytest.approx(3.0, abs=1e-9)
    assert (hall.pose.x, hall.pose.y, hall.pose.theta) == pytest.approx((5.0, 3.0, 0.0), abs=1e-9)


def test_a_turn_is_exact_and_comes_before_the_drive(hall: World) -> None:
    motion = hall.move(math.pi / 6, 1.0)
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    assert hall.pose.theta == pytest.approx(math.pi / 6, abs=1e-15)
    assert (hall.pose.x, hall.pose.y) == pytest.approx((2 + c, 3 + s), abs=1e-9)
    assert motion.turned == math.pi / 6


def test_a_drive_through_the_open_door_is_free_and_a_shut_door_stops_it(hall: World) -> None:
    start = hall.state()
    hall.move(0.0, 3.0)
    assert not hall.move(0.0, 3.0).bump
    hall.set_state(start)
    hall.set_door("D", True)
    hall.move(0.0, 3.0)
    motion = hall.move(0.0, 3.0)
    assert motion.bump
    assert motion.driven == pytest.approx(1.0 - RADIUS, abs=0.01)


def test_a_barrier_stops_the_body_while_it_stands(hall: World) -> None:
    hall.place(Pose(3.0, 3.0, math.pi / 2))
    hall.set_barrier("B", True)
    assert hall.move(0.0, 2.0).bump
    hall.set_barrier("B", False)
    assert not hall.move(0.0, 1.5).bump


def test_the_laser_sees_what_the_body_meets(hall: World) -> None:
    middle = LaserSpec(first_angle=0.0, beams=1, sd=0.0)
    for shut, distance in ((False, 8.0), (True, 4.0), (False, 8.0)):
        hall.set_door("D", shut)
        assert hall.caster.ranges(hall.pose, middle)[0] == pytest.approx(distance)
    hall.set_barrier("B", True)
    left = LaserSpec(first_angle=math.pi / 2, beams=1, sd=0.0)
    assert hall.caster.ranges(Pose(3.0, 3.0, 0.0), left)[0] == pytest.approx(1.0)


def test_a_grazed_wall_lets_the_body_slide_and_a_steep_one_does_not(hall: World) -> None:
    hall.place(Pose(1.0, 0.3, math.radians(-10)))
    slide = hall.move(0.0, 2.0)
    assert not slide.bump
    assert hall.pose.x == pytest.approx(1.0 + 2.0 * math.cos(math.radians(10)), abs=0.1)
    hall.place(Pose(1.0, 0.3, math.radians(-40)))
    assert hall.move(0.0, 2.0).bump


def test_at_a_wall_the_robot_can_turn_and_leave(hall: World) -> None:
    hall.place(Pose(0.5, 3.0, math.pi))
    assert hall.move(0.0, 3.0).bump
    for _ in range(6):
        hall.move(math.pi / 6, 0.0)
    assert hall.move(0.0, 2.0).driven == pytest.approx(2.0, abs=0.01)


def test_no_move_of_a_random_walk_sinks_the_body_a_centimetre() -> None:
    rng = np.random.default_rng(3)
    world = World(FloorPlan.load("thesis_office"), ROBOT)
    bumps = 0
    for _ in range(600):
        motion = world.move(rng.uniform(-0.52, 0.52), rng.uniform(0.0, 3.0))
        bumps += motion.bump
        assert overlap(world) < 0.01
        assert motion.driven <= 3.0 + 1e-9
        assert world.plan.room_at(world.pose.x, world.pose.y) or bumps
    assert bumps > 100


def test_velocity_steps_add_up_to_a_circle(hall: World) -> None:
    robot = hall.robot
    steps = 72
    omega = math.tau / (steps * robot.velocity_step)
    motions = [hall.drive(0.5, omega) for _ in range(steps)]
    assert hall.pose.distance(Pose(2.0, 3.0)) < 1e-6
    assert sum(motion.turned for motion in motions) == pytest.approx(math.tau)
    assert sum(motion.driven for motion in motions) == pytest.approx(3.6, rel=1e-3)


def test_velocity_control_can_drive_backwards_into_a_wall(hall: World) -> None:
    hall.place(Pose(0.30, 3.0, 0.0))
    motion = hall.drive(-0.7, 0.0)
    assert motion.bump
    assert -0.06 < motion.driven < 0.0


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda w: pickle.loads(pickle.dumps(w))])
def test_a_copy_in_contact_goes_on_with_the_same_bits(copied, hall: World) -> None:
    rng = np.random.default_rng(0)
    hall.set_door("D", True)
    hall.place(Pose(5.7, 1.0, 1.3))
    for _ in range(8):
        hall.move(rng.uniform(-0.5, 0.5), rng.uniform(0, 3))
    twin = copied(hall)
    assert twin.shut_doors == {"D"}
    for turn, forward in zip(rng.uniform(-0.5, 0.5, 60), rng.uniform(0, 3, 60), strict=True):
        assert hall.move(turn, forward).path.tobytes() == twin.move(turn, forward).path.tobytes()
        assert hall.pose == twin.pose
    twin.set_door("D", False)
    assert hall.shut_doors == {"D"}


def test_a_place_that_is_no_place_is_refused(hall: World) -> None:
    for pose in (Pose(0.1, 3.0), Pose(-3.0, -3.0), Pose(math.nan, 1.0)):
        with pytest.raises(ValueError, match="place"):
            hall.place(pose)
    with pytest.raises(ValueError, match="'E9'"):
        hall.set_door("E9", True)
    with pytest.raises(ValueError, match="'D'"):
        hall.set_barrier("D", True)
