"""Training of learned robots: checkpoints, and the script when it is killed, stopped or misused."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("sb3_contrib", reason="needs the extra rl")
pytest.importorskip("tensorboard", reason="needs the extra rl")

import torch
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

import cogmap_gym  # noqa: F401 - registers the environments
from agents.ppo import checkpoint
from agents.ppo.agent import LearnedAgent
from agents.ppo.params import Config, Network
from agents.ppo.training import Watch, make_model
from agents.ppo.vec_env import Joined, LearningEnv

SCRIPT = Path(__file__).parents[1] / "scripts" / "train_ppo.py"
ARGS = {"seed": 1, "gamma": 0.9}
TINY = {
    "explorers": 2, "homers": 1, "rollout": 16, "batch": 24, "most-moves": 20, "trials": 0,
    "shared": 8, "heads": 8, "lstm": 8, "checkpoint-seconds": 0, "steps": 480,
}  # fmt: skip


def learner(lstm: int) -> OnPolicyAlgorithm:
    config = Config(network=Network(8, 8, lstm))
    env = gym.make_vec(
        "CogMap/Explore-v0", num_envs=2, map="two_rooms", autoreset_mode="SameStep", max_moves=5
    )
    joined = Joined({"explore": LearningEnv(env.unwrapped, config, 5)})  # type: ignore[arg-type]
    return make_model(joined, config, seed=1, n_steps=8, batch_size=8, n_epochs=1, gamma=0.9)


def watched(path: Path, curve: checkpoint.Curve) -> Watch:
    return Watch(path, ARGS, curve, every=0.0, tell=lambda *_: None)


@pytest.mark.parametrize("lstm", [0, 8], ids=["plain", "recurrent"])
def test_a_resumed_training_goes_on_where_it_was(tmp_path: Path, lstm: int) -> None:
    path, model = tmp_path / "c.pt", learner(lstm)
    before = [value.clone() for value in model.policy.parameters()]
    watch = watched(path, [])
    model.learn(48, watch)
    watch.keep()
    pairs = zip(before, model.policy.parameters(), strict=True)
    assert any(not torch.equal(a, b) for a, b in pairs)
    other = learner(lstm)
    curve = checkpoint.load(path, other, ARGS)
    assert other.num_timesteps == 48
    assert curve == watch.curve
    assert "explore/area" in curve[-1]
    for one, two in zip(model.policy.parameters(), other.policy.parameters(), strict=True):
        assert torch.equal(one, two)
    old = model.policy.optimizer.state_dict()["state"]
    new = other.policy.optimizer.state_dict()["state"]
    assert old.keys() == new.keys()
    assert all(torch.equal(old[k]["exp_avg"], new[k]["exp_avg"]) for k in old)
    scales = [m.get_vec_normalize_env().ret_rms.var for m in (model, other)]  # type: ignore[union-attr]
    assert scales[0] == scales[1] != 1.0
    other.learn(32, watched(path, curve), reset_num_timesteps=False)
    assert other.num_timesteps == 80
    assert [point["steps"] for point in curve] == sorted(point["steps"] for point in curve)


def test_a_checkpoint_of_another_training_is_refused(tmp_path: Path) -> None:
    path, model = tmp_path / "c.pt", learner(0)
    checkpoint.save(path, model, [], ARGS)
    with pytest.raises(ValueError, match=r"c.pt: begun with gamma=0.9, not 0.5"):
        checkpoint.load(path, model, ARGS | {"gamma": 0.5})
    path.write_bytes(b"no checkpoint")
    with pytest.raises(ValueError, match=r"c.pt: no checkpoint"):
        checkpoint.load(path, model, ARGS)
    with pytest.raises(FileNotFoundError):
        checkpoint.load(tmp_path / "none.pt", model, ARGS)


def command(out: Path, **given: Any) -> list[str]:
    words = {**TINY, "out": out, "weights": out / "weights", **given}
    return [
        sys.executable,
        str(SCRIPT),
        *(f"--{key}={value}" if value != "" else f"--{key}" for key, value in words.items()),
    ]


def start(out: Path, *flags: str, **given: Any) -> subprocess.Popen[str]:
    # A test run in the background hands on that Ctrl-C is ignored.
    return subprocess.Popen(
        [*command(out, **given), *flags], cwd=SCRIPT.parents[1], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    while not path.exists() and process.poll() is None:
        time.sleep(0.1)
    assert path.exists(), process.communicate()[0]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"robot": "a_dog"}, "argument --robot: invalid choice: 'a_dog'"),
        ({"preset": "huge"}, "argument --preset: invalid choice: 'huge'"),
        ({"first-office": 5}, "--first-office: those below 1000 are for tests"),
        ({"resume": ""}, "--out: .*checkpoint.pt: missing"),
    ],
)
def test_bad_arguments_are_refused_in_words(
    tmp_path: Path, given: dict[str, Any], said: str
) -> None:
    out, _ = (process := start(tmp_path / "run", **given)).communicate()
    assert process.returncode == 2
    assert re.search(said, out)
    assert "Traceback" not in out


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["ppo", "recurrent_ppo"])
def test_a_killed_training_is_resumed_to_its_end(tmp_path: Path, robot: str) -> None:
    process = start(tmp_path, robot=robot, steps=1_000_000)
    wait_for(tmp_path / "checkpoint.pt", process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    kept = torch.load(tmp_path / "checkpoint.pt", weights_only=True)["steps"]
    said, _ = (again := start(tmp_path, "--resume", robot=robot, steps=kept + 96)).communicate()
    assert again.returncode == 0, said
    card = json.loads((tmp_path / "weights" / f"{robot}.json").read_text())
    assert kept <= card["curve"][-1]["steps"] + 48
    assert torch.load(tmp_path / "checkpoint.pt", weights_only=True)["steps"] == kept + 96
    assert list(tmp_path.glob("events.out.tfevents.*"))
    agent = LearnedAgent(tmp_path / "weights" / f"{robot}.safetensors")
    scan = np.full(360, 3.0, dtype=np.float32)
    still = {"scan": scan, "odometry": np.zeros(3), "bump": 0, "mark": 1, "goal": 0}
    assert agent.robot.action_space.contains(agent.act(still))


@pytest.mark.slow
def test_ctrl_c_leaves_a_checkpoint(tmp_path: Path) -> None:
    process = start(tmp_path, steps=1_000_000)
    wait_for(tmp_path / "checkpoint.pt", process)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate()
    assert process.returncode == 130, said
    assert "--resume goes on from" in said
    assert "Traceback" not in said
