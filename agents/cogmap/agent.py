"""The thesis robot: it maps without a precise map, and finds its way with what it has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.bounded_space import Openings, openings
from agents.cogmap.exploration import explore
from agents.cogmap.journeys import travel
from agents.cogmap.lines import extract_view
from agents.cogmap.memory import NEWBORN, Mark, Memory, back_home
from agents.cogmap.mfis import Edit
from agents.cogmap.params import Params
from agents.cogmap.passing import leave, notice_crossing
from agents.cogmap.perception import perceive, survey
from agents.cogmap.recognition import recognise_place
from agents.cogmap.sketch import draw_sketch
from agents.cogmap.storage import memory_bytes, read_memory, write_memory
from agents.cogmap.view import View
from agents.cogmap.wandering import wander
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec


class CogMapAgent:
    """All of the thesis behind the agent protocol: observations in, moves out."""

    def __init__(self, params: Params | None = None) -> None:
        """Take the parameters; the defaults serve every map."""
        self.params = params or Params()
        self.edits: list[Edit] = []
        self.reset(RobotSpec(), LaserSpec())

    def reset(self, robot: RobotSpec, laser: LaserSpec) -> None:
        """Begin a new life with this body and this laser, remembering nothing."""
        self.robot, self.laser = robot, laser
        self.memory = NEWBORN
        self.edits = []

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """One step of the method: perceive, map, recognise, decide."""
        view = extract_view(observation["scan"], self.laser, self.params.lines)  # 3.2
        seen = openings(view, self.params.gaps, self.laser.robot_from_laser.position)  # 2
        odometry = Pose(*(float(v) for v in observation["odometry"]))
        memory, edits = perceive(self.memory, view, odometry, self.laser, self.params)  # 3, 4, 5
        crossed = notice_crossing(memory, self.params)
        if crossed is not None:
            memory = recognise_place(memory, self.params, last_chance=True)
            crossed = notice_crossing(memory, self.params) or memory.exit(crossed.id)
            memory = leave(memory, crossed, self.params)  # 6, 7, 8
        memory = survey(memory, view, seen, self.laser, self.params)
        memory = recognise_place(memory, self.params)  # closing the loop by association
        memory = _remember_mark(memory, int(observation["mark"]))
        memory, action = self._decide(memory, view, seen, int(observation["goal"]))  # 1
        fewer = len(memory.mapping.mfis) < len(self.memory.mapping.mfis)
        self.memory = memory
        self.edits.extend(edits)
        if fewer:
            kept = set(memory.mapping.mfis.ids.tolist())
            self.edits = [edit for edit in self.edits if edit.id in kept]
        return action

    def _decide(
        self, memory: Memory, view: View, seen: Openings, goal: int
    ) -> tuple[Memory, NDArray[np.float32]]:
        """Explore while there is no goal; else travel to the goal's mark."""
        mark = memory.mark(goal) if goal else None
        if mark is not None:
            return travel(memory, mark, view, self.robot, self.params)
        memory = replace(memory, route=None, journey=None, status="exploring")
        if self.params.exploration.literal:
            return memory, wander(memory, seen, self.robot, self.params)
        return explore(memory, view, self.robot, self.params)

    def sketch(self) -> dict[str, Any]:
        """What the robot believes, JSON-able, in MFIS coordinates."""
        return draw_sketch(self.memory)

    def save(self, path: str | Path) -> None:
        """Keep the memory in a file, whole or not at all."""
        write_memory(path, self.memory)

    def load(self, path: str | Path, *, at_home: bool = False) -> None:
        """Take up a memory kept by ``save``, after ``reset``; the next ``act`` goes on from it.

        Args:
            path: the file.
            at_home: whether the robot now stands again where, and as, its life began; else it
                stands where it stood when the memory was kept.

        Raises:
            ValueError: the file is no such memory; it names the file.
        """
        memory = read_memory(path)
        self.memory = back_home(memory) if at_home else memory

    @property
    def pose(self) -> Pose:
        """Where it believes to be, in the MFIS."""
        return self.memory.pose

    @property
    def place(self) -> int:
        """The id of the ASR in which it believes to be."""
        return self.memory.stay.place

    @property
    def map_bytes(self) -> int:
        """How large its memory is [bytes]."""
        return memory_bytes(self.memory)

    @property
    def edit_log(self) -> Sequence[Edit]:
        """Every change so far of the surfaces that the MFIS holds."""
        return tuple(self.edits)


def _remember_mark(memory: Memory, mark_id: int) -> Memory:
    """Keep the present spot and its ASR under this number, when there is one."""
    if mark_id == 0:
        return memory
    mark = Mark(mark_id, memory.stay.place, memory.pose.position)
    others = (m for m in memory.marks if m.id != mark_id)
    return replace(memory, marks=(*others, mark))
