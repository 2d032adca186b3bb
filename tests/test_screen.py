"""The window: what changes in the scene is seen, no screen is needed, and closing is easy."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pygame
import pytest
from gymnasium.utils.env_checker import check_env

from cogmap_gym.env import CogMapEnv
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.render import Scene
from cogmap_gym.screen import Window
from cogmap_gym.wrappers import MoveControl
from tests.test_render import SKETCH, TWO_ROOMS

ROOT = Path(__file__).parents[1]
SIZE = (480, 270)


@pytest.fixture(scope="module")
def scene() -> Scene:
    plan = FloorPlan.load(TWO_ROOMS)
    path = np.array([[2.0, 2.5], [3.0, 2.0]])
    return Scene(plan, Pose(3.0, 2.0, 0.5), path=path, plan_from_sketch=plan.home)


def shown(scene: Scene, *notes: str) -> np.ndarray:
    window = Window(frames_per_second=1000.0, size=SIZE)
    window.show(scene, notes)
    assert window.surface is not None
    pixels = pygame.surfarray.array3d(window.surface)
    window.close()
    return np.asarray(pixels)


@pytest.mark.parametrize(
    "change",
    [
        {"pose": Pose(6.0, 4.0, 0.0)},
        {"pose": Pose(3.0, 2.0, 2.5)},
        {"shut": ("E1",)},
        {"barriers": ("B1",)},
        {"scan": np.array([[4.0, 1.0], [3.0, 5.0]])},
        {"path": np.array([[2.0, 2.5], [2.0, 1.0]])},
        {"goal_pose": Pose(6.0, 1.0, 0.0)},
        {"caption": "something else"},
        {"sketch": SKETCH},
    ],
    ids=lambda change: next(iter(change)),
)
def test_whatever_changes_in_the_scene_is_seen(scene: Scene, change: dict[str, Any]) -> None:
    assert (shown(scene) != shown(dataclasses.replace(scene, **change))).any()


def test_the_belief_stands_at_the_right_and_leaves_the_truth_as_it_is(scene: Scene) -> None:
    one = shown(dataclasses.replace(scene, sketch=SKETCH))
    moved = {**SKETCH, "pose": [1.0, 0.5, 2.0], "status": "elsewhere"}
    other = shown(dataclasses.replace(scene, sketch=moved))
    half = SIZE[0] // 2
    assert (one[:half] == other[:half]).all()
    assert (one[half:] != other[half:]).any()


def test_notes_stand_below_the_picture(scene: Scene) -> None:
    one, other = shown(scene, "hello"), shown(scene, "good bye")
    differing = np.nonzero((one != other).any(axis=(0, 2)))[0]
    assert len(differing)
    assert differing.min() > SIZE[1] - 45


def test_a_belief_of_nothing_can_be_painted(scene: Scene) -> None:
    nothing = {"surfaces": [], "exits": [], "asrs": [], "links": [], "here": None}
    assert shown(dataclasses.replace(scene, sketch=nothing)).shape == (*SIZE, 3)


def test_a_window_may_be_closed_twice_and_opens_again(
    scene: Scene, capsys: pytest.CaptureFixture[str]
) -> None:
    window = Window(frames_per_second=1000.0, size=SIZE)
    window.close()
    for _ in range(2):
        window.show(scene)
        assert window.surface is not None
        window.close()
        window.close()
        assert window.surface is None
    assert capsys.readouterr().out == ""


def test_a_window_that_a_person_closed_stays_closed(scene: Scene) -> None:
    window = Window(frames_per_second=1000.0, size=SIZE)
    window.show(scene)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    window.show(scene)
    assert window.surface is None
    window.show(scene)
    assert window.surface is None


@pytest.fixture(autouse=True)
def in_haste(monkeypatch: pytest.MonkeyPatch) -> None:
    """No window keeps to the pace of a person's eyes."""
    monkeypatch.setitem(CogMapEnv.metadata, "render_fps", 1000)


@pytest.fixture
def env() -> Any:
    return gym.make("CogMap/Explore-v0", map="two_rooms", render_mode="human").unwrapped


def test_every_step_of_a_human_environment_is_shown(env: Any) -> None:
    env.reset(seed=1000)
    first = pygame.surfarray.array3d(env._window.surface)
    env.step(env.robot.move(0.3, 0.5))
    second = pygame.surfarray.array3d(env._window.surface)
    assert (first != second).any()
    env.set_sketch(SKETCH)
    assert env.render() is None
    assert (second != pygame.surfarray.array3d(env._window.surface)).any()
    env.close()
    env.close()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda e: pickle.loads(pickle.dumps(e))])
def test_a_shown_environment_can_be_copied_and_the_copy_opens_a_window(
    copied: Any, env: Any
) -> None:
    env.reset(seed=1000)
    twin = copied(env)
    action = env.robot.move(0.1, 0.2)
    assert (env.step(action)[0]["scan"] == twin.step(action)[0]["scan"]).all()
    env.close()
    twin.close()


@pytest.mark.parametrize("control", ["move", "velocity"])
def test_the_checker_finds_no_fault_in_human_mode(control: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make("CogMap/GoTo-v0", map="two_rooms", control=control, render_mode="human")
        check_env(env.unwrapped)
        shown = MoveControl(env) if control == "velocity" else env
        shown.reset(seed=1000)
        shown.step(shown.action_space.sample())
        shown.close()


def play(*arguments: object) -> tuple[int, str]:
    command = [sys.executable, str(ROOT / "scripts" / "play.py"), *map(str, arguments)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return run.returncode, run.stdout + run.stderr


def test_a_game_by_given_keys_ends_with_a_score_and_a_picture(tmp_path: Path) -> None:
    picture = tmp_path / "a" / "last.png"
    code, said = play(
        "--env", "CogMap/GoHome-v0", "--map", "two_rooms", "--control", "move",
        "--seed", 1000, "--keys", "w" + 12 * "aaadw" + 3 * "." , "--picture", picture,
    )  # fmt: skip
    assert code == 0, said
    assert "driven" in said
    assert "seen" in said
    assert "Traceback" not in said
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_two_windows_share_the_display_and_one_may_close(scene: Scene) -> None:
    one, other = (Window(frames_per_second=1000.0, size=SIZE) for _ in range(2))
    one.show(scene)
    other.show(scene)
    one.close()
    other.show(scene)
    one.show(scene)
    other.close()
    one.close()


def test_a_game_is_refused_in_words(tmp_path: Path) -> None:
    for arguments in (("--env", "Chess"), ("--keys", "xyz"), ("--map", "nowhere")):
        code, said = play(*arguments)
        assert code == 2
        assert "Traceback" not in said
