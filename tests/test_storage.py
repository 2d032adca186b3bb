"""A memory kept in a file is the memory, bit for bit."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.memory import NEWBORN, Leads
from agents.cogmap.storage import read_memory, write_memory
from agents.rollout import run_episode
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec, RobotSpec

ONWARD = """
import sys
import gymnasium as gym
import cogmap_gym
from agents.cogmap.agent import CogMapAgent
env = gym.make("CogMap/Explore-v0", map="two_rooms")
seen, _ = env.reset(seed=3)
agent = CogMapAgent()
agent.reset(env.unwrapped.robot, env.unwrapped.laser)
first = CogMapAgent()
first.reset(env.unwrapped.robot, env.unwrapped.laser)
for _ in range(25):
    seen, *_ = env.step(first.act(seen))
agent.load(sys.argv[1])
for _ in range(25):
    action = agent.act(seen)
    print(action.tobytes().hex())
    seen, *_ = env.step(action)
"""


def test_a_memory_loaded_in_a_new_process_gives_the_same_decisions_bit_for_bit(
    tmp_path: Path,
) -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms")
    seen, _ = env.reset(seed=3)
    agent = CogMapAgent()
    agent.reset(env.unwrapped.robot, env.unwrapped.laser)  # type: ignore[attr-defined]
    for _ in range(25):
        seen, *_ = env.step(agent.act(seen))
    agent.save(tmp_path / "memory.npz")
    actions = []
    for _ in range(25):
        actions.append(agent.act(seen).tobytes().hex())
        seen, *_ = env.step(np.frombuffer(bytes.fromhex(actions[-1]), np.float32).copy())
    done = subprocess.run(
        [sys.executable, "-c", ONWARD, str(tmp_path / "memory.npz")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == actions
    env.close()


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04"])
def test_what_is_no_memory_is_refused_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "wrong.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"wrong\.npz"):
        read_memory(path)


def test_a_file_of_other_arrays_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, x=np.zeros(3))
    with pytest.raises(ValueError, match=r"other\.npz"):
        read_memory(path)


def test_what_places_still_hide_is_kept(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    leads = Leads(
        *rng.normal(size=(2, 3, 2, 2)), *rng.normal(size=(2, 4, 2)), rng.integers(9, size=5)
    )
    memory = dataclasses.replace(NEWBORN, leads=((2, leads), (5, Leads())))
    write_memory(tmp_path / "memory.npz", memory)
    back = read_memory(tmp_path / "memory.npz")
    assert [place for place, _ in back.leads] == [2, 5]
    for place in (2, 5):
        for f in dataclasses.fields(Leads):
            kept, had = (getattr(m.leads_of(place), f.name) for m in (back, memory))
            assert kept.dtype == had.dtype
            assert np.array_equal(kept, had)


class SecondLife(CogMapAgent):
    """A robot carried back home with the map of its first life."""

    def __init__(self, path: Path) -> None:
        self.path: Path | None = None
        super().__init__()
        self.path = path

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        super().reset(robot, laser)
        if self.path is not None:
            self.load(self.path, at_home=True)


@pytest.mark.slow
@pytest.mark.parametrize("office", range(1001, 1004))
def test_a_robot_put_back_at_home_goes_on_with_its_map_and_comes_home(
    office: int, tmp_path: Path
) -> None:
    name = f"office:{office}"
    first = CogMapAgent()
    run_episode(gym.make("CogMap/Explore-v0", map=name, max_moves=150), first, 1)
    first.save(tmp_path / "memory.npz")
    known = len(first.memory.network.asrs)
    second = SecondLife(tmp_path / "memory.npz")
    env = gym.make("CogMap/GoHome-v0", map=name)
    episode = run_episode(env, second, 2)
    assert episode.info["is_success"]
    rooms = len(env.unwrapped.plan.rooms)  # type: ignore[attr-defined]
    assert known < len(second.memory.network.asrs) <= rooms + 1, "what it knew it maps no more"


def test_a_robot_put_back_at_home_is_at_home_and_keeps_what_it_knew(tmp_path: Path) -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms")
    agent = CogMapAgent()
    seen, _ = env.reset(seed=3)
    agent.reset(env.unwrapped.robot, env.unwrapped.laser)  # type: ignore[attr-defined]
    for _ in range(25):
        seen, *_ = env.step(agent.act(seen))
    agent.save(tmp_path / "memory.npz")
    before = agent.memory
    agent.load(tmp_path / "memory.npz", at_home=True)
    after = agent.memory
    assert after.pose == Pose()
    assert (after.stay.place, after.stay.known, after.intent) == (1, True, None)
    assert len(after.network.asrs) == len(before.network.asrs)
    assert {place for place, _ in after.leads} >= {before.stay.place}
    seen, _ = env.reset(seed=4)
    agent.act(seen)
    assert np.hypot(*agent.memory.pose.position) < 0.1, "the first view agrees with the map"
