"""A learned robot: percepts go through a network, and a move is drawn from its answer."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from agents.ppo.loading import load
from agents.ppo.memory_kernel import Floats
from agents.ppo.moving import action_of
from agents.ppo.perception import Perception
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec

State = tuple[torch.Tensor, torch.Tensor]
"""What an LSTM remembers."""


class LearnedAgent:
    """A robot trained by PPO, behind the agent protocol.

    Args:
        path: of its weights.
        seed: of its draws; each ``reset`` begins the same draws anew.

    Raises:
        FileNotFoundError: there are no such weights.
        ValueError: the file is no file of weights.
    """

    def __init__(self, path: Path, seed: int = 0) -> None:
        """Load the weights."""
        self._network, self.config = load(path)
        self.params = self.config, sha256(path.read_bytes()).hexdigest()
        """What a row of results tells apart: all sizes, and the weights."""
        self._seed = seed
        self.reset(RobotSpec(), LaserSpec())

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing.

        Raises:
            ValueError: another control than by moves, or too few beams.
        """
        if robot.control != "move":
            raise ValueError(f"learned robot: expected control 'move', got {robot.control!r}")
        self.robot = robot
        self.rng = np.random.default_rng(self._seed)
        self.perception = Perception(1, robot, laser, self.config.percepts)
        self._state = self._blank()
        self.goal = 0

    @property
    def map_bytes(self) -> int:
        """Bytes of what it remembers of the office."""
        return self.perception.known_bytes(0)

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Perceive, ask the network, and draw a move."""
        percepts = self.perception.perceive(0, observation)
        choice, self._state = self._choose(percepts)
        self.goal = int(observation["goal"])
        way = self.perception.to_goal(0, self.goal)
        return action_of(choice, way, self.config.moves, self.robot)

    def sketch(self) -> dict[str, Any]:
        """Where it believes to be, and the marks."""
        pose, marks = self.perception.pose(0), self.perception.marks(0)
        given = {k: p.tolist() for k, p in enumerate(marks) if not np.isnan(p[0])}
        return {
            "surfaces": [],
            "exits": [],
            "asrs": [],
            "links": [],
            "here": 0,
            "pose": [pose.x, pose.y, pose.theta],
            "home": given.get(1),
            "marks": [{"id": k, "point": point} for k, point in given.items()],
            "route": None,
            "status": "going to a mark" if self.goal in given else "exploring",
        }

    def _choose(self, percepts: Floats) -> tuple[list[int], State | None]:
        """Which turn and which drive, and what the network remembers from now on."""
        shown = torch.from_numpy(percepts[None])
        with torch.no_grad():
            if self._state is None:
                answer, state = self._network.get_distribution(shown), None
            else:
                same_life = torch.zeros(1)
                answer, state = self._network.get_distribution(shown, self._state, same_life)
        chances = [one.logits[0].double().numpy() for one in answer.distribution]
        return [self._drawn(logarithms) for logarithms in chances], state

    def _drawn(self, logarithms: NDArray[np.float64]) -> int:
        """One of some choices, given the logarithms of their chances."""
        odds = np.exp((logarithms - logarithms.max()) / self.config.moves.temperature)
        return int(self.rng.choice(len(odds), p=odds / odds.sum()))

    def _blank(self) -> State | None:
        """An empty memory of the network, or none."""
        width = self.config.network.lstm
        return (torch.zeros(1, 1, width), torch.zeros(1, 1, width)) if width else None
