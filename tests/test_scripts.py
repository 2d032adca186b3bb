"""The scripts that run an episode: what they leave behind, whole or interrupted."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from cogmap_gym import experiment_figures as fig
from cogmap_gym.saving import save_png, write_whole

ROOT = Path(__file__).parents[1]
PNG = b"\x89PNG"
PHASE_KEYS = {
    "task", "success", "moves", "path_length", "oracle_length", "asrs", "exits", "links",
}  # fmt: skip
LINE = np.array([[[0.0, 0.0], [2.0, 0.0]]])
NOTHING = np.zeros((0, 2, 2))


def start(script: str, *arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, str(ROOT / "scripts" / script), *map(str, arguments)]
    return subprocess.Popen(
        command, cwd=ROOT, env=None, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )


def run(script: str, *arguments: object) -> tuple[int, str]:
    process = start(script, *arguments)
    said, _ = process.communicate()
    return process.returncode, said


def sketch(boundary: list[list[float]]) -> dict[str, object]:
    return {
        "surfaces": [{"id": 3, "p": [0.0, 0.0], "q": [2.0, 0.0]}],
        "exits": [{"id": 1, "p": [2.0, 0.5], "q": [2.0, 1.5]}],
        "asrs": [{"id": 1, "boundary": boundary, "exits": [1]}],
        "links": [[1, 1, 2]],
        "here": 1,
        "pose": [1.0, 1.0, 0.5],
        "home": [1.0, 1.0],
    }


def test_a_file_is_replaced_whole_and_leaves_no_part_behind(tmp_path: Path) -> None:
    write_whole(tmp_path / "a.txt", b"old")
    assert write_whole(tmp_path / "a.txt", b"new") == tmp_path / "a.txt"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_bytes() == b"new"


def test_a_saved_figure_is_a_png(tmp_path: Path) -> None:
    assert save_png(Figure(), tmp_path / "a.png").read_bytes().startswith(PNG)


@pytest.mark.parametrize("boundary", [[], [[0, 0], [2, 0], [2, 2], [0, 2]]], ids=["open", "closed"])
def test_an_asr_can_be_drawn_whether_its_boundary_closed_or_not(
    tmp_path: Path, boundary: list[list[float]]
) -> None:
    path = np.array([[1.0, 1.0], [2.5, 1.0]])
    figure = fig.asr_figure(sketch(boundary), 1, {3}, np.zeros((0, 2)), LINE, path)
    titles = [ax.get_title() for ax in figure.axes]
    assert ("no boundary found" in titles[2]) == (not boundary)
    assert save_png(figure, tmp_path / "asr.png").exists()


def test_landmarks_are_shaded_before_and_after_normalisation() -> None:
    views = fig.TwoViews(4, LINE, [7], np.concatenate((LINE, LINE + 3.0)), [7, 0], 2 * LINE, [7])
    left, right = fig.landmarks_figure(views).axes
    for ax in (left, right):
        assert "landmark" in ax.get_legend_handles_labels()[1]
        assert ax.get_xlabel() == "x [m]"


def test_a_step_without_surfaces_can_be_drawn(tmp_path: Path) -> None:
    figure = fig.landmarks_figure(fig.TwoViews(0, NOTHING, [], NOTHING, [], NOTHING, []))
    assert save_png(figure, tmp_path / "landmarks.png").exists()


@pytest.mark.parametrize(
    ("script", "arguments"),
    [
        ("experiment.py", ("9",)),
        ("experiment.py", ("1", "--odometry", "wonderful")),
        ("experiment.py", ("1", "--map", "two_rooms")),
        ("experiment.py", ("3", "--film", "5,8")),
        ("run.py", ("--agent", "nobody")),
    ],
)
def test_a_bad_argument_is_refused_in_words(
    tmp_path: Path, script: str, arguments: tuple[str, ...]
) -> None:
    code, said = run(script, *arguments, "--out", tmp_path / "out")
    assert code == 2
    assert "Traceback" not in said
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_an_experiment_leaves_its_result_and_pictures_and_prints_their_paths(
    tmp_path: Path,
) -> None:
    code, said = run("experiment.py", 1, "--seed", 1000, "--out", tmp_path)
    assert code == 0, said
    result = json.loads((tmp_path / "result.json").read_text())
    assert set(result) == {"experiment", "seed", "phases"}
    assert [phase["task"] for phase in result["phases"]] == ["explore", "explore", "home"]
    assert all(set(phase) == PHASE_KEYS for phase in result["phases"])
    pictures = list(tmp_path.glob("*.png"))
    assert all(path.read_bytes().startswith(PNG) for path in pictures)
    printed = {Path(line) for line in said.splitlines() if line.startswith(str(tmp_path))}
    assert printed == {tmp_path / "result.json", *pictures}
    assert {"overview", "asr1", "phase3_home_path"} <= {path.stem for path in pictures}


@pytest.mark.slow
def test_the_third_experiment_shows_each_choice_of_a_new_exit_and_a_film(tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="films need MoviePy, the extra 'film'")
    code, said = run("experiment.py", 3, "--seed", 1000, "--film", "5,7", "--out", tmp_path)
    assert code == 0, said
    printed = {Path(line) for line in said.splitlines() if line.startswith(str(tmp_path))}
    assert printed == set(tmp_path.iterdir())
    names = {path.name for path in printed}
    assert {"film.mp4", "phase5_choice1.png", "phase5_goto_3_path.png"} <= names


@pytest.mark.slow
def test_ctrl_c_leaves_what_was_done_so_far(tmp_path: Path) -> None:
    process = start("experiment.py", 1, "--seed", 1000, "--out", tmp_path)
    while process.poll() is None and not (tmp_path / "asr1.png").exists():
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate()
    assert process.returncode == 130, said
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["interrupted"] is True
    assert (tmp_path / "overview.png").read_bytes().startswith(PNG)
    assert not list(tmp_path.glob(".*"))


@pytest.mark.slow
def test_a_run_prints_its_outcome_and_writes_a_picture_and_a_film(tmp_path: Path) -> None:
    film = tmp_path / "film.gif"
    code, said = run("run.py", "--map", "two_rooms", "--out", tmp_path, "--video", film)
    assert code == 0, said
    assert "success:" in said
    assert (tmp_path / "final.png").read_bytes().startswith(PNG)
    assert film.read_bytes().startswith(b"GIF")


def test_endurance_tells_what_is_remembered_from_time_to_time(tmp_path: Path) -> None:
    more = ("--map", "two_rooms", "--moves", 20, "--every", 10, "--out", tmp_path)
    code, said = run("endurance.py", *more)
    assert code == 0, said
    rows = [json.loads(line) for line in (tmp_path / "endurance.jsonl").read_text().splitlines()]
    assert [row["moves"] for row in rows] == [10, 20]
    assert rows[1]["surfaces"] >= rows[0]["surfaces"] > 0
    assert all(row["bytes"] > 0 and row["median_ms"] > 0.0 for row in rows)


def test_a_soak_tells_what_it_saw(tmp_path: Path) -> None:
    out = tmp_path / "soak.json"
    options = "--map", "two_rooms", "--steps", 120, "--rounds", 1, "--out", out
    status, said = run("soak.py", *options)
    assert status == 0, said
    told = json.loads(out.read_text())
    assert (told["cases"], told["steps"], told["faults"]) == (30, 120, [])
    assert told["deepest_m"]["walls"] < 0.01


def test_a_gallery_is_drawn(tmp_path: Path) -> None:
    out = tmp_path / "gallery.png"
    status, said = run("gallery.py", "--view", "two_rooms:busy", "--moves", 2, "--out", out)
    assert status == 0, said
    assert out.read_bytes().startswith(PNG)
    status, said = run("gallery.py", "--view", "two_rooms:wild", "--out", out)
    assert status == 2
    assert "dynamics" in said
