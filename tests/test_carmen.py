"""Reading CARMEN logs: the fan, frames, no-return readings, and what is refused."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from cogmap_gym.carmen import LaserLog, read_carmen
from cogmap_gym.geometry import Pose

LOGS = Path(__file__).parents[1].parent / "shared" / "data" / "logs"
needs_logs = pytest.mark.skipif(not LOGS.is_dir(), reason="no recordings in ../shared/data/logs")

HEADER = "# a comment\nPARAM robot_width 0.4\nODOM 1 2 3 0 0 0 1.0 host 1.0\n\n"
PATH = [Pose(0, 0, 0), Pose(1, 0, 0), Pose(1.5, 0.5, math.pi / 2), Pose(1.5, 2.5, -3.0)]


def numbers(pose: Pose) -> str:
    return f"{pose.x:.6f} {pose.y:.6f} {pose.theta:.6f}"


def flaser(ranges: list[object], laser: Pose, robot: Pose, time: float = 0.5) -> str:
    words = " ".join(map(str, ranges))
    return f"FLASER {len(ranges)} {words} {numbers(laser)} {numbers(robot)} {time} host 9.0\n"


def robotlaser1(ranges: list[float], laser: Pose, robot: Pose, fan: str, time: float) -> str:
    words = " ".join(map(str, ranges))
    return (
        f"ROBOTLASER1 0 {fan} 0.01 0 {len(ranges)} {words} 2 7 8 {numbers(laser)} "
        f"{numbers(robot)} 0.1 0.2 0.3 0.4 1e6 {time} host 9.0\n"
    )


def log_of(folder: Path, text: str, name: str = "a.clf") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def drive(folder: Path, poses: list[Pose]) -> LaserLog:
    return read_carmen(log_of(folder, "".join(flaser([1, 2, 3, 4], p, p) for p in poses)))


@pytest.mark.parametrize(
    ("beams", "step", "last"), [(180, 1, 89), (181, 1, 90), (360, 0.5, 89.5), (361, 0.5, 90)]
)
def test_the_fan_of_a_flaser_starts_at_the_right_and_has_a_last_beam_at_the_left_if_odd(
    tmp_path: Path, beams: int, step: float, last: float
) -> None:
    text = flaser([1.0] * beams, Pose(), Pose())
    laser = read_carmen(log_of(tmp_path, text)).laser
    assert laser.beams == beams
    np.testing.assert_allclose(np.degrees(laser.angles[[0, -1]]), (-90, last), atol=1e-9)
    assert math.degrees(laser.step) == pytest.approx(step)


def test_other_messages_are_passed_over_and_odometry_is_the_second_pose(tmp_path: Path) -> None:
    text = HEADER + "".join(
        flaser([1, 2, 3, 9], Pose(50 * t, 7, 0), p, 10.0 + t) + "ODOM 0 0 0 0 0 0 1 h 1\n"
        for t, p in enumerate(PATH)
    )
    log = read_carmen(log_of(tmp_path, text))
    assert log.scans.tolist() == [[1, 2, 3, 9]] * 4
    np.testing.assert_allclose(log.poses_odometry, [(p.x, p.y, p.theta) for p in PATH], atol=1e-6)
    assert log.times.tolist() == [10, 11, 12, 13]


def test_a_gzipped_log_reads_as_the_plain_one(tmp_path: Path) -> None:
    text = HEADER + flaser([1, 2, 3, 4], Pose(), Pose(1, 2, 3))
    plain = read_carmen(log_of(tmp_path, text, "a.log"))
    packed = tmp_path / "a.log.gz"
    packed.write_bytes(gzip.compress(text.encode()))
    unpacked = read_carmen(packed)
    assert unpacked.laser == plain.laser
    for name in ("scans", "poses_odometry", "times"):
        np.testing.assert_array_equal(getattr(unpacked, name), getattr(plain, name))


def test_readings_at_the_maximum_of_the_file_mean_no_return(tmp_path: Path) -> None:
    text = flaser([50, 2, 49.9, 4], Pose(), Pose()) + flaser([50, -1, "nan", "inf"], Pose(), Pose())
    log = read_carmen(log_of(tmp_path, text))
    assert log.laser.range_max == 50.0
    np.testing.assert_allclose(log.scans, [[50, 2, 49.9, 4], [50, 50, 50, 50]], rtol=1e-6)


def test_every_error_code_of_a_sick_means_no_return(tmp_path: Path) -> None:
    log = read_carmen(log_of(tmp_path, flaser([81.83, 81.87, 81.91, 31], Pose(), Pose())))
    assert (log.scans == log.laser.range_max).tolist() == [[True, True, True, False]]


def test_a_robotlaser1_states_its_fan_its_maximum_and_its_mount(tmp_path: Path) -> None:
    mount, fan = Pose(0.1, -0.2, 0.3), "-1.2 2.4 0.6 30.0"
    text = HEADER + "".join(
        robotlaser1([1, 2, 30, 31, 5], p @ mount, p, fan, 3.0 + t) for t, p in enumerate(PATH)
    )
    log = read_carmen(log_of(tmp_path, text))
    assert log.laser.first_angle == -1.2
    assert log.laser.step == 0.6
    assert log.laser.mount == pytest.approx((0.1, -0.2, 0.3), abs=1e-9)
    assert log.scans[0].tolist() == [1, 2, 30, 30, 5]
    assert log.times.tolist() == [3, 4, 5, 6]
    np.testing.assert_allclose(log.poses_odometry[2], (1.5, 0.5, math.pi / 2), atol=1e-6)


def test_the_mount_is_the_first_pose_as_seen_from_the_second(tmp_path: Path) -> None:
    ahead = Pose(0.25, 0, 0)
    text = "".join(flaser([1, 2], p @ ahead, p) for p in PATH)
    assert read_carmen(log_of(tmp_path, text)).laser.mount == (0.25, 0.0, 0.0)


def test_a_first_pose_that_wanders_is_a_correction_and_no_mount(tmp_path: Path) -> None:
    text = "".join(flaser([1, 2], p @ Pose(0.1 * t, 0, 0), p) for t, p in enumerate(PATH))
    assert read_carmen(log_of(tmp_path, text)).laser.mount == (0.0, 0.0, 0.0)


def test_where_both_poses_are_equal_a_comment_tells_the_mount(tmp_path: Path) -> None:
    text = "# pose = robot centre, laser 0.25 m ahead of it\n" + flaser([1, 2], Pose(), Pose())
    assert read_carmen(log_of(tmp_path, text)).laser.mount == (0.25, 0.0, 0.0)


GOOD = flaser([1, 2, 3, 4], Pose(), Pose())


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "expected a laser message"),
        (HEADER, "line 4: expected a laser message"),
        (GOOD + GOOD[:40], "line 2: FLASER num_readings: expected 15 words, got"),
        (GOOD + "FLASER", "line 2: FLASER num_readings: expected a whole number"),
        (GOOD + GOOD.replace("FLASER 4", "FLASER four"), "num_readings: .*got four"),
        (GOOD.replace("FLASER 4", "FLASER 5"), "line 1: FLASER num_readings: expected 16"),
        (GOOD.replace(" 3 ", " x "), "line 1: FLASER reading 2: expected a number, got 'x'"),
        (GOOD.replace(" 0.5 host", " noon host"), "FLASER ipc_timestamp: .*'noon'"),
        (GOOD + flaser([1] * 5, Pose(), Pose()), "line 2: FLASER .*beams.*expected .*as before"),
        (GOOD + flaser([1, 2, 3, 4], Pose(), Pose(0, math.nan)), "odom_y: expected a finite"),
        (flaser([0, 0], Pose(), Pose()), "range_max"),
        (robotlaser1([1, 2], Pose(), Pose(), "0 pi 1 8", 0), "fov: expected a number, got 'pi'"),
        (robotlaser1([1, 2], Pose(), Pose(), "0 1 1 8", 0)[:-9], "expected 28 words, got 26"),
    ],
)
def test_a_bad_log_is_refused_with_its_file_line_and_field(
    tmp_path: Path, text: str, named: str
) -> None:
    with pytest.raises(ValueError, match=named) as refusal:
        read_carmen(log_of(tmp_path, text, "bad.log"))
    assert "bad.log" in str(refusal.value)


@pytest.mark.parametrize("damage", ["cut", "flipped", "plain"])
def test_a_broken_gzip_is_refused_by_name(tmp_path: Path, damage: str) -> None:
    content = gzip.compress((GOOD * 500).encode())
    broken = {"cut": content[:-20], "flipped": content[:-8] + bytes(8), "plain": GOOD.encode()}
    path = tmp_path / "bad.clf.gz"
    path.write_bytes(broken[damage])
    with pytest.raises(ValueError, match=r"bad\.clf\.gz, after line \d+: broken gzip"):
        read_carmen(path)


def test_motions_add_up_to_the_odometry(tmp_path: Path) -> None:
    log = drive(tmp_path, PATH)
    for indices in (None, np.array([0, 2, 3])):
        motions = log.motions(indices)
        assert motions[0].tolist() == [0, 0, 0]
        here = Pose()
        for motion in motions:
            here = here @ Pose(*motion)
        assert (here.x, here.y, here.theta) == pytest.approx((1.5, 2.5, -3.0), abs=1e-5)


def test_motions_do_not_depend_on_the_origin_of_the_odometry(tmp_path: Path) -> None:
    moved = [Pose(500, -3, 2) @ p for p in PATH]
    there = drive(tmp_path, moved).motions()
    np.testing.assert_allclose(drive(tmp_path, PATH).motions(), there, atol=1e-5)


def test_one_scan_is_kept_per_given_motion(tmp_path: Path) -> None:
    steps = [Pose(0.2 * k, 0, 0) for k in range(6)] + [Pose(1.0, 0, 0.1 * k) for k in range(1, 6)]
    log = drive(tmp_path, steps)
    assert log.every(0.5, math.inf).tolist() == [0, 3]
    assert log.every(math.inf, 0.25).tolist() == [0, 8]
    assert log.every(0.5, 0.25).tolist() == [0, 3, 8]
    assert log.every(0.0, math.inf).tolist() == list(range(11))
    with pytest.raises(ValueError, match="nan"):
        log.every(math.nan, 1.0)


@needs_logs
@pytest.mark.parametrize(
    ("name", "shape", "path", "mount"),
    [
        ("csail_dense", (1051, 361), 373.2, 0.0),
        ("aces", (440, 180), 322.1, 0.0),
        ("wean1", (713, 180), 41.2, 0.25),
        ("wean2", (2251, 180), 87.2, 0.25),
    ],
)
def test_the_recordings_have_the_size_and_path_that_their_readme_tells(
    name: str, shape: tuple[int, int], path: float, mount: float
) -> None:
    log = read_carmen(LOGS / f"{name}.clf.gz")
    assert log.scans.shape == shape
    assert np.hypot(*log.motions()[:, :2].T).sum() == pytest.approx(path, abs=0.1)
    assert log.laser.mount == (mount, 0.0, 0.0)
    assert log.scans.max() == log.laser.range_max
