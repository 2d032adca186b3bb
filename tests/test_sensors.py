"""The laws of the sensors' noise, and the words with which bad settings are refused."""

from __future__ import annotations

import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest

from cogmap_gym.geometry import Array, Pose, Segments
from cogmap_gym.noise import noisy_ranges
from cogmap_gym.observation import LaserSpec, RobotSpec, observation_space
from cogmap_gym.raycast import RayCaster
from cogmap_gym.sensors import (
    ODOMETRY_LEVELS,
    Laser,
    Odometer,
    OdometrySpec,
    laser_spec,
    odometry_bound,
    odometry_reading,
)

ROOM: Segments = np.array(
    [[[0, 0], [6, 0]], [[6, 0], [6, 4]], [[6, 4], [0, 4]], [[0, 4], [0, 0]]], dtype=np.float64
)
DRAWS = 3000
FIVE_SIGMA = 5.0
"""Standard errors within which a mean must lie: fixed seeds, so it cannot fail by chance."""

PRINT_A_SCAN = """
import numpy as np
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec
from cogmap_gym.raycast import RayCaster
from cogmap_gym.sensors import ODOMETRY_LEVELS, Laser, Odometer
rng = np.random.default_rng(3)
walls = rng.uniform(0.0, 9.0, (20, 2, 2))
scan = Laser(RayCaster(walls), LaserSpec()).scan(Pose(4.0, 4.0, 1.0), rng)
print(scan.tobytes().hex(), Odometer(ODOMETRY_LEVELS["high"], rng).measure(0.2, 1.0))
"""


def noise(key: int, count: int = 20 * DRAWS) -> Array:
    return noisy_ranges(np.full(count, 50.0), 100.0, 1.0, key).astype(np.float64) - 50.0


def moves(spec: OdometrySpec, turn: float, distance: float, *, one_episode: bool) -> Array:
    """Turn and distance errors of many measured moves, (DRAWS, 2)."""
    rng = np.random.default_rng(11)
    odometer, rows = Odometer(spec, rng), []
    for _ in range(DRAWS):
        if not one_episode:
            odometer = Odometer(spec, rng)
        motion = odometer.measure(turn, distance)
        rows.append((motion.theta - turn, math.hypot(motion.x, motion.y) - distance))
    return np.array(rows)


def test_laser_noise_is_gaussian_in_mean_spread_and_tails():
    x = noise(1)
    assert abs(x.mean()) < FIVE_SIGMA / math.sqrt(len(x))
    assert abs(x.std() - 1.0) < FIVE_SIGMA / math.sqrt(2 * len(x))
    for limit in (0.5, 1.0, 2.0, 3.0, 3.7):
        share = math.erfc(limit / math.sqrt(2.0))
        slack = FIVE_SIGMA * math.sqrt(share / len(x))
        assert abs((np.abs(x) > limit).mean() - share) < slack, limit


def test_laser_noise_of_neighbouring_beams_and_keys_is_independent():
    x, y = noise(1), noise(2)
    for a, b in ((x[1:], x[:-1]), (x, y), (x[1:] ** 2, x[:-1] ** 2), (x**2, y**2)):
        assert abs(np.corrcoef(a, b)[0, 1]) < FIVE_SIGMA / math.sqrt(len(x))


def test_noise_has_the_sd_of_the_spec_on_beams_that_return():
    laser, rng = Laser(RayCaster(ROOM), LaserSpec(beams=90)), np.random.default_rng(2)
    scans = np.array([laser.scan(Pose(2.0, 2.0), rng) for _ in range(300)], dtype=np.float64)
    exact = RayCaster(ROOM).ranges(Pose(2.0, 2.0), LaserSpec(beams=90))
    errors = scans - exact
    assert np.abs(errors.mean(axis=0)).max() < FIVE_SIGMA * 0.012 / math.sqrt(300)
    assert errors.std() == pytest.approx(0.012, rel=0.02)


def test_beams_without_return_read_exactly_range_max_and_no_reading_leaves_its_bounds():
    spec = LaserSpec(sd=3.0, range_max=5.3, beams=180, step=math.radians(2.0))
    laser, rng = Laser(RayCaster(ROOM[1:2]), spec), np.random.default_rng(2)
    exact = RayCaster(ROOM[1:2]).ranges(Pose(3.0, 2.0), spec)
    space = observation_space(spec, (1.0, 1.0, 1.0))["scan"]
    for _ in range(50):
        scan = laser.scan(Pose(3.0, 2.0), rng)
        assert (scan[exact == 5.3] == np.float32(5.3)).all()
        assert space.contains(scan)
    assert 0 < (exact == 5.3).sum() < 180


def test_without_noise_a_scan_is_the_exact_ranges_in_a_fresh_array_each_call():
    spec = LaserSpec(sd=0.0, beams=90)
    laser, rng = Laser(RayCaster(ROOM), spec), np.random.default_rng(0)
    first = laser.scan(Pose(1.0, 1.0, 0.5), rng)
    want = RayCaster(ROOM).ranges(Pose(1.0, 1.0, 0.5), spec).astype(np.float32)
    assert first.dtype == np.float32
    first[:] = 0.0
    np.testing.assert_array_equal(laser.scan(Pose(1.0, 1.0, 0.5), rng), want)


def test_a_mounted_laser_looks_from_where_it_sits_on_the_robot():
    mounted = LaserSpec(sd=0.0, beams=90, mount=(0.2, 0.1, 0.4))
    robot = Pose(2.0, 1.5, 0.7)
    got = Laser(RayCaster(ROOM), mounted).scan(robot, np.random.default_rng(0))
    want = RayCaster(ROOM).ranges(robot @ Pose(0.2, 0.1, 0.4), mounted)
    np.testing.assert_array_equal(got, want.astype(np.float32))


def test_the_same_seed_gives_the_same_bits_and_another_seed_does_not():
    laser = Laser(RayCaster(ROOM), LaserSpec(beams=90))
    a, b, c = (laser.scan(Pose(2.0, 2.0), np.random.default_rng(s)) for s in (4, 4, 5))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, c)


def test_two_processes_sense_the_same_bits():
    command = [sys.executable, "-c", PRINT_A_SCAN]
    runs = [subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(2)]
    assert runs[0].stdout == runs[1].stdout
    assert len(runs[0].stdout) > 8 * 360


def test_perfect_odometry_reports_the_true_motion():
    odometer = Odometer(ODOMETRY_LEVELS["perfect"], np.random.default_rng(0))
    moved = odometer.measure(0.4, 2.0)
    assert (moved.x, moved.y, moved.theta) == pytest.approx(
        (2 * math.cos(0.4), 2 * math.sin(0.4), 0.4)
    )
    for step in ((0.05, 0.01, 0.1), (-0.05, 0.0, 0.1), (0.0, 0.0, -0.2), (0.0, 0.03, 0.0)):
        slid = odometer.measure_velocity(*step)
        assert (slid.x, slid.y, slid.theta) == pytest.approx(step, abs=1e-12)


@pytest.mark.parametrize("level", ODOMETRY_LEVELS)
def test_a_robot_that_did_not_move_has_no_error(level):
    odometer = Odometer(ODOMETRY_LEVELS[level], np.random.default_rng(0))
    assert odometer.measure(0.0, 0.0) == Pose()
    assert odometer.measure_velocity(0.0, 0.0, 0.0) == Pose()


def test_the_levels_are_the_table_of_the_design():
    table = {
        name: (s.distance_sd, math.degrees(s.turn_sd), s.distance_bias, math.degrees(s.turn_bias))
        for name, s in ODOMETRY_LEVELS.items()
    }
    assert table["perfect"] == (0.0, 0.0, 0.0, 0.0)
    assert table["low"] == pytest.approx((0.01, 0.5, 0.0, 0.1))
    assert table["medium"] == pytest.approx((0.02, 1.0, 0.01, 0.25))
    assert table["high"] == pytest.approx((0.035, 2.0, 0.015, 0.4))
    assert table["severe"] == pytest.approx((0.05, 3.0, 0.02, 0.6))


@pytest.mark.parametrize(("turn", "distance"), [(15.0, 1.5), (-30.0, 3.0), (0.0, 0.4), (20.0, 0.0)])
def test_odometry_errors_have_the_documented_bias_and_spread(turn, distance):
    spec = ODOMETRY_LEVELS["medium"]
    errors = moves(spec, math.radians(turn), distance, one_episode=True)
    k = (abs(turn) / 15.0 + distance / 1.5) / 2.0
    bias = np.array((spec.turn_bias * k, spec.distance_bias * distance))
    sd = np.array((spec.turn_sd * math.sqrt(k), 1.5 * spec.distance_sd * math.sqrt(distance / 1.5)))
    if distance == 0.0:  # A hypotenuse hides the sign; there is none to report.
        assert (errors[:, 1] == 0.0).all()
    slack = FIVE_SIGMA * sd / math.sqrt(DRAWS) + 1e-12
    assert (np.abs(np.abs(errors.mean(axis=0)) - bias) < slack).all()
    assert (np.abs(errors.std(axis=0) - sd) < slack).all()


def test_the_signs_of_the_biases_are_drawn_once_an_episode_and_apart():
    spec = OdometrySpec(distance_sd=0.0, turn_sd=0.0, distance_bias=0.1, turn_bias=0.1)
    constant = moves(spec, math.radians(15.0), 1.5, one_episode=True)
    assert np.ptp(constant, axis=0).max() < 1e-12
    signs = np.sign(moves(spec, math.radians(15.0), 1.5, one_episode=False))
    assert np.abs(signs.mean(axis=0)).max() < FIVE_SIGMA / math.sqrt(DRAWS)
    assert abs(signs.prod(axis=1).mean()) < FIVE_SIGMA / math.sqrt(DRAWS)


def test_velocity_steps_add_up_to_the_spread_of_one_move():
    spec, rng = ODOMETRY_LEVELS["high"], np.random.default_rng(8)
    unbiased = dataclasses.replace(spec, distance_bias=0.0, turn_bias=0.0)
    turns, lengths = [], []
    for _ in range(400):
        odometer = Odometer(unbiased, rng)
        steps = [odometer.measure_velocity(0.06, 0.0, 0.0) for _ in range(25)]
        turns.append(sum(step.theta for step in steps))
        lengths.append(sum(math.hypot(step.x, step.y) for step in steps))
    assert np.std(turns) == pytest.approx(spec.turn_sd * math.sqrt(0.5), rel=0.15)
    assert np.std(lengths) == pytest.approx(1.5 * spec.distance_sd, rel=0.15)


def test_driving_backwards_mirrors_driving_forwards():
    spec = OdometrySpec(distance_sd=0.0, turn_sd=0.0, distance_bias=0.1, turn_bias=0.0)
    odometer = Odometer(spec, np.random.default_rng(0))
    ahead, back = (odometer.measure_velocity(d, 0.0, 0.0) for d in (0.07, -0.07))
    assert abs(ahead.x) != 0.07
    assert back.x == pytest.approx(-ahead.x)
    moved = [odometer.measure(0.0, d).x for d in (0.07, -0.07)]
    assert moved == pytest.approx([ahead.x, back.x])


@pytest.mark.parametrize("control", ["move", "velocity"])
@pytest.mark.parametrize("level", ODOMETRY_LEVELS)
def test_readings_stay_in_their_space_and_practically_never_need_clipping(control, level):
    robot, spec = RobotSpec(control=control), ODOMETRY_LEVELS[level]
    bound = odometry_bound(robot, spec)
    space = observation_space(LaserSpec(), bound)["odometry"]
    odometer = Odometer(spec, np.random.default_rng(1))
    for _ in range(500):
        if control == "move":
            motion = odometer.measure(robot.max_turn, robot.max_forward)
        else:
            motion = odometer.measure_velocity(0.07, 0.0, 0.1 * robot.max_turn_rate)
        reading = odometry_reading(motion, bound)
        assert reading.dtype == np.float32
        assert space.contains(reading)
        assert reading == pytest.approx((motion.x, motion.y, motion.theta), abs=1e-6)
    assert space.contains(odometry_reading(Pose(99.0, -99.0, math.pi), bound))


def test_odometry_is_read_from_a_name_a_mapping_or_a_spec():
    medium = ODOMETRY_LEVELS["medium"]
    assert OdometrySpec.of("medium") == medium
    assert OdometrySpec.of(medium) is medium
    assert OdometrySpec.of(dataclasses.asdict(medium)) == medium


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("awful", "'awful'"),
        ({"distance_sd": 0.1}, "missing field 'turn_sd'"),
        ({**dataclasses.asdict(ODOMETRY_LEVELS["low"]), "drift": 1.0}, "unknown field 'drift'"),
        ({**dataclasses.asdict(ODOMETRY_LEVELS["low"]), "turn_sd": "1 deg"}, "turn_sd"),
        ({**dataclasses.asdict(ODOMETRY_LEVELS["low"]), "turn_bias": -1.0}, "turn_bias"),
        ({**dataclasses.asdict(ODOMETRY_LEVELS["low"]), "turn_bias": math.nan}, "turn_bias"),
        (0.02, "mapping"),
    ],
)
def test_bad_odometry_is_refused_by_name(value, words):
    with pytest.raises(ValueError, match=words):
        OdometrySpec.of(value)


def test_a_laser_is_read_from_a_mapping_a_spec_or_nothing():
    assert laser_spec(None) == LaserSpec()
    spec = LaserSpec(beams=180, step=math.radians(1.0), mount=(0.1, 0.0, 0.0))
    assert laser_spec(spec) is spec
    assert laser_spec(dataclasses.asdict(spec) | {"mount": [0.1, 0, 0]}) == spec
    assert laser_spec({"sd": 0}) == LaserSpec(sd=0.0)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"range": 10.0}, "unknown field 'range'"),
        ({"beams": 90.5}, "beams"),
        ({"sd": "12 mm"}, "sd"),
        ({"mount": [0.0, 0.0]}, "mount"),
        ({"mount": [0.0, 0.0, "left"]}, "mount"),
        ({"range_max": -1.0}, "range_max"),
        ([360], "mapping"),
    ],
)
def test_a_bad_laser_is_refused_by_name(value, words):
    with pytest.raises(ValueError, match=words):
        laser_spec(value)
