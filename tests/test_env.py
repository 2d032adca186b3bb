"""The laws of Gymnasium and of DESIGN 3, for every id and map."""

from __future__ import annotations

import copy
import hashlib
import json
import math
import pickle
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import cogmap_gym
from agents.rollout import run_episode
from cogmap_gym import FloorPlan, LaserSpec, OdometrySpec, RobotSpec
from cogmap_gym.env import CogMapEnv
from cogmap_gym.scores import SCORES
from cogmap_gym.wrappers import TruePose

CASES = [
    ("CogMap/Explore-v0", {"map": "thesis_office"}),
    ("CogMap/Explore-v0", {"map": "two_rooms"}),
    ("CogMap/Explore-v0", {"map": "two_rooms", "control": "velocity"}),
    ("CogMap/GoHome-v0", {"map": "thesis_office"}),
    ("CogMap/GoHome-v0", {"map": "two_rooms", "control": "velocity"}),
    ("CogMap/GoTo-v0", {"map": "two_rooms"}),
    ("CogMap/Shortcut-v0", {"map": "thesis_office", "unreachable": 0.3}),
    *(("CogMap/Thesis-v0", {"experiment": number}) for number in (1, 2, 3)),
]
EACH = pytest.mark.parametrize(("name", "keywords"), CASES)
SKETCH = {
    "surfaces": [{"id": 1, "p": [1.0, 1.0], "q": [2.0, 1.0]}],
    "exits": [],
    "asrs": [],
    "links": [],
    "here": None,
    "pose": [0.0, 0.0, 0.0],
    "home": [0.0, 0.0, 0.0],
    "marks": {},
    "route": None,
    "status": "at home",
}
INFO_KEYS = {
    *("pose", "room", "coverage", "path_length", "phase", "events", "is_success"),
    *("success", "spl", "final_distance", "oracle_length"),
    *("spl_learning", "learning_length"),
}


@pytest.fixture(autouse=True)
def in_haste(monkeypatch: pytest.MonkeyPatch) -> None:
    """No window keeps to the pace of a person's eyes."""
    monkeypatch.setitem(CogMapEnv.metadata, "render_fps", 1000)


def made(name: str, keywords: dict[str, Any]) -> gym.Env[Any, Any]:
    return gym.make(name, **keywords)


def actions(env: gym.Env[Any, Any], count: int, declare: float = 0.0) -> list[np.ndarray]:
    """A random walk that now and then declares."""
    rng = np.random.default_rng(5)
    drawn = rng.uniform(-1.0, 1.0, (count, 3)).astype(np.float32)
    drawn[:, 2] = np.where(rng.random(count) < declare, 1.0, -1.0)
    return list(drawn)


def digest(step: tuple[Any, ...]) -> str:
    """Every bit of an observation, reward, flags and info."""
    text = repr([_plain(part) for part in step])
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(value[key]) for key in sorted(value)}
    if isinstance(value, np.ndarray):
        return str(value.dtype), value.tolist() if value.dtype == object else value.tobytes()
    return value


def walk(env: gym.Env[Any, Any], seed: int, count: int = 40) -> str:
    digests = [digest(env.reset(seed=seed))]
    for action in actions(env, count, declare=0.05):
        step = env.step(action)
        digests.append(digest(step))
        if step[2] or step[3]:
            digests.append(digest(env.reset()))
    return digest(tuple(digests))


@EACH
def test_the_spec_survives_json_and_makes_the_same_world(
    name: str, keywords: dict[str, Any]
) -> None:
    laser = LaserSpec(beams=30, step=math.radians(6.0))
    odometry = OdometrySpec.of("low")
    env = made(name, {**keywords, "laser": laser, "odometry": odometry})
    twin = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert (twin.unwrapped.laser, twin.unwrapped.odometry) == (laser, odometry)
    assert walk(env, 7) == walk(twin, 7)


def test_a_plan_object_becomes_its_mapping_in_the_spec() -> None:
    plan = FloorPlan.load("two_rooms")
    env = gym.make("CogMap/Explore-v0", map=plan)
    assert env.spec.kwargs["map"] == plan.to_mapping()
    assert walk(env, 1) == walk(gym.make(EnvSpec.from_json(env.spec.to_json())), 1)
    keywords = {"map": plan.to_mapping(), "laser": asdict(LaserSpec())}
    assert json.loads(json.dumps(keywords))["map"]["name"] == "two_rooms"


def test_the_same_seed_gives_the_same_bits_in_another_process() -> None:
    script = (
        "from tests.test_env import CASES, made, walk\n"
        "print([walk(made(n, k), 11) for n, k in CASES])\n"
    )
    root = Path(__file__).resolve().parents[1]
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=root, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == str([walk(made(n, k), 11) for n, k in CASES])


@EACH
def test_resets_differ_and_a_seed_brings_the_first_one_back(
    name: str, keywords: dict[str, Any]
) -> None:
    env = made(name, keywords)
    first, second, again = env.reset(seed=3)[0], env.reset()[0], env.reset(seed=3)[0]
    assert (first["scan"] != second["scan"]).any()
    assert (first["scan"] == again["scan"]).all()


@EACH
def test_no_array_is_handed_out_twice(name: str, keywords: dict[str, Any]) -> None:
    env = made(name, keywords)
    observation, info = env.reset(seed=3)
    kept = [(observation, info)]
    texts = [digest(kept[0])]
    for action in actions(env, 12):
        observation, _, _, _, info = env.step(action)
        kept.append((observation, info))
        texts.append(digest(kept[-1]))
    assert [digest(pair) for pair in kept] == texts
    for observation, info in kept:
        for array in (*observation.values(), *info.values()):
            if isinstance(array, np.ndarray):
                array.fill(0)
    assert digest((env.step(env.action_space.sample() * 0)[0],)) != digest((kept[0][0],))


@EACH
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda e: pickle.loads(pickle.dumps(e))])
def test_a_copy_goes_on_with_the_same_bits(copied, name: str, keywords: dict[str, Any]) -> None:
    env = made(name, keywords).unwrapped
    env.reset(seed=2)
    for action in actions(env, 30):
        env.step(action)
    twin = copied(env)
    for action in actions(env, 30):
        assert digest(env.step(action)) == digest(twin.step(action))
    assert digest(env.reset()) == digest(twin.reset())


@EACH
def test_info_has_constant_keys_and_no_nan(name: str, keywords: dict[str, Any]) -> None:
    env = made(name, keywords)
    infos = [env.reset(seed=1)[1]]
    for action in actions(env, 60, declare=0.1):
        *_, info = env.step(action)
        infos.append(info)
        assert isinstance(_[2], bool)
        assert isinstance(_[3], bool)
        if _[2] or _[3]:
            break
    for info in infos:
        assert set(info) == INFO_KEYS
        for key in SCORES:
            assert info[key].shape == (10,)
            assert np.isfinite(info[key]).all()


def test_a_bad_action_is_refused_and_a_large_one_is_clipped() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms", odometry="perfect").unwrapped
    env.reset(seed=0)
    for bad in (np.zeros(2), np.zeros((1, 3)), np.array((0.0, np.nan, 0.0)), 1.0):
        with pytest.raises(ValueError, match="action"):
            env.step(bad)
    observation, *_ = env.step(np.array((9.0, -0.5, -9.0)))
    assert observation["odometry"][2] == pytest.approx(math.radians(30.0))
    assert np.hypot(*observation["odometry"][:2]) == pytest.approx(0.75)


def test_perfect_odometry_tells_what_happened() -> None:
    env = gym.make("CogMap/Explore-v0", map="thesis_office", odometry="perfect").unwrapped
    env.reset(seed=0)
    for action in actions(env, 40):
        before = env.world.pose
        observation, *_ = env.step(action)
        moved = before.inverse() @ env.world.pose
        if not observation["bump"]:
            assert observation["odometry"][2] == pytest.approx(moved.theta, abs=1e-6)
    assert observation["scan"].dtype == np.float32


def test_a_declaration_does_not_move_the_robot() -> None:
    env = gym.make("CogMap/GoHome-v0", map="two_rooms").unwrapped
    env.reset(seed=0)
    before = env.world.pose
    observation, *_ = env.step(env.robot.declare())
    assert env.world.pose == before
    assert (observation["odometry"] == 0.0).all()
    assert observation["bump"] == 0


def test_contact_is_told_by_the_bump() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms").unwrapped
    env.reset(seed=0, options={"home": [1.0, 2.5, 180.0]})
    assert env.step(env.robot.move(0.0, 3.0))[0]["bump"] == 1
    assert env.step(env.robot.move(0.5, 0.0))[0]["bump"] == 0


def test_the_limit_truncates_and_a_reached_end_terminates() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms", max_moves=3)
    env.reset(seed=0)
    flags = [env.step(env.unwrapped.robot.move(0.1, 0.0))[2:4] for _ in range(3)]
    assert flags == [(False, False), (False, False), (False, True)]
    env = gym.make("CogMap/GoHome-v0", map="two_rooms")
    env.reset(seed=0)
    for _ in range(200):
        *_, terminated, truncated, info = env.step(env.unwrapped.robot.declare())
        if terminated:
            break
    assert (terminated, truncated) == (True, False)
    assert info["is_success"]


def test_home_can_be_moved_for_one_episode() -> None:
    env = gym.make("CogMap/GoHome-v0", map="two_rooms")
    _, info = env.reset(seed=0, options={"home": [6.0, 3.0, 90.0]})
    assert info["pose"] == pytest.approx((6.0, 3.0, math.pi / 2))
    assert info["room"] == "R2"
    for options in ({"home": [0.0, 0.0, 0.0]}, {"home": [1.0]}, {"house": 1}):
        with pytest.raises(ValueError, match=r"home|place"):
            env.reset(options=options)
    assert env.reset()[1]["room"] == "R1"


@pytest.mark.parametrize(
    ("keywords", "told"),
    [
        ({"map": "nowhere"}, "nowhere"),
        ({"control": "fly"}, "control"),
        ({"odometry": "awful"}, "awful"),
        ({"laser": {"beems": 3}}, "beems"),
        ({"max_moves": 0}, "max_moves"),
        ({"render_mode": "ascii"}, "render_mode"),
        ({"experiment": 1}, "experiment"),
        ({"unreachable": 0.1}, "unreachable"),
        ({"task": "shortcut", "unreachable": 2.0}, "unreachable"),
        ({"task": "shortcut"}, "chords"),
    ],
)
def test_a_bad_keyword_is_refused_by_name(keywords: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        CogMapEnv(**{"map": "two_rooms", **keywords})


def test_pictures_need_no_display_and_show_a_sketch() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms", render_mode="rgb_array")
    env.reset(seed=0)
    env.step(env.action_space.sample())
    plain = env.render()
    assert (plain.dtype, plain.ndim, plain.shape[2]) == (np.uint8, 3, 3)
    env.unwrapped.set_sketch(SKETCH)
    assert (env.render() != plain).any()
    env.close()
    env.close()


def test_the_true_pose_is_told_by_the_wrapper_alone() -> None:
    env = TruePose(gym.make("CogMap/Explore-v0", map="two_rooms"))
    observation, info = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    assert observation["pose"] == pytest.approx(info["pose"])
    assert "pose" not in env.env.reset(seed=0)[0]


class Walker:
    """Turns on the spot; spoils what it is given, to see whether that leaks."""

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        self.robot = robot

    def act(self, observation: dict[str, Any]) -> np.ndarray:
        observation["scan"].fill(0.0)
        return self.robot.declare() if observation["goal"] else self.robot.move(0.3, 0.2)

    def sketch(self) -> dict[str, Any] | None:
        return {"asrs": [1, 2], "exits": [], "links": [[0, 1, 2]]}


def test_a_rollout_records_phases_and_the_true_path() -> None:
    env = gym.make("CogMap/GoHome-v0", map="two_rooms")
    scans: list[float] = []
    episode = run_episode(
        env,
        Walker(),
        4,
        on_step=lambda k, obs, action, info, agent: scans.append(obs["scan"].max()),
    )
    assert episode.terminated
    assert episode.path.shape == (episode.steps + 1, 3)
    assert len(scans) == episode.steps
    assert min(scans) > 0.0
    assert [phase["task"] for phase in episode.phases] == ["explore", "home"]
    assert episode.phases[1]["asrs"] == 2
    assert episode.is_success == bool(episode.success[1] == 1.0)
    json.dumps(episode.phases)


def test_every_id_is_registered_with_a_string() -> None:
    for name in cogmap_gym.ENV_IDS:
        assert isinstance(gym.spec(name).entry_point, str)
    assert {name for name, _ in CASES} == set(cogmap_gym.ENV_IDS)
