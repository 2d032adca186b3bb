"""Learned robots: what they perceive, their weights on disk, and the environment they learn in."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("sb3_contrib", reason="needs the extra rl")

import safetensors.torch
import torch

from agents.ppo.agent import LearnedAgent
from agents.ppo.card import Result, compare, run, summary, write_card
from agents.ppo.export import export
from agents.ppo.loading import KEY, ROBOTS, load, path_of
from agents.ppo.moving import action_of
from agents.ppo.network import build
from agents.ppo.params import Config, Moves, Network, Percepts
from agents.ppo.perception import Perception
from agents.ppo.vec_env import Joined, LearningEnv
from agents.random_walk import RandomWalkAgent
from agents.registry import AGENTS, make_agent
from agents.rollout import run_episode
from cogmap_gym import FloorPlan
from cogmap_gym.observation import LaserSpec, RobotSpec

SMALL = Config(network=Network(8, 8, 0))
RECURRENT = Config(network=Network(8, 8, 8))
STAND = (Moves().turns.index(0.0), Moves().drives.index(0.0))
TRAINED = [name for name in ROBOTS if name in AGENTS]
MOST_MB = 5.0


def world(task: str = "Explore", robots: int = 2, **keywords: Any) -> Any:
    made = gym.make_vec(
        f"CogMap/{task}-v0",
        num_envs=robots,
        **({"map": "two_rooms", "autoreset_mode": "SameStep", "max_moves": 7} | keywords),
    )
    return made.unwrapped


def learning(task: str = "Explore", **keywords: Any) -> LearningEnv:
    env = LearningEnv(world(task, **keywords), SMALL, 7, explore_weight=1.0)
    env.seed(5)
    return env


def choices(seed: int, robots: int = 2) -> NDArray[np.int64]:
    return np.random.default_rng(seed).integers(SMALL.moves.counts, size=(robots, 2))


@pytest.fixture(params=[SMALL, RECURRENT], ids=["plain", "recurrent"])
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    torch.manual_seed(0)
    return export(tmp_path / "w.safetensors", build(request.param), request.param)


def played(agent: LearnedAgent, steps: int = 12, extra: Any = None) -> NDArray[np.float32]:
    env = gym.make("CogMap/GoHome-v0", map="two_rooms")
    observation, _ = env.reset(seed=3)
    agent.reset(env.get_wrapper_attr("robot"), env.get_wrapper_attr("laser"))
    actions = []
    for _ in range(steps):
        given = copy.deepcopy(observation)
        actions.append(agent.act(extra(given) if extra else given))
        observation, *_ = env.step(actions[-1])
    return np.array(actions)


def test_training_and_robot_perceive_the_same_across_the_ends_of_episodes() -> None:
    env, plain = learning(), world()
    observation, _ = plain.reset(seed=5)
    eyes = [Perception(1, plain.robot, plain.laser, SMALL.percepts) for _ in range(2)]

    def seen(observations: Any, row: int) -> Any:
        return eyes[row].perceive(0, {key: value[row] for key, value in observations.items()})

    percepts, ends = env.reset(), 0
    assert np.array_equal(percepts, [seen(observation, row) for row in range(2)])
    for step in range(20):
        chosen = choices(step)
        actions = [action_of(c, None, SMALL.moves, plain.robot) for c in chosen.tolist()]
        percepts, _, done, infos = env.step(chosen)
        observation, _, terminated, truncated, info = plain.step(np.array(actions))
        assert np.array_equal(done, terminated | truncated)
        for row in range(2):
            if done[row]:
                last = eyes[row].perceive(0, info["final_obs"][row])
                assert np.array_equal(infos[row]["terminal_observation"], last)
                assert infos[row]["TimeLimit.truncated"] == (truncated[row] and not terminated[row])
                eyes[row].forget(0)
                ends += 1
            assert np.array_equal(percepts[row], seen(observation, row))
    assert ends >= 4


def test_a_limit_is_told_from_an_end() -> None:
    cut = learning(max_moves=3)
    cut.reset()
    infos = [cut.step(np.array([STAND, STAND]))[3] for _ in range(3)][-1]
    assert [info["TimeLimit.truncated"] for info in infos] == [True, True]
    ended = learning("GoHome", max_moves=200)
    ended.reset()
    for _ in range(200):
        _, rewards, done, infos = ended.step(np.array([STAND, STAND]))
        if done.any():
            break
    row = int(np.argmax(done))
    assert not infos[row]["TimeLimit.truncated"]
    assert infos[row]["is_success"], "who stands at home and is called home declares there"
    assert rewards[row] > 9.0


def test_area_holds_the_share_that_was_seen_last() -> None:
    env = LearningEnv(world(max_moves=3), SMALL, most_moves=6)
    env.reset()
    infos = [env.step(np.array([STAND, STAND]))[3] for _ in range(3)][-1]
    single = gym.make("CogMap/Explore-v0", map="two_rooms")
    _, info = single.reset(seed=0)
    assert infos[0]["area"] == pytest.approx(info["coverage"], abs=5e-3)


def test_joined_environments_do_what_they_do_alone() -> None:
    alone = [learning(), learning("GoHome")]
    alone[1].seed(7)
    joined = Joined({"explore": learning(), "home": learning("GoHome")})
    joined.seed(5)
    first = joined.reset()
    assert np.array_equal(first, np.concatenate([env.reset() for env in alone]))
    for step in range(10):
        chosen = choices(step, 4)
        steps = [env.step(own) for env, own in zip(alone, np.split(chosen, 2), strict=True)]
        percepts, rewards, done, infos = joined.step(chosen)
        assert np.array_equal(percepts, np.concatenate([one[0] for one in steps]))
        assert np.array_equal(rewards, np.concatenate([one[1] for one in steps]))
        assert np.array_equal(done, np.concatenate([one[2] for one in steps]))
    assert [info["task"] for info in infos] == ["explore"] * 2 + ["home"] * 2


def test_nobody_cannot_learn() -> None:
    with pytest.raises(ValueError, match="expected robots that learn, got none"):
        Joined({})


@pytest.mark.parametrize(
    ("keywords", "said"),
    [({"autoreset_mode": "NextStep"}, "autoreset_mode"), ({"control": "velocity"}, "control")],
)
def test_a_world_that_resets_or_moves_otherwise_is_refused(
    keywords: dict[str, str], said: str
) -> None:
    with pytest.raises(ValueError, match=f"LearningEnv: {said}: expected"):
        learning(**keywords)


def test_what_is_behind_a_wall_is_unknown_and_what_was_seen_is_remembered() -> None:
    numbers, laser = Percepts(), LaserSpec()
    eyes = Perception(1, RobotSpec(), laser, numbers)
    at_wall = 4.0 / np.maximum(np.cos(laser.angles), 1e-9)
    scan = np.minimum(at_wall, 6.0).astype(np.float32)
    still = {"scan": scan, "odometry": np.zeros(3), "bump": 0, "mark": 1, "goal": 0}
    begin = numbers.sectors
    ahead, behind = begin, begin + numbers.directions // 2
    assert eyes.known_bytes(0) == 0
    first = eyes.perceive(0, still)
    assert 16 * 12 < eyes.known_bytes(0) < 2 * 18 * 50
    assert first[ahead] * numbers.reach == pytest.approx(4.0, abs=numbers.cell)
    assert first[ahead + numbers.directions] == 1.0, "nothing is unknown before the wall"
    assert first[behind + numbers.directions] <= 2 * numbers.cell / numbers.reach
    turned = {**still, "odometry": np.array((-1.0, 0.0, np.pi)), "mark": 0, "goal": 1}
    turned["scan"] = np.full(laser.beams, laser.range_max, dtype=np.float32)
    second = eyes.perceive(0, turned)
    assert second[behind] * numbers.reach == pytest.approx(5.0, abs=numbers.cell)
    goal = (1.0, 2.0 / 3.0, -1.0, 0.0)
    assert second[-4:] == pytest.approx(goal, abs=1e-6), "the goal is 1 m behind"


def test_a_mark_that_is_believed_near_is_declared() -> None:
    robot, moves = RobotSpec(), Moves()
    assert np.array_equal(action_of((0, 3), (0.4, 1.0), moves, robot), robot.declare())
    free = action_of((0, 3), (0.6, 1.0), moves, robot)
    assert np.array_equal(free, robot.move(np.radians(-30.0), 1.0))
    assert np.array_equal(action_of((0, 3), None, moves, robot), free)


def test_a_seed_gives_the_same_moves_and_another_seed_others(path: Path) -> None:
    moves = played(LearnedAgent(path, 1))
    assert np.array_equal(moves, played(LearnedAgent(path, 1)))
    assert not np.array_equal(moves, played(LearnedAgent(path, 2)))


def test_a_cold_robot_makes_its_likeliest_move(path: Path) -> None:
    network, config = load(path)
    cold = replace(config, moves=replace(config.moves, temperature=1e-9))
    agents = [LearnedAgent(export(path, network, cold), seed) for seed in (1, 2)]
    assert np.array_equal(*(played(agent) for agent in agents))


def test_a_robot_asks_for_nothing_but_what_robots_get(path: Path) -> None:
    class Poisoned(dict[str, Any]):
        def __getitem__(self, key: str) -> Any:
            assert key in ("scan", "odometry", "bump", "mark", "goal"), f"{key} is not for robots"
            return super().__getitem__(key)

    def poisoned(observation: dict[str, Any]) -> dict[str, Any]:
        return Poisoned(observation, pose=np.zeros(3), info={"pose": np.zeros(3)})

    moves = played(LearnedAgent(path, 1), extra=poisoned)
    assert np.array_equal(moves, played(LearnedAgent(path, 1)))


def test_a_scan_of_another_laser_is_refused(path: Path) -> None:
    agent = LearnedAgent(path)
    bad = {"scan": np.ones(90), "odometry": np.zeros(3), "bump": 0, "mark": 0, "goal": 0}
    with pytest.raises(ValueError, match=r"observation: scan: expected 360 beams, got \(90,\)"):
        agent.act(bad)
    with pytest.raises(ValueError, match="laser: expected 36 beams at least, got 20"):
        agent.reset(RobotSpec(), LaserSpec(beams=20))
    with pytest.raises(ValueError, match="expected control 'move', got 'velocity'"):
        agent.reset(RobotSpec(control="velocity"), LaserSpec())


def test_a_recurrent_network_remembers() -> None:
    torch.manual_seed(0)
    network, shown = build(RECURRENT), torch.ones(1, RECURRENT.percepts.size)
    blank = torch.zeros(1, 1, 8), torch.zeros(1, 1, 8)
    _, first = network.get_distribution(shown, blank, torch.zeros(1))
    _, second = network.get_distribution(shown, first, torch.zeros(1))
    assert not torch.equal(first[0], second[0])
    _, begun = network.get_distribution(shown, first, torch.ones(1))
    assert torch.equal(begun[0], first[0]), "a new episode begins with a blank memory"


def test_weights_come_back_as_they_were_written(path: Path) -> None:
    network, config = load(path)
    again, _ = load(export(path.with_name("again.safetensors"), network, config))
    for one, other in zip(network.parameters(), again.parameters(), strict=True):
        assert torch.equal(one, other)


def test_a_pickle_is_not_run(tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> Any:
            return (tmp_path / "run").touch, ()

    torch.save({"weights": Bomb()}, tmp_path / "bomb.safetensors")
    with pytest.raises(ValueError, match=r"bomb.safetensors: no safetensors"):
        load(tmp_path / "bomb.safetensors")
    assert not (tmp_path / "run").exists()


def test_a_file_of_other_weights_is_refused_by_name(tmp_path: Path) -> None:
    arrays = dict(build(SMALL).named_parameters())
    told = {KEY: json.dumps(SMALL.to_dict())}
    other = SMALL.to_dict() | {"network": {"shared": 9, "heads": 8, "lstm": 0}}
    cases = {
        "config: expected it in the metadata": (arrays, None),
        "config: expected JSON": (arrays, {KEY: "{"}),
        "config: expected the parts": (arrays, {KEY: "{}"}),
        "config: .*cell": (arrays, {KEY: told[KEY].replace('"cell": 0.25', '"cell": 0.0')}),
        "config: .*unexpected": (arrays, {KEY: told[KEY].replace('"cell"', '"cells"')}),
        "weights do not fit": (arrays, {KEY: json.dumps(other)}),
    }
    for said, (given, metadata) in cases.items():
        file = tmp_path / "bad.safetensors"
        safetensors.torch.save_file({k: v.detach() for k, v in given.items()}, file, metadata)
        with pytest.raises(ValueError, match=f"bad.safetensors: {said}"):
            load(file)
    with pytest.raises(FileNotFoundError, match=r"none.safetensors: no weights"):
        load(tmp_path / "none.safetensors")


@pytest.mark.parametrize("name", TRAINED)
def test_the_weights_of_the_package_are_small_and_have_their_card(name: str) -> None:
    file = path_of(name)
    assert isinstance(make_agent(name), LearnedAgent)
    assert file.stat().st_size < MOST_MB * 1e6
    card = json.loads(file.with_suffix(".json").read_text())
    _, config = load(file)
    assert Config.of(card["config"], "card") == config
    assert bool(config.network.lstm) == (name == "recurrent_ppo")
    assert card["args"]["first_office"] >= 1000
    low = card["test"][name]["area"][1]
    assert low > card["test"]["random_walk"]["area"][2], "intervals on the test offices part"
    assert file.with_suffix(".md").read_text().startswith(f"# {name}\n")


def test_a_card_tells_what_was_compared(path: Path, tmp_path: Path) -> None:
    plan = FloorPlan.load("two_rooms")
    result = Result("random_walk", 0, 0, *run(RandomWalkAgent(0), plan, 0))
    told = summary([result, result])["random_walk"]
    assert told["area"][0] == result.area
    assert 0.0 < result.distance_area <= result.coverage <= 1.0
    args = {"explorers": 1, "homers": 0, "first_office": 1000, "odometry": "medium", "seed": 0}
    curve = [{"steps": float(k), "minutes": 1.0, "explore/area": 0.5} for k in range(200)]
    written, page = write_card(path, args, SMALL.to_dict(), curve, [result])
    card = json.loads(written.read_text())
    assert card["curve"][-1]["steps"] == 199.0
    assert len(card["curve"]) <= 52
    assert "199" in page.read_text()


@pytest.mark.slow
@pytest.mark.parametrize("name", TRAINED)
def test_ppo_explores_better_than_the_random_walk_with_intervals_apart(name: str) -> None:
    told = summary(list(compare(name, path_of(name), 2, range(1900, 1904))))
    for score in ("area", "distance_area"):
        assert told[name][score][1] > told["random_walk"][score][2]


@pytest.mark.slow
def test_a_learned_robot_finds_the_door_of_two_rooms() -> None:
    env = gym.make("CogMap/Explore-v0", map="two_rooms")
    assert run_episode(env, LearnedAgent(path_of("ppo")), 0).is_success
