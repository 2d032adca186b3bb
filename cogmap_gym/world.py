"""The true world: walls and furniture, one round robot, doors and barriers.

The laser's ray caster is told of every door and barrier that changes, so that it sees
exactly the geometry that the body collides with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely.geometry import Point

from cogmap_gym.body import Body, Motion
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.observation import RobotSpec
from cogmap_gym.raycast import RayCaster


@dataclass(frozen=True, slots=True)
class WorldState:
    """All that changes in a world; with the plan and the robot it rebuilds the world."""

    pose: Pose
    shut_doors: frozenset[str]
    present_barriers: frozenset[str]


class World:
    """The truth about one robot in one floor plan.

    Args:
        plan: walls, furniture, doors, barriers; its home is the first pose.
        robot: the size and the top speeds of the body.
    """

    def __init__(self, plan: FloorPlan, robot: RobotSpec) -> None:
        """Build the space, with doors shut and barriers absent as the plan says."""
        self.plan = plan
        self.robot = robot
        names = (*plan.door_names, *plan.barrier_names)
        if len(set(names)) < len(names):
            raise ValueError(f"{plan.name}: expected no name for both a door and a barrier")
        self._rows = {name: row for row, name in enumerate(names)}
        self._fixed = plan.walls_and_furniture()
        movable = np.concatenate((plan.door_segments(), plan.barrier_segments()))
        self.movable_segments: Segments = movable
        self.caster: RayCaster = RayCaster(self._fixed, movable)
        self._body = self._new_body()
        self._shut: frozenset[str] = frozenset()
        self._present: frozenset[str] = frozenset()
        self.set_state(WorldState(plan.home, frozenset(plan.closed), frozenset()))

    @property
    def pose(self) -> Pose:
        """The true pose of the robot."""
        return self._body.pose

    @property
    def shut_doors(self) -> frozenset[str]:
        """Names of the doors that are shut."""
        return self._shut

    @property
    def present_barriers(self) -> frozenset[str]:
        """Names of the barriers that stand."""
        return self._present

    @property
    def fixed_segments(self) -> Segments:
        """Walls and furniture, (N, 2, 2)."""
        return self._fixed

    @property
    def solid_segments(self) -> Segments:
        """All that is in the way now: walls, furniture, shut doors, barriers, (N, 2, 2)."""
        rows = [self._rows[name] for name in sorted(self._shut | self._present)]
        return np.concatenate((self._fixed, self.movable_segments[rows]))

    @property
    def box_outlines(self) -> tuple[Points, ...]:
        """The corners of what can be pushed, (K, 2) each [m]; nothing in a still world."""
        return ()

    @property
    def people_outlines(self) -> tuple[Points, ...]:
        """The corners of people, (K, 2) each [m]; nobody in a still world."""
        return ()

    def segment(self, name: str) -> Segments:
        """Where a door or a barrier is when it is in the way, (1, 2, 2).

        Raises:
            ValueError: if the plan has no door or barrier of that name.
        """
        self._check_name("door or barrier", name, tuple(self._rows))
        return self.movable_segments[[self._rows[name]]]

    def place(self, pose: Pose) -> None:
        """Put the robot at ``pose``.

        Raises:
            ValueError: if the pose is not finite or the body would overlap something.
        """
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            raise ValueError(f"place: expected a finite pose, got {pose}")
        fits = self.clearance((pose.x, pose.y)) >= 0.0
        if not fits or not self.plan.free_space().covers(Point(pose.x, pose.y)):
            raise ValueError(f"place: a robot of {self.robot.radius} m does not fit at {pose}")
        self._body.pose = pose

    def clearance(self, point: tuple[float, float]) -> float:
        """Metres between a robot's body centred at ``point`` and the nearest thing."""
        return self._body.clearance(point)

    def set_door(self, name: str, shut: bool) -> None:
        """Shut or open a door.

        Raises:
            ValueError: if the plan has no such door.
        """
        self._check_name("door", name, self.plan.door_names)
        self._set_solid(name, shut)
        self._shut = self._shut | {name} if shut else self._shut - {name}

    def set_barrier(self, name: str, present: bool) -> None:
        """Place a barrier or take it away.

        Raises:
            ValueError: if the plan has no such barrier.
        """
        self._check_name("barrier", name, self.plan.barrier_names)
        self._set_solid(name, present)
        self._present = self._present | {name} if present else self._present - {name}

    def state(self) -> WorldState:
        """All that changes, to be given to ``set_state`` later."""
        return WorldState(self.pose, self._shut, self._present)

    def set_state(self, state: WorldState) -> None:
        """Go back to a state that ``state`` gave."""
        self._shut = state.shut_doors
        self._present = state.present_barriers
        for name in self._rows:
            self._set_solid(name, name in self._shut or name in self._present)
        self._body.pose = state.pose

    def move(self, turn: float, forward: float) -> Motion:
        """Turn by ``turn`` [rad] in place, then drive ``forward`` [m] or up to contact.

        The turn is exact; a free drive ends exactly ``forward`` from its start.
        """
        return self._body.move(turn, forward)

    def drive(self, v: float, omega: float) -> Motion:
        """Drive at ``v`` [m/s] turning at ``omega`` [rad/s] for one velocity step."""
        return self._body.drive(v, omega)

    def _set_solid(self, name: str, solid: bool) -> None:
        row = self._rows[name]
        self._body.set_solid(len(self._fixed) + row, solid=solid)
        self.caster.set_solid(row, solid)

    @staticmethod
    def _check_name(kind: str, name: str, known: tuple[str, ...]) -> None:
        if name not in known:
            raise ValueError(f"{kind}: expected one of {sorted(known)}, got {name!r}")

    def __getstate__(self) -> dict[str, Any]:
        """All but the physics, which cannot be pickled, and the pose in its place."""
        return {**self.__dict__, "_body": self.pose}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Build the physics anew; a body remembers nothing but its pose."""
        self.__dict__.update(state)
        self._body = self._new_body()
        self._body.pose = state["_body"]
        for row, solid in enumerate(self.caster.solid):
            self._body.set_solid(len(self._fixed) + row, solid=bool(solid))

    def _new_body(self) -> Body:
        return Body(self.robot, np.concatenate((self._fixed, self.movable_segments)))
