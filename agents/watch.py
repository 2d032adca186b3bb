"""A robot under watch: what was true and what it believed at each step of a trial, for its scores.

A robot may tell at each step where it believes to be, in attributes that cost nothing: ``pose``, a
``Pose`` in its own frame, and ``place``, the id of the place. Who does not is not scored by it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.base import Agent
from cogmap_gym.cognitive_map_scores import bidimensional_regression, pointing_errors
from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import Observation
from cogmap_gym.place_graph import network_scores
from cogmap_gym.pose_scores import pose_scores
from cogmap_gym.tasks import HOME

MOVED_M = 0.1
"""A box or chair has been moved when its middle is so far from where it was [m]. Ours."""


class Watch:
    """Passes on what the robot gets and answers, and writes down what the scores need.

    Args:
        agent: the robot.
        env: the environment, unwrapped.
    """

    def __init__(self, agent: Agent, env: Any) -> None:
        """With nothing seen yet."""
        self._agent, self._env, self._goal = agent, env, 0
        self.seen: list[float] = []
        self.driven: list[float] = []
        self.bumps = 0
        self.seconds: list[float] = []
        self._true: list[Array] = []
        self._rooms: list[str] = []
        self._believed: list[Pose] = []
        self._places: list[int] = []
        self._pointed: list[dict[int, float]] = []
        self._doors: frozenset[str] = frozenset()
        self._changed: set[str] = set()
        self._boxes = np.zeros((0, 2))

    def reset(self, *specs: Any) -> None:
        """Begin a life."""
        self._explored()
        self._agent.reset(*specs)

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Let the robot answer, and time it."""
        begun = time.process_time()
        action = self._agent.act(observation)
        self.seconds.append(time.process_time() - begun)
        return action

    def sketch(self) -> dict[str, Any] | None:
        """What the robot believes."""
        return self._agent.sketch()

    def __call__(
        self, _step: int, observation: Observation, _action: Any, info: dict[str, Any], _agent: Any
    ) -> None:
        """Write down a step, after the robot has acted and before the world moves."""
        self.seen.append(info["coverage"])
        self.driven.append(info["path_length"])
        self.bumps += int(observation["bump"])
        self._true.append(info["pose"])
        self._rooms.append(info["room"])
        if isinstance(pose := getattr(self._agent, "pose", None), Pose):
            self._believed.append(pose)
        if (place := getattr(self._agent, "place", None)) is not None:
            self._places.append(place)
        goal = int(observation["goal"])
        if goal and goal != self._goal:
            if not self._goal:
                self._explored()
            self._point(info["pose"])
        self._goal = goal
        self._changed |= self._solid() ^ self._doors

    def _explored(self) -> None:
        """Remember how the office is now that exploring is over; at first, as it begins."""
        self._doors, self._changed, self._boxes = self._solid(), set(), self._middles()

    def _solid(self) -> frozenset[str]:
        """Doors that are shut and barriers that stand."""
        world = self._env.world
        return frozenset(world.shut_doors | world.present_barriers)

    def _middles(self) -> Points:
        return np.array([box.mean(axis=0) for box in self._env.world.box_outlines]).reshape(-1, 2)

    def _point(self, true: Array) -> None:
        """Let the robot point to all that it was told to remember."""
        sketch = self._agent.sketch()
        if sketch and sketch.get("pose"):
            believed, here = (Pose(*(float(v) for v in p)) for p in (sketch["pose"], true))
            marks = _remembered(sketch)
            self._pointed.append(pointing_errors(believed, marks, here, self._marks()))

    def _marks(self) -> dict[int, Points]:
        """Where the marks truly are."""
        return {mark: pose.position for mark, pose in self._env.task.marks.items()}

    def changes(self) -> dict[str, int]:
        """What has changed since exploring was over; without a goal, since the start."""
        apart = np.hypot(*(self._middles() - self._boxes).T)
        return {"doors_changed": len(self._changed), "boxes_moved": int((apart > MOVED_M).sum())}

    def beliefs(self) -> dict[str, float | None]:
        """Scores of what the robot believed."""
        true = np.array(self._true)
        told: dict[str, float | None] = {}
        if len(self._believed) == len(true):
            believed = np.array([(p.x, p.y, p.theta) for p in self._believed])
            told |= pose_scores(believed, true)
        sketch = self._agent.sketch()
        if sketch:
            told |= self._map_scores(sketch)
            if len(self._places) == len(true):
                plan = self._env.plan
                told |= network_scores(sketch, self._places, self._rooms, plan, true)
        return told

    def _map_scores(self, sketch: Mapping[str, Any]) -> dict[str, float | None]:
        """Scores of where the robot believes its marks to be, at the end and as it set out."""
        believed, true = _remembered(sketch), self._marks()
        both = sorted(set(believed) & set(true))
        points = (np.array([side[k] for k in both]).reshape(-1, 2) for side in (believed, true))
        found = bidimensional_regression(*points)
        home = [errors[HOME] for errors in self._pointed if HOME in errors]
        places = [e for errors in self._pointed for k, e in errors.items() if k != HOME]
        return {
            "map_scale": None if found is None else found.scale,
            "map_distortion": None if found is None else found.distortion,
            "pointing_home": _mean_degrees(home),
            "pointing_places": _mean_degrees(places),
        }


def _remembered(sketch: Mapping[str, Any]) -> dict[int, Points]:
    """Where a robot believes its marks to be, by mark."""
    return {int(m["id"]): np.array(m["point"], float)[:2] for m in sketch.get("marks") or ()}


def _mean_degrees(angles: list[float]) -> float | None:
    return float(np.degrees(np.mean(angles))) if angles else None
