"""A world in which more than the robot moves: boxes to push, people, doors on a schedule.

Time passes while the robot moves. It is cut into slices: people look about and walk, then
the robot drives on. Nobody ever walks into the robot; it may run into them.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogmap_gym.body import Body, Motion
from cogmap_gym.boxes import BOX_REACH_M, PushingBody, edges
from cogmap_gym.door_schedule import OPEN_S, RETRY_S, SHUT_S, may_shut
from cogmap_gym.dynamics import Dynamics
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, point_segment_distances
from cogmap_gym.life import Life, LivingState
from cogmap_gym.living_layout import drawn_boxes, drawn_people, free_spots
from cogmap_gym.moving_rays import MovingCaster
from cogmap_gym.observation import RobotSpec
from cogmap_gym.people import RADIUS_M, SPEED, Point, Surroundings, outlines, places, walk
from cogmap_gym.routes import Routes
from cogmap_gym.world import World, WorldState

SLICE_S = 0.1
"""How long people walk before they look about again, at most [s]."""
LEAST_MOVE_S = 0.5
"""Time that passes at least in a move, so that one who waits sees others pass [s]."""
TOUCH_M = 0.05
"""Room within which the body's physics may look beyond its way [m]."""
NEAR_M = 3.0
"""What lies this far beyond the end of a move cannot be moved by it: the boxes that the robot
pushes at once reach less far [m]."""


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
        self._box_edges, self._box_places = NO_SEGMENTS, np.zeros((0, 2))
        super().__init__(plan, robot)
        self.caster: MovingCaster = MovingCaster(self.fixed_segments, self.movable_segments)
        self.set_state(self.state())
        self._dynamics = dynamics
        self._spots = free_spots(self)
        self.routes = Routes(self)
        """The ways of the robot and of people."""

    _chance: np.random.Generator | None

    @property
    def box_outlines(self) -> tuple[Points, ...]:
        """The corners of each box and chair, (K, 2) [m]."""
        return tuple(box.outline for box in self._life.boxes)

    @property
    def people_outlines(self) -> tuple[Points, ...]:
        """The corners of each person, (K, 2) [m]."""
        return tuple(outlines(self._life.people))

    def begin(self, rng: np.random.Generator) -> None:
        """Fill the office anew, clear of the robot; all chance comes from ``rng``."""
        self._chance, level = rng, self._dynamics
        here = self.pose.position
        boxes = drawn_boxes(self.plan, self._spots, here, level.box_area, rng)
        people = drawn_people(self.plan, self._spots, here, boxes, level.person_area, rng)
        self._set_life(Life(boxes, people, "", float(rng.uniform(*OPEN_S))))
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
            self._set_life(state.life)
            if state.chance is not None:
                assert self._chance is not None, "a state with chance comes after begin"
                self._chance = copy.deepcopy(self._chance)
                self._chance.bit_generator.state = copy.deepcopy(state.chance)
            self._show()

    def move(self, turn: float, forward: float) -> Motion:
        """Turn by ``turn`` [rad] in place, then drive ``forward`` [m] or up to contact.

        People walk meanwhile.
        """
        robot = self.robot
        turning, driving = abs(turn) / robot.max_turn_rate, abs(forward) / robot.max_speed
        self._pass_time(max(turning, LEAST_MOVE_S - driving))
        body, motions = self._body, [self._body.move(turn, 0.0)]
        slices = math.ceil(driving / SLICE_S)
        for number in range(slices):
            self._walk(driving / slices)
            step = forward / slices
            body = self._body_for(abs(step), abs(forward) - number * abs(step), body)
            motions.append(body.move(0.0, step))
            self._keep(body)
            if motions[-1].bump:
                break
        return self._end(motions, turning + driving)

    def drive(self, v: float, omega: float) -> Motion:
        """Drive at ``v`` [m/s] turning at ``omega`` [rad/s] for one velocity step."""
        seconds = self.robot.velocity_step
        self._pass_time(seconds)
        body = self._body_for(abs(v) * seconds, abs(v) * seconds, self._body)
        motion = body.drive(v, omega)
        self._keep(body)
        return self._end([motion], seconds)

    def _body_for(self, step: float, left: float, body: Body) -> Body:
        """The physics of the next ``step`` [m] of a move of which ``left`` [m] are to come.

        It is the still world's as long as nothing that moves is within reach. Else it is made
        anew, so that it remembers nothing, and serves until the move ends.
        """
        if isinstance(body, PushingBody):
            body.set_people(self.people_outlines)
            return body
        here = self.pose.position
        to_boxes = np.hypot(*(self._box_places - here).T)
        to_people = np.hypot(*(places(self._life.people) - here).T)
        reach, far = self.robot.radius + step + TOUCH_M, left + NEAR_M
        if (to_boxes >= reach + BOX_REACH_M).all() and (to_people >= reach + RADIUS_M).all():
            return body
        solid, boxes, people = self.solid_segments, self._life.boxes, self.people_outlines
        walls = solid[point_segment_distances(here[None], solid)[0] < far]
        near = np.flatnonzero(to_boxes < far).tolist()
        met = np.flatnonzero(to_people < far + left * SPEED / self.robot.max_speed).tolist()
        pushing = PushingBody(
            self.robot, walls, {k: boxes[k] for k in near}, {k: people[k] for k in met}
        )
        pushing.pose = self.pose
        return pushing

    def _keep(self, body: Body) -> None:
        """Write down where the body and what it pushed are now."""
        if isinstance(body, PushingBody):
            self._body.pose = body.pose
            moved = body.moved_boxes()
            if moved:
                boxes = tuple(moved.get(k, box) for k, box in enumerate(self._life.boxes))
                self._set_life(replace(self._life, boxes=boxes))

    def _end(self, motions: Sequence[Motion], seconds: float) -> Motion:
        """Write down what the step brought about."""
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

    def _set_life(self, life: Life) -> None:
        """Begin or change the life, and where boxes are."""
        if life.boxes is not self._life.boxes:
            self._box_edges = edges([box.outline for box in life.boxes])
            centres = [(box.pose.x, box.pose.y) for box in life.boxes]
            self._box_places = np.array(centres, dtype=np.float64).reshape(-1, 2)
        self._life = life

    def _show(self) -> None:
        """Let the laser see what moves where it is now."""
        self.caster.moving = np.concatenate((self._box_edges, edges(outlines(self._life.people))))

    def _pass_time(self, seconds: float) -> None:
        slices = math.ceil(seconds / SLICE_S)
        for _ in range(slices):
            self._walk(seconds / slices)

    def _walk(self, seconds: float) -> None:
        """Let everybody walk, one after the other."""
        people = list(self._life.people)
        if not people:
            return
        here, at = self.pose, places(people)
        solid, boxes = self.solid_segments, self._box_edges
        about = Surroundings((here.x, here.y), self.robot.radius, at, solid, boxes)
        for number, person in enumerate(people):
            people[number] = walk(person, number, seconds, about, self._new_way)
            at[number] = people[number].at
        self._life = replace(self._life, people=tuple(people))

    def _new_way(self, start: Point) -> tuple[Point, ...]:
        """A way to some spot; empty where there is none now."""
        assert self._chance is not None, "people walk after begin"
        x, y = self._spots.points[self._chance.integers(len(self._spots.points))].tolist()
        way = self.routes.way(Pose(*start), Pose(x, y))
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
            about = (*self.box_outlines, places(life.people))
            if not (name and may_shut(self, self.routes, name, about)):
                self._life = replace(life, change_in=RETRY_S)
                return
            self.set_door(name, True)
            self._life = replace(life, shut=name, change_in=float(chance.uniform(*SHUT_S)))


def living_or_still(plan: FloorPlan, robot: RobotSpec, dynamics: Dynamics) -> World:
    """A world with as much life in it as the level says."""
    return LivingWorld(plan, robot, dynamics) if dynamics.lives else World(plan, robot)
