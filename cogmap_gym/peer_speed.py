"""A step of our environment beside a step of others' on the same plan, measured in one run.

The extra ``peers`` brings them. Each has the walls of the plan, a round robot that is driven by
speeds at random for 0.1 s a step, and a laser of as many beams, as far, with noise as strong.
None of theirs has a task, a reward, odometry or coverage; ours does all it always does.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cogmap_gym.env import CogMapEnv
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.vector_speed import alone_seconds, random_walks

PEERS: Mapping[str, str] = {"IR-SIM": "irsim", "navground": "navground.learning"}
"""Others' environments, and the module that each comes in."""
STEP_S = 0.1
"""A step of all of them [s]."""
STEPS, SLOW_STEPS = 400, 40
"""Steps a round of ours and navground, and of IR-SIM."""
Drive = Callable[[], float]
"""Takes the steps of a round; answers the mean time of one [s]."""


def missing_peers() -> list[str]:
    """The others that are not installed here."""
    return [name for name, module in PEERS.items() if find_spec(module.partition(".")[0]) is None]


def peer_costs(plan: FloorPlan, rounds: Iterable[int], seed: int) -> list[dict[str, object]]:
    """Microseconds that a step takes with us and with each of the others that is installed.

    Args:
        plan: where all robots are.
        rounds: in each, all take their turn.
        seed: of the random walks.

    Returns:
        A row for each: median microseconds, and the median of the rounds' ratios to ours.
    """
    ours = CogMapEnv(map=plan, control="velocity")
    ours.reset(seed=seed)
    drives: dict[str, Drive] = {"cogmap_gym": lambda: alone_seconds(ours, STEPS, seed)}
    made = {"IR-SIM": _irsim, "navground": _navground}
    drives |= {name: made[name](plan, seed) for name in PEERS if name not in missing_peers()}
    for drive in drives.values():
        drive()
    times = [{name: drive() for name, drive in drives.items()} for _ in rounds]
    return [
        {
            "environment": name,
            "step_us": 1e6 * statistics.median(t[name] for t in times),
            "times_ours": statistics.median(t[name] / t["cogmap_gym"] for t in times),
        }
        for name in drives
    ]


def _irsim(plan: FloorPlan, seed: int) -> Drive:
    """IR-SIM: every wall an obstacle, a differential drive that stops at contact."""
    import irsim

    robot, laser, home = RobotSpec(control="velocity"), LaserSpec(), plan.home
    left, low, right, high = plan.bounds
    top = [robot.max_speed, robot.max_turn_rate]
    lidar = {
        "type": "lidar2d", "range_min": 0.0, "range_max": laser.range_max, "number": laser.beams,
        "angle_range": laser.step * (laser.beams - 1), "noise": True, "std": laser.sd,
        "angle_std": 0.0,
    }  # fmt: skip
    world = {
        "world": {
            "width": right - left, "height": high - low, "offset": [left, low],
            "step_time": STEP_S, "sample_time": STEP_S, "collision_mode": "stop",
        },
        "robot": [
            {
                "kinematics": {"name": "diff"}, "state": [home.x, home.y, home.theta],
                "shape": {"name": "circle", "radius": robot.radius}, "sensors": [lidar],
                "vel_max": top, "vel_min": [-v for v in top],
            }
        ],
        "obstacle": [
            {"shape": {"name": "linestring", "vertices": wall}, "state": [0, 0, 0]}
            for wall in plan.walls_and_furniture().tolist()
        ],
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "world.yaml"
        file.write_text(yaml.safe_dump(_plain(world)))
        env = irsim.make(str(file), display=False, disable_all_plot=True, log_level="ERROR")

    def drive() -> float:
        speeds, begin = random_walks(1, seed)[:, 0, :2] * top, time.perf_counter()
        for k in range(SLOW_STEPS):
            env.step(speeds[k % len(speeds)].tolist())
            env.get_lidar_scan()
        return (time.perf_counter() - begin) / SLOW_STEPS

    return drive


def _navground(plan: FloorPlan, seed: int) -> Drive:
    """Navground's Gymnasium environment: walls, one agent on two wheels, a lidar."""
    import navground.learning.env
    from navground.learning import ControlActionConfig, DefaultObservationConfig

    robot, laser, home = RobotSpec(control="velocity"), LaserSpec(), plan.home
    speeds = {"max_speed": robot.max_speed, "max_angular_speed": robot.max_turn_rate}
    scenario = {
        "walls": [{"line": wall} for wall in plan.walls_and_furniture().tolist()],
        "groups": [
            {
                "type": "thesis", "number": 1, "radius": robot.radius, "control_period": STEP_S,
                "position": [[home.x, home.y]], "orientation": home.theta,
                "behavior": {"type": "Dummy"},
                "kinematics": {"type": "2WDiff", "wheel_axis": 1.6 * robot.radius, **speeds},
            }
        ],
    }  # fmt: skip
    sensor = {
        "type": "Lidar", "range": laser.range_max, "resolution": laser.beams,
        "start_angle": laser.first_angle, "field_of_view": laser.step * (laser.beams - 1),
        "error_std_dev": laser.sd,
    }  # fmt: skip
    env = navground.learning.env.NavgroundEnv(
        scenario=yaml.safe_dump(_plain(scenario)),
        sensor=_plain(sensor),
        action=ControlActionConfig(**speeds),
        observation=DefaultObservationConfig(include_target_direction=False),
        time_step=STEP_S,
        terminate_if_idle=False,
    )
    env.reset(seed=seed)

    def drive() -> float:
        actions, begin = random_walks(1, seed)[:, 0, :2], time.perf_counter()
        for k in range(STEPS):
            _, _, terminated, truncated, _ = env.step(actions[k % len(actions)])
            if terminated or truncated:
                env.reset()
        return (time.perf_counter() - begin) / STEPS

    return drive


def _plain(value: Any) -> Any:
    """The same with Python's own numbers, as YAML wants them."""
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    if isinstance(value, list):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value
