"""A world in which more than the robot moves: boxes to push, people, doors on a schedule.

Time passes while the robot moves. It is cut into slices: people look about and walk, then
the robot drives on. Nobody ever walks into the robot; it may run into them.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cogmap_gym.body import Motion
from cogmap_gym.boxes import Box, PushingBody, edges
from cogmap_gym.dynamics import Dynamics
from cogmap_gym.events import Event
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose, point_segment_distances
from cogmap_gym.living_layout import drawn_boxes, drawn_people, free_spots
from cogmap_gym.moving_rays import MovingCaster
from cogmap_gym.observation import RobotSpec
from cogmap_gym.people import Person, Point, Surroundings, walk
from cogmap_gym.routes import Routes
from cogmap_gym.world import World, WorldState

SLICE_S = 0.1
"""How long people walk before they look about again, at most [s]."""
LEAST_MOVE_S = 0.5
"""Time that passes at least in a move, so that one who waits sees others pass [s]."""
NEAR_M = 1.5
"""What lies this far beyond the longest move cannot matter to it [m]."""
SHUT_S, OPEN_S = (10.0, 30.0), (15.0, 45.0)
"""Least and longest time for which a door stays shut, and all stay open [s]."""
RETRY_S = 1.0
"""When a door that could not shut is thought of again [s]."""
BESIDE_DOOR_M = 0.6
"""A door may shut by itself where one can walk from this far before it to as far behind [m]."""
CLEAR_OF_DOORS_M = 0.6
"""A door waits while somebody, or a box's corner, is nearer to it than this [m]."""


@dataclass(frozen=True, slots=True)
class Life:
    """Where all is that moves by itself or by a push."""

    boxes: tuple[Box, ...] = ()
    people: tuple[Person, ...] = ()
    shut: str = ""
    """The door that is shut for a while; empty: none."""
    change_in: float = 0.0
    """When the next door shuts or that one opens [s]."""


@dataclass(frozen=True, slots=True)
class LivingState(WorldState):
    """All that changes, and the chance that is to come."""

    life: Life = field(default_factory=Life)
    chance: Any = None
    """State of the bit generator; None: nothing is drawn yet."""


class LivingWorld(World):
    """The truth about one robot in one floor plan where things move.

    Args:
        plan: as for ``World``.
        robot: as for ``World``.
        dynamics: what moves, and how much.
    """

    def __init__(self, plan: FloorPlan, robot: RobotSpec, dynamics: Dynamics) -> None:
        """Nothing moves before ``begin``."""
        self._life, self._chance = Life(), None
        super().__init__(plan, robot)
        self.caster: MovingCaster = MovingCaster(self.fixed_segments, self.movable_segments)
        self.set_state(self.state())
        self._dynamics = dynamics
        self._spots = free_spots(self)
        self._routes = Routes(self)

    _chance: np.random.Generator | None

    @property
    def box_outlines(self) -> tuple[Points, ...]:
        """The corners of each box and chair, (K, 2) [m]."""
        return tuple(box.outline for box in self._life.boxes)

    @property
    def people_outlines(self) -> tuple[Points, ...]:
        """The corners of each person, (K, 2) [m]."""
        return tuple(person.outline for person in self._life.people)

    def begin(self, rng: np.random.Generator) -> None:
        """Fill the office anew, clear of the robot; all chance comes from ``rng``."""
        self._chance, level = rng, self._dynamics
        here = self.pose.position
        boxes = drawn_boxes(self.plan, self._spots, here, level.box_area, rng)
        people = drawn_people(self.plan, self._spots, here, boxes, level.person_area, rng)
        self._life = Life(boxes, people, "", float(rng.uniform(*OPEN_S)))
        self._show()

    def state(self) -> LivingState:
        """All that changes, to be given to ``set_state`` later."""
        chance = self._chance and copy.deepcopy(self._chance.bit_generator.state)
        there = super().state()
        return LivingState(there.pose, there.shut_doors, there.present_barriers, self._life, chance)

    def set_state(self, state: WorldState) -> None:
        """Go back to a state that ``state`` gave."""
        super().set_state(state)
        if isinstance(state, LivingState):
            self._life = state.life
            if state.chance is not None:
                assert self._chance is not None, "a state with chance comes after begin"
                self._chance = copy.deepcopy(self._chance)
                self._chance.bit_generator.state = copy.deepcopy(state.chance)
            self._show()

    def move(self, turn: float, forward: float) -> Motion:
        """Turn by ``turn`` [rad] in place, then drive ``forward`` [m] or up to contact.

        People walk meanwhile.
        """
        body, robot = self._pushing_body(), self.robot
        turning, driving = abs(turn) / robot.max_turn_rate, abs(forward) / robot.max_speed
        self._pass_time(max(turning, LEAST_MOVE_S - driving), body)
        motions = [body.move(turn, 0.0)]
        slices = math.ceil(driving / SLICE_S)
        for _ in range(slices):
            self._walk(driving / slices, body)
            motions.append(body.move(0.0, forward / slices))
            if motions[-1].bump:
                break
        return self._end(body, motions, turning + driving)

    def drive(self, v: float, omega: float) -> Motion:
        """Drive at ``v`` [m/s] turning at ``omega`` [rad/s] for one velocity step."""
        body, seconds = self._pushing_body(), self.robot.velocity_step
        self._pass_time(seconds, body)
        return self._end(body, [body.drive(v, omega)], seconds)

    def _pushing_body(self) -> PushingBody:
        """The physics of one step: made anew, so that it remembers nothing."""
        solid, here = self.solid_segments, self.pose
        gaps = point_segment_distances(here.position[None], solid)[0]
        near = solid[gaps < self.robot.max_forward + NEAR_M]
        body = PushingBody(self.robot, near, self._life.boxes, self.people_outlines)
        body.pose = here
        return body

    def _end(self, body: PushingBody, motions: Sequence[Motion], seconds: float) -> Motion:
        """Write down what the step brought about."""
        self._body.pose = body.pose
        self._life = replace(self._life, boxes=body.boxes)
        if self._dynamics.doors:
            self._tend_doors(seconds)
        self._show()
        path = [motions[0].path, *(motion.path[1:] for motion in motions[1:])]
        return Motion(
            math.fsum(motion.turned for motion in motions),
            math.fsum(motion.driven for motion in motions),
            motions[-1].bump,
            np.concatenate(path),
        )

    def _show(self) -> None:
        self.caster.moving = edges((*self.box_outlines, *self.people_outlines))

    def _pass_time(self, seconds: float, body: PushingBody) -> None:
        slices = math.ceil(seconds / SLICE_S)
        for _ in range(slices):
            self._walk(seconds / slices, body)

    def _walk(self, seconds: float, body: PushingBody) -> None:
        """Let everybody walk, one after the other."""
        people = list(self._life.people)
        if not people:
            return
        solid, boxes = self.solid_segments, edges([box.outline for box in body.boxes])
        robot = float(body.pose.x), float(body.pose.y)
        for number, person in enumerate(people):
            others = np.array([(p.at, p.at) for k, p in enumerate(people) if k != number])
            others = others.reshape(-1, 2, 2)
            about = Surroundings(robot, self.robot.radius, others, solid, boxes)
            people[number] = walk(person, seconds, about, self._new_way)
            body.set_person(number, people[number].outline)
        self._life = replace(self._life, people=tuple(people))

    def _new_way(self, start: Point) -> tuple[Point, ...]:
        """A way to some spot; empty where there is none now."""
        assert self._chance is not None, "people walk after begin"
        x, y = self._spots.points[self._chance.integers(len(self._spots.points))].tolist()
        way = self._routes.way(Pose(*start), Pose(x, y))
        return () if way is None else tuple((float(x), float(y)) for x, y in way[1:])

    def _tend_doors(self, seconds: float) -> None:
        """Shut or open a door when its time has come."""
        life, chance = self._life, self._chance
        assert chance is not None, "doors move after begin"
        if life.change_in > seconds:
            self._life = replace(life, change_in=life.change_in - seconds)
        elif life.shut:
            self.set_door(life.shut, False)
            self._life = replace(life, shut="", change_in=float(chance.uniform(*OPEN_S)))
        else:
            names = [n for n in self.plan.door_names if n not in self.shut_doors]
            name = names[chance.integers(len(names))] if names else ""
            if not (name and self._may_shut(name)):
                self._life = replace(life, change_in=RETRY_S)
                return
            self.set_door(name, True)
            self._life = replace(life, shut=name, change_in=float(chance.uniform(*SHUT_S)))

    def _may_shut(self, name: str) -> bool:
        """Whether a door is clear, and no place is cut off without it."""
        leaf = self.segment(name)
        corners = (*self.box_outlines, *(np.array((p.at,)) for p in self._life.people))
        gaps = [point_segment_distances(points, leaf).min() for points in corners]
        if not Event("shut", name).is_clear(self) or min(gaps, default=9.0) < CLEAR_OF_DOORS_M:
            return False
        (a, b) = leaf[0]
        normal = np.array((a[1] - b[1], b[0] - a[0])) / math.dist(a, b)
        sides = [(a + b) / 2.0 + sign * BESIDE_DOOR_M * normal for sign in (1.0, -1.0)]
        before, behind = (Pose(float(x), float(y)) for x, y in sides)
        return math.isfinite(self._routes.distance(before, behind, self.shut_doors | {name}))


def living_or_still(plan: FloorPlan, robot: RobotSpec, dynamics: Dynamics) -> World:
    """A world with as much life in it as the level says."""
    return LivingWorld(plan, robot, dynamics) if dynamics.lives else World(plan, robot)
