"""Films: every environment can be recorded, and of an episode the phases that were asked for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import imageio.v2 as imageio
import numpy as np
import pytest
from gymnasium.wrappers import RecordVideo

import cogmap_gym
from agents.rollout import run_episode
from cogmap_gym.filming import Film, Moments
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.render import draw

SMALL = (120, 240)
SEED = 1002
"""Explores for seven moves before it is called home."""
ALL_PHASES = (1, 2)


class Turner:
    """Turns on the spot while it explores; then declares that it is there."""

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        self.robot = robot

    def act(self, observation: dict[str, Any]) -> np.ndarray:
        return self.robot.declare() if observation["goal"] else self.robot.move(0.3, 0.2)

    def sketch(self) -> None:
        return None


def made(name: str = "CogMap/GoHome-v0", **keywords: Any) -> gym.Env[Any, Any]:
    where = "thesis_office" if "Thesis" in name or "Shortcut" in name else "two_rooms"
    return gym.make(name, map=where, render_mode="rgb_array", **keywords)


def frames(film: Path) -> int:
    with imageio.get_reader(film) as reader:
        return sum(1 for _ in reader)


@pytest.fixture
def moviepy() -> None:
    pytest.importorskip("moviepy", reason="films need MoviePy, the extra 'film'")


@pytest.mark.usefixtures("moviepy")
@pytest.mark.parametrize("name", cogmap_gym.ENV_IDS)
def test_every_environment_can_be_recorded(name: str, tmp_path: Path) -> None:
    env = RecordVideo(
        made(name, max_moves=2), str(tmp_path / "films"), episode_trigger=lambda _: True
    )
    env.reset(seed=SEED)
    env.action_space.seed(SEED)
    for _ in range(2):
        *_, truncated, _ = env.step(env.action_space.sample())
    assert truncated
    env.close()
    (film,) = (tmp_path / "films").glob("*.mp4")
    assert frames(film) == 3


@pytest.mark.usefixtures("moviepy")
@pytest.mark.parametrize("phases", [(1,), (2,), ALL_PHASES])
def test_a_film_has_a_frame_for_each_move_of_its_phases(
    phases: tuple[int, ...], tmp_path: Path
) -> None:
    film = Film(made(), tmp_path, phases)
    episode = run_episode(film, Turner(), SEED)
    film.close()
    film.close()
    moves = [phase["moves"] for phase in episode.phases]
    assert frames(film.path) == sum(moves[phase - 1] for phase in phases)
    assert list(tmp_path.iterdir()) == [film.path]


@pytest.mark.usefixtures("moviepy")
def test_without_a_frame_there_is_no_film(tmp_path: Path) -> None:
    film = Film(made(), tmp_path, ALL_PHASES)
    film.reset(seed=SEED)
    film.close()
    assert not list(tmp_path.iterdir())


def test_a_frame_shows_the_moment_before_the_move() -> None:
    env = Moments(made(), (1,), SMALL)
    env.reset(seed=SEED)
    before = draw(env.unwrapped.scene(), SMALL)
    env.step(env.unwrapped.robot.move(0.3, 1.0))
    assert (env.render() == before).all()
    assert (draw(env.unwrapped.scene(), SMALL) != before).any()


def test_a_frame_shows_the_way_of_its_own_phase_alone() -> None:
    env = Moments(made(), (2,), SMALL)
    _, info = env.reset(seed=SEED)
    while info["phase"] == 0:
        *_, info = env.step(env.unwrapped.robot.move(0.3, 0.5))
    assert len(env.unwrapped.scene().path) > 2
    shown = draw(env.unwrapped.scene(), SMALL)
    assert (env.render() != shown).any()


def test_without_moviepy_a_film_is_refused_in_words(tmp_path: Path) -> None:
    program = (
        "import sys; sys.modules['moviepy'] = None\n"
        "import gymnasium, pathlib, cogmap_gym\n"
        "from cogmap_gym.filming import Film\n"
        "env = gymnasium.make('CogMap/Explore-v0', map='two_rooms', render_mode='rgb_array')\n"
        "try: Film(env, pathlib.Path(sys.argv[1]), (1,))\n"
        "except ValueError as error: print(error)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)],
        cwd=Path(__file__).parents[1], capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "expected MoviePy" in run.stdout
    assert not list(tmp_path.iterdir())
