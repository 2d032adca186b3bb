"""The vector environment: Gymnasium's laws, and agreement with the single environment."""

from __future__ import annotations

import json
import math
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode

import cogmap_gym
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.vector import CogMapVectorEnv
from cogmap_gym.vector_tables import MOVE
from cogmap_gym.world import World
from tests.rooms import ring_of_four, thin_rooms

CASES = [
    *(
        (name, control, {"map": ["thesis_office", "two_rooms"]})
        for name in ("Explore", "GoHome", "GoTo")
        for control in ("move", "velocity")
    ),
    *(("Shortcut", control, {"unreachable": 0.3}) for control in ("move", "velocity")),
    *(
        ("Thesis", control, {"experiment": number})
        for control in ("move", "velocity")
        for number in (1, 2, 3)
    ),
]
EACH = pytest.mark.parametrize(("name", "control", "keywords"), CASES)
Step = tuple[dict[str, Any], Any, Any, Any, dict[str, Any]]


def made(name: str, count: int, **keywords: Any) -> CogMapVectorEnv:
    return gym.make_vec(f"CogMap/{name}-v0", num_envs=count, **keywords).unwrapped


def actions(steps: int, count: int, declare: float = 0.02) -> np.ndarray:
    """Random walks that now and then declare; those of the first robots whatever the count."""
    rng = np.random.default_rng(5)
    drawn = rng.uniform(-1.0, 1.0, (steps, 16, 3))
    drawn[:, :, 2] = np.where(rng.random((steps, 16)) < declare, 1.0, -1.0)
    return drawn[:, :count].astype(np.float32)


def walk(env: CogMapVectorEnv, seed: int, moves: np.ndarray) -> list[Step]:
    observation, info = env.reset(seed=seed)
    none = np.zeros(env.num_envs)
    steps: list[Step] = [(observation, none, none, none, info)]
    steps += [env.step(action) for action in moves]
    return steps


def row(value: Any, k: int) -> Any:
    """What is robot k's of anything that a vector environment answers, as text."""
    if isinstance(value, dict):
        return {key: row(item, k) for key, item in sorted(value.items())}
    if isinstance(value, tuple):
        return tuple(row(item, k) for item in value)
    part = value[k]
    return part.tobytes() if isinstance(part, np.ndarray) else repr(part)


@EACH
def test_what_it_gives_is_in_its_spaces_and_nothing_is_nan(
    name: str, control: str, keywords: dict[str, Any]
) -> None:
    env = made(name, 3, control=control, max_moves=25, **keywords)
    single = gym.make(f"CogMap/{name}-v0", control=control, **{**keywords, "map": "thesis_office"})
    assert env.single_observation_space == single.observation_space
    assert env.single_action_space == single.action_space
    _, told = single.reset(seed=1000)
    ends = 0
    for observation, reward, terminated, truncated, info in walk(env, 1000, actions(60, 3)):
        assert env.observation_space.contains(observation)
        assert np.isfinite(reward).all()
        assert set(info) == {*told, *(f"_{key}" for key in told)}
        for key, value in told.items():
            assert info[f"_{key}"].all()
            assert type(info[key][0].item() if key != "events" and np.ndim(value) == 0
                        and key != "room" else value) is type(value)  # fmt: skip
        for key in ("pose", "coverage", "path_length", *cogmap_gym.scores.SCORES):
            assert np.isfinite(info[key]).all()
        ends += int(terminated.sum() + truncated.sum())
    assert ends >= 6


@EACH
def test_a_robot_does_alone_what_it_does_among_others(
    name: str, control: str, keywords: dict[str, Any]
) -> None:
    maps = keywords.get("map", ["thesis_office"])
    moves = actions(60, 4, declare=0.1)
    many = walk(made(name, 4, control=control, max_moves=40, **keywords), 1000, moves)
    for k in (1, 2):
        own = {**keywords, "map": maps[k % len(maps)]}
        alone = walk(
            made(name, 1, control=control, max_moves=40, **own), 1000 + k, moves[:, k : k + 1]
        )
        for step, other in zip(many, alone, strict=True):
            assert row(step, k) == row(other, 0)


@EACH
def test_it_judges_as_the_single_environment_does(
    name: str, control: str, keywords: dict[str, Any]
) -> None:
    """Without noise both make the same moves: all that is told must be the same."""
    quiet = {"odometry": "perfect", "laser": LaserSpec(sd=0.0)}
    maps = keywords.get("map", ["thesis_office"])
    own = {**keywords, "map": maps[0], **quiet}
    single = gym.make(f"CogMap/{name}-v0", control=control, **own).unwrapped
    steps = iter(walk(made(name, 1, control=control, **own), 1003, actions(120, 1)))
    observation, _, _, _, info = next(steps)
    wanted: tuple[Any, ...] = single.reset(seed=1003)
    assert_alike(observation, wanted[0], info, wanted[1])
    for action, step in zip(actions(120, 1), steps, strict=True):
        wanted = single.step(action[0])
        assert_alike(step[0], wanted[0], step[4], wanted[4])
        assert step[1][0] == pytest.approx(wanted[1], abs=2e-3)
        assert (step[2][0], step[3][0]) == wanted[2:4]
        if wanted[2]:
            break


def assert_alike(
    ours: dict[str, Any], theirs: dict[str, Any], info: dict[str, Any], told: dict[str, Any]
) -> None:
    for key in ("bump", "mark", "goal"):
        assert ours[key][0] == theirs[key]
    assert ours["odometry"][0] == pytest.approx(theirs["odometry"], abs=1e-5)
    assert np.abs(ours["scan"][0] - theirs["scan"]).mean() < 1e-3
    for key in ("room", "phase", "events", "is_success"):
        assert info[key][0] == told[key]
    for key in ("pose", "coverage", "path_length", *cogmap_gym.scores.SCORES):
        assert info[key][0] == pytest.approx(told[key], abs=2e-3)


def test_the_bits_do_not_depend_on_the_number_of_threads() -> None:
    moves = actions(80, 16)
    walks = [
        walk(made("GoTo", 16, map=["two_rooms", "thesis_office"], threads=n), 1000, moves)
        for n in (1, 2, 5)
    ]
    for steps in zip(*walks, strict=True):
        for k in range(16):
            assert row(steps[0], k) == row(steps[1], k) == row(steps[2], k)


def test_resets_differ_and_a_seed_brings_the_first_one_back() -> None:
    env = made("Explore", 3, map="two_rooms")
    first, second, again = env.reset(seed=1003)[0], env.reset()[0], env.reset(seed=1003)[0]
    assert (first["scan"] != second["scan"]).any(axis=1).all()
    assert (first["scan"] == again["scan"]).all()
    assert (first["scan"][0] != first["scan"][1]).any()
    assert (env.reset(seed=[1004, None, 1003])[0]["scan"][2] == first["scan"][0]).all()


def test_no_array_is_handed_out_twice() -> None:
    moves = actions(30, 2)
    kept = walk(made("GoHome", 2, map="two_rooms"), 1000, moves)
    texts = [[row(step, k) for k in (0, 1)] for step in kept]
    env = made("GoHome", 2, map="two_rooms")
    env.reset(seed=1000)
    for action, text in zip(moves, texts[1:], strict=True):
        step = env.step(action)
        assert [row(step, k) for k in (0, 1)] == text
        for value in (*step[0].values(), *step[1:4], *step[4].values()):
            value[:] = 0 if value.dtype != object else None


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_episodes_begin_anew_as_the_mode_says(mode: AutoresetMode) -> None:
    """The same as Gymnasium's own vector of the same environments, flags and keys."""
    env = made("Explore", 2, map="two_rooms", max_moves=3, autoreset_mode=mode.value)
    assert env.metadata["autoreset_mode"] is mode
    sync = gym.make_vec(
        "CogMap/Explore-v0", num_envs=2, vectorization_mode="sync", map="two_rooms", max_moves=3,
        vector_kwargs={"autoreset_mode": mode},
    )  # fmt: skip
    env.reset(seed=1000), sync.reset(seed=1000)
    for action in actions(10, 2):
        ours, theirs = env.step(action), sync.step(action)
        for k in (2, 3):
            assert (ours[k] == theirs[k]).all()
        assert ours[1] == pytest.approx(theirs[1], abs=2e-3)
        assert set(ours[4]) == set(theirs[4])
        assert ours[4]["path_length"] == pytest.approx(theirs[4]["path_length"], abs=1e-6)
        if "final_info" in ours[4]:
            final, wanted = ours[4]["final_info"], theirs[4]["final_info"]
            assert set(final) == set(wanted)
            assert final["pose"] == pytest.approx(wanted["pose"], abs=1e-6)
            assert (ours[4]["_final_obs"] == theirs[4]["_final_obs"]).all()
            assert env.single_observation_space.contains(ours[4]["final_obs"][0])
            assert (ours[0]["mark"] == 1).all()
        if mode is AutoresetMode.DISABLED and ours[3].any():
            with pytest.raises(ValueError, match="reset_mask"):
                env.step(action)
            mask = {"reset_mask": np.array((True, True))}
            env.reset(options=dict(mask)), sync.reset(options=dict(mask))


def test_a_mask_resets_some_robots_and_leaves_the_others() -> None:
    env = made("Explore", 3, map="two_rooms", max_moves=2, autoreset_mode="Disabled")
    walk(env, 1000, actions(1, 3))
    last = env.step(actions(2, 3)[1])
    mask = np.array((True, False, True))
    observation, info = env.reset(options={"reset_mask": mask})
    assert (info["_pose"] == mask).all()
    assert (info["path_length"] > 0.0).tolist() == [False, True, False]
    assert (observation["scan"][1] == last[0]["scan"][1]).all()
    assert observation["mark"].tolist() == [1, 0, 1]
    with pytest.raises(ValueError, match=r"\[1\]"):
        env.step(actions(1, 3)[0])


def test_home_can_be_moved_for_one_episode() -> None:
    env = made("GoHome", 2, map="two_rooms")
    _, info = env.reset(seed=1000, options={"home": [6.0, 3.0, 90.0]})
    assert info["pose"] == pytest.approx(np.array([[6.0, 3.0, math.pi / 2]] * 2))
    assert info["room"].tolist() == ["R2", "R2"]
    for options in ({"home": [0.0, 0.0, 0.0]}, {"home": [1.0]}, {"house": 1}):
        with pytest.raises(ValueError, match=r"home|place"):
            env.reset(options=options)
    assert env.reset()[1]["room"].tolist() == ["R1", "R1"]


@pytest.mark.parametrize(
    ("keywords", "told"),
    [
        ({"dynamics": "busy"}, "dynamics"),
        ({"render_mode": "rgb_array"}, "render_mode"),
        ({"num_envs": 0}, "num_envs"),
        ({"threads": 0}, "threads"),
        ({"autoreset_mode": "Never"}, "autoreset_mode"),
        ({"map": []}, "map"),
        ({"map": ["two_rooms", "nowhere"], "num_envs": 2}, "nowhere"),
        ({"control": "fly"}, "control"),
        ({"max_moves": 0}, "max_moves"),
        ({"task": "shortcut"}, "chords"),
    ],
)
def test_a_bad_keyword_is_refused_by_name(keywords: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        CogMapVectorEnv(**{"map": "two_rooms", **keywords})


def test_bad_actions_and_a_step_before_the_first_reset_are_refused() -> None:
    env = made("Explore", 2, map="two_rooms")
    with pytest.raises(ResetNeeded):
        env.step(np.zeros((2, 3)))
    env.reset(seed=1000)
    for bad in (np.zeros(3), np.zeros((3, 3)), np.full((2, 3), np.nan)):
        with pytest.raises(ValueError, match="actions"):
            env.step(bad)


def test_the_spec_survives_json_and_makes_the_same_robots() -> None:
    keywords = {"map": ["two_rooms", ring_of_four()], "laser": LaserSpec(beams=30, step=0.1)}
    env = gym.make_vec("CogMap/GoTo-v0", num_envs=2, autoreset_mode="SameStep", **keywords)
    json.dumps(env.spec.kwargs)
    twin = gym.make_vec(EnvSpec.from_json(env.spec.to_json()))
    for ours, theirs in zip(
        walk(env, 1000, actions(20, 2)), walk(twin, 1000, actions(20, 2)), strict=True
    ):
        assert row(ours, 1) == row(theirs, 1)


def test_a_copy_goes_on_with_the_same_bits() -> None:
    env = made("GoTo", 3, map="thesis_office", threads=2)
    walk(env, 1000, actions(20, 3))
    twin = pickle.loads(pickle.dumps(env))
    for action in actions(40, 3):
        ours, theirs = env.step(action), twin.step(action)
        assert [row(ours, k) for k in range(3)] == [row(theirs, k) for k in range(3)]
    env.close(), env.close()


def test_every_map_is_loaded_once_and_given_out_in_turn() -> None:
    env = made("Explore", 5, map=["two_rooms", thin_rooms()])
    _, info = env.reset(seed=1000)
    assert info["pose"][0] == pytest.approx(info["pose"][2])
    assert info["pose"][1] == pytest.approx(info["pose"][3])


@pytest.mark.slow
def test_many_offices_are_made_side_by_side() -> None:
    names = [f"office:{seed}" for seed in range(1000, 1016)]
    env = made("Explore", 16, map=names)
    few = made("Explore", 2, map=names[:2])
    ours, theirs = walk(env, 1000, actions(5, 16)), walk(few, 1000, actions(5, 2))
    for step, other in zip(ours, theirs, strict=True):
        assert row(step, 1) == row(other, 1)


@pytest.mark.parametrize("control", ["move", "velocity"])
@pytest.mark.parametrize("plan", ["thesis_office", "office:1001"])
def test_one_move_from_the_same_state_agrees_with_the_pymunk_world(plan: str, control: str) -> None:
    """Positions within 1 cm, headings within 0.2 degrees, contact in 99.9 % and more."""
    count, rounds = 64, 40
    env = made("Explore", count, map=plan, control=control)
    env.reset(seed=1000)
    fleet, modes = env._fleet, np.full(count, MOVE)
    world, rng = World(fleet.sites[0].plan, RobotSpec(control=control)), np.random.default_rng(7)
    unlike = bumps = 0
    for _ in range(rounds):
        poses = [standing(world, rng) for _ in range(count)]
        robots = fleet.robots
        robots["x"], robots["y"], robots["theta"] = np.array(poses).T
        moves = rng.uniform(-1.0, 1.0, (count, 3))
        moves[rng.random(count) < 0.3, int(control == "move")] = 1.0
        fleet.step(modes, moves)
        for pose, move, robot in zip(poses, moves, robots, strict=True):
            world._body.pose = Pose(*pose)
            motion = driven(world, move)
            unlike += bool(robot["bump"]) != motion.bump
            bumps += motion.bump
            assert (robot["x"], robot["y"]) == pytest.approx(world.pose.position, abs=0.01)
            turned = math.remainder(robot["theta"] - world.pose.theta, math.tau)
            assert abs(turned) < math.radians(0.2)
    assert unlike <= 0.001 * count * rounds
    assert bumps > 50


def standing(world: World, rng: np.random.Generator) -> tuple[float, float, float]:
    """A random pose, half of them near something."""
    low, high = world.fixed_segments.min(axis=(0, 1)), world.fixed_segments.max(axis=(0, 1))
    widest = rng.choice((0.35, 3.0))
    while True:
        x, y = rng.uniform(low, high)
        gap = point_segment_distances(np.array([[x, y]]), world.solid_segments).min()
        if 0.25 < gap < widest:
            return float(x), float(y), float(rng.uniform(-math.pi, math.pi))


def driven(world: World, action: np.ndarray) -> Any:
    robot = world.robot
    if robot.control == "move":
        forward = robot.max_forward * (action[1] + 1.0) / 2.0
        return world.move(action[0] * robot.max_turn, forward)
    return world.drive(action[0] * robot.max_speed, action[1] * robot.max_turn_rate)
