"""The script that maps a recording: what it feeds, and what it leaves behind."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from cogmap_gym.carmen import LaserLog, read_carmen
from cogmap_gym.geometry import Pose
from cogmap_gym.log_metrics import read_corrected
from cogmap_gym.observation import LaserSpec

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "scripts" / "map_log.py"
WIDTH, DEPTH = 8.0, 6.0


def ranges_in_room(pose: Pose, angles: np.ndarray) -> np.ndarray:
    """Exact ranges inside the rectangle from (0, 0) to (WIDTH, DEPTH)."""
    x, y = np.cos(angles + pose.theta), np.sin(angles + pose.theta)
    with np.errstate(divide="ignore"):
        to_x = np.where(x > 0, WIDTH - pose.x, -pose.x) / x
        to_y = np.where(y > 0, DEPTH - pose.y, -pose.y) / y
    return np.minimum(to_x, to_y)


def drive_round_a_room(folder: Path) -> tuple[Path, Path]:
    """A log of a drive round an empty room with odometry that drifts, and the true poses."""
    rng = np.random.default_rng(5)
    angles = np.radians(np.arange(-90, 91))
    truth, odometry, log, corrected = Pose(2, 2, 0), Pose(), [], ["scan_index,x,y,theta"]
    for t in range(64):
        ranges = np.append(ranges_in_room(truth, angles)[:-1] + rng.normal(0, 0.005, 180), 81.91)
        words = " ".join(f"{r:.3f}" for r in ranges)
        pose = f"{odometry.x} {odometry.y} {odometry.theta}"
        log.append(f"FLASER 181 {words} {pose} {pose} {t} host {t}")
        corrected.append(f"{t},{truth.x},{truth.y},{truth.theta}")
        move = Pose(0.25, 0, 0) if t % 16 < 10 else Pose(0, 0, math.pi / 12)
        truth = truth @ move
        odometry = odometry @ Pose(1.05 * move.x, 0, move.theta * 1.04)
    log_path, corrected_path = folder / "room.clf", folder / "room.corrected.csv"
    log_path.write_text("\n".join(log) + "\n")
    corrected_path.write_text("\n".join(corrected) + "\n")
    return log_path, corrected_path


class DeadReckoning:
    """A mapper that only adds up odometry; it is interrupted at scan ``stop``."""

    def __init__(self, laser: LaserSpec, stop: int = -1) -> None:
        self.laser, self.stop, self.seen = laser, stop, 0
        self.pose, self.surfaces = Pose(), np.array([[[0.0, 0.0], [1.0, 2.0]]])

    @property
    def landmark_count(self) -> int:
        return int(self.seen % 3 != 1)

    def observe(self, ranges: np.ndarray, odometry: Pose) -> None:
        assert ranges.shape == (self.laser.beams,)
        if self.seen == self.stop:
            raise KeyboardInterrupt
        self.pose, self.seen = self.pose @ odometry, self.seen + 1


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("map_log", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["map_log"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> LaserLog:
    return read_carmen(drive_round_a_room(tmp_path_factory.mktemp("log"))[0])


@pytest.mark.parametrize("metres", [0.0, 0.9])
def test_what_is_fed_adds_up_to_the_odometry_whatever_is_passed_over(
    script: ModuleType, recording: LaserLog, metres: float
) -> None:
    indices = recording.every(metres, math.inf)
    run = script.feed(DeadReckoning(recording.laser), recording, indices)
    assert run.scan_index == indices.tolist()
    start = Pose(*recording.poses_odometry[0])
    for index, pose in zip(run.scan_index, run.poses, strict=True):
        x, y, _ = recording.poses_odometry[index]
        assert (start @ Pose(*pose)).position == pytest.approx((x, y), abs=1e-9)


def test_an_interrupted_run_leaves_what_was_done_readable(
    script: ModuleType, recording: LaserLog, tmp_path: Path
) -> None:
    run = script.feed(DeadReckoning(recording.laser, stop=7), recording, np.arange(64))
    script.write_all(run, tmp_path / "new" / "out", "interrupted")
    assert run.interrupted
    assert read_corrected(tmp_path / "new" / "out" / "poses.csv").scan_index.tolist() == [*range(7)]
    sketch = json.loads((tmp_path / "new" / "out" / "mfis.json").read_text())
    assert sketch["surfaces"] == [{"id": 1, "p": [0.0, 0.0], "q": [1.0, 2.0]}]
    assert sketch["scans"] == 7
    assert sketch["steps_without_landmark"] == 2
    assert sketch["complete"] is False
    names = ["mfis.json", "mfis.png", "poses.csv"]
    assert sorted(path.name for path in (tmp_path / "new" / "out").iterdir()) == names


def test_a_run_interrupted_at_once_still_writes_its_files(
    script: ModuleType, recording: LaserLog, tmp_path: Path
) -> None:
    run = script.feed(DeadReckoning(recording.laser, stop=0), recording, np.arange(64))
    script.write_all(run, tmp_path, "nothing")
    assert (tmp_path / "poses.csv").read_text() == "scan_index,x,y,theta\n"
    assert (tmp_path / "mfis.png").read_bytes().startswith(b"\x89PNG")


def run_script(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "200", "NO_COLOR": "1"},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_room_is_mapped_better_than_by_odometry_and_the_truth_is_never_an_input(
    tmp_path: Path,
) -> None:
    log, corrected = drive_round_a_room(tmp_path)
    scored = run_script(log, "--out", tmp_path / "a", "--corrected", corrected)
    assert scored.returncode == 0, scored.stderr
    ratio = float(scored.stdout.split("mapper / raw odometry over 10 m: ")[1].split()[0])
    assert ratio < 0.5
    assert run_script(log, "--out", tmp_path / "b").returncode == 0
    for name in ("mfis.json", "poses.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    sketch = json.loads((tmp_path / "a" / "mfis.json").read_text())
    longest = max(math.dist(s["p"], s["q"]) for s in sketch["surfaces"])
    assert longest == pytest.approx(WIDTH, abs=0.3)
    assert sketch["steps_without_landmark"] == 0
    assert len(read_corrected(tmp_path / "a" / "poses.csv").poses) == 64


def test_a_bad_log_ends_the_script_with_one_clear_message(tmp_path: Path) -> None:
    bad = tmp_path / "bad.clf"
    bad.write_text("FLASER 3 1 2\n")
    ended = run_script(bad, "--out", tmp_path / "out")
    assert ended.returncode == 2
    assert "line 1: FLASER num_readings" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert not (tmp_path / "out").exists()
