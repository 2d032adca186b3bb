"""What the frontier robot promises, measured: how much it sees, how well it knows where it is.

Over many offices, from Python::

    from agents.rival_trials import explore_all
    for office in range(1000, 1100):
        trial = explore_all("frontier_oracle", f"office:{office}")
        print(office, trial.coverage, trial.moves, trial.path_length)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

import cogmap_gym  # noqa: F401 - registers the environments
from agents.frontier import FrontierAgent
from agents.registry import make_agent, wrap
from agents.rollout import Episode, run_episode
from cogmap_gym.geometry import Array, Pose
from cogmap_gym.metrics import dead_reckoning


@dataclass(frozen=True, slots=True, eq=False)
class Exploration:
    """How an exploration went that does not stop at 95 %."""

    coverage: float
    """True share of the reachable free space that was seen."""
    complete: bool
    """Whether the robot found nothing more to explore."""
    moves: int
    """How many it made."""
    path_length: float
    """How far it truly went [m]."""
    errors: Array
    """How far the believed position was off at each step, at that step, (T,) [m]."""
    final_errors: Array
    """The same of the path as believed at the end, (T,) [m]."""
    odometry_errors: Array
    """The same of the measured motions alone, (T,) [m]."""


def explore_all(
    name: str, plan: str, seed: int = 0, odometry: str = "medium", most: int | None = None
) -> Exploration:
    """Explore until the robot says that all is known, or the moves of ``Explore`` are over.

    Args:
        name: of a frontier robot.
        plan: keyword ``map`` of the environment.
        seed: of the episode.
        odometry: name of a level.
        most: moves, if not as many as ``Explore`` grants.
    """
    # Past the end of the task the world goes on; only the checks of gym.make are in the way.
    world: Any = gym.make("CogMap/Explore-v0", map=plan, odometry=odometry).unwrapped
    env, agent = wrap(name, world), make_agent(name)
    assert isinstance(agent, FrontierAgent), f"{name} is no frontier robot"
    observation, info = env.reset(seed=seed)
    agent.reset(world.robot, world.laser)
    true, believed, motions = [], [], []
    for _ in range(most or world.max_moves):
        action = agent.act(observation)
        true.append(info["pose"])
        believed.append(agent.pose.position)
        motions.append(observation["odometry"])
        if agent.status == "all known":
            break
        observation, _, _, _, info = env.step(action)
    poses = np.array(true)
    final = np.array([pose.position for pose in agent.source.poses])
    reckoned = dead_reckoning(motions)[:, :2]
    paths = (np.array(believed), final, reckoned)
    return Exploration(
        float(info["coverage"]),
        agent.status == "all known",
        len(true) - 1,
        float(info["path_length"]),
        *(_errors(poses, path) for path in paths),
    )


def reach_goals(
    name: str, env_id: str, plan: str, seed: int = 0, odometry: str = "medium", **keywords: Any
) -> Episode:
    """One episode of any robot in any task."""
    env = gym.make(env_id, map=plan, odometry=odometry, **keywords)
    return run_episode(wrap(name, env), make_agent(name), seed)


def _errors(true: Array, believed: Array) -> Array:
    """How far believed positions (T, 2), in the frame of the first pose, are off, (T,) [m]."""
    plan_from_start = Pose(*(float(v) for v in true[0]))
    return np.asarray(np.hypot(*(plan_from_start.apply(believed) - true[:, :2]).T))
