"""The walk of someone who knows the plan, but learns of a block on seeing it.

Scores compare a robot with it: the shortest way of one who knows all is out of reach for a
robot that is told of no event.
"""

from __future__ import annotations

import math

import numpy as np

from cogmap_gym.events import EventQueue
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.routes import Routes, Solid
from cogmap_gym.trail import Trail
from cogmap_gym.world import World

LOOK_EVERY_M = 0.25
"""The walker looks, and events may fire, after so much of the way [m]. Ours."""


class Imagined:
    """Doors, barriers and a robot that change as those of a world, which stays as it is."""

    def __init__(self, world: World) -> None:
        """As the world is now."""
        self._world = world
        self.robot = world.robot
        self.pose = world.pose
        self.shut_doors = world.shut_doors
        self.present_barriers = world.present_barriers

    @property
    def solid(self) -> Solid:
        """What is in the way now."""
        return self.shut_doors | self.present_barriers

    def segment(self, name: str) -> Segments:
        """Where a door or a barrier is when it is in the way, (1, 2, 2)."""
        return self._world.segment(name)

    def set_door(self, name: str, shut: bool) -> None:
        """Shut or open a door."""
        self.shut_doors = self.shut_doors | {name} if shut else self.shut_doors - {name}

    def set_barrier(self, name: str, present: bool) -> None:
        """Place a barrier or take it away."""
        there = self.present_barriers
        self.present_barriers = there | {name} if present else there - {name}


def learning_length(
    world: World, routes: Routes, events: EventQueue, goal: Pose, range_max: float
) -> float:
    """Length of the walk from the robot's pose to a goal [m]; infinite where it finds no way.

    The walker knows the walls, all that is in the way as it begins, and each opening as soon
    as it is made; of a block it learns once a quarter point or the middle of the door or
    barrier is in line of sight, all round (turning costs no length). It takes the shortest
    way by what it knows. So it is never longer than it must be for want of a look behind.

    Args:
        world: where the walk begins; stays as it is.
        routes: of that world.
        events: what is waited for; the events happen on the walk as they would truly.
        goal: where the walk ends.
        range_max: how far the walker sees [m].
    """
    imagined = Imagined(world)
    queue, known = events.copy_for(imagined), imagined.solid
    trail, length = Trail(world.plan, imagined.pose), 0.0
    while True:
        queue.fire(trail.rooms)
        known = _known(imagined, routes, known, range_max)
        way = routes.way(imagined.pose, goal, known)
        if way is None:
            return math.inf
        step, arrived = _beginning(way)
        length += float(np.hypot(*np.diff(step, axis=0).T).sum())
        if arrived:
            return length
        trail.follow(step)
        imagined.pose = Pose(float(step[-1, 0]), float(step[-1, 1]))


def _known(imagined: Imagined, routes: Routes, known: Solid, range_max: float) -> Solid:
    """What the walker knows to be in the way after a look from where it is."""
    true, eye = imagined.solid, imagined.pose.position
    seen = known & true
    for name in sorted(true - known):
        middle = imagined.segment(name)[0].mean(axis=0)
        near = float(np.hypot(*(middle - eye))) <= range_max
        if near and routes.in_sight(eye, name, true):
            seen = seen | {name}
    return seen


def _beginning(way: Points) -> tuple[Points, bool]:
    """The first part of a way (K, 2), and whether that is the whole."""
    along = np.concatenate(((0.0,), np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
    if along[-1] <= LOOK_EVERY_M:
        return way, True
    end = [np.interp(LOOK_EVERY_M, along, way[:, k]) for k in (0, 1)]
    return np.concatenate((way[along < LOOK_EVERY_M], [end])), False
