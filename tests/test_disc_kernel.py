"""The compiled body against the pymunk body, move by move."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cogmap_gym.body import Body
from cogmap_gym.disc_kernel import (
    BUMP,
    DRIFT_M,
    DRIVEN,
    HEADING,
    MOST_POINTS,
    NEAR,
    POINTS,
    TURNED,
    drive_disc,
    gather,
    move_disc,
)
from cogmap_gym.geometry import Array, Pose, Segments
from cogmap_gym.observation import RobotSpec
from cogmap_gym.wall_cells import file_in_cells, lay_out_cells

ROBOT = RobotSpec()
CLUTTER = np.array(
    [
        *([[0, 0], [6, 0]], [[6, 0], [6, 5]], [[6, 5], [0, 5]], [[0, 5], [0, 0]]),
        *([[2, 0], [2, 2]], [[2, 2.9], [2, 5]], [[4, 1], [4.6, 1.7]], [[4.6, 1.7], [4, 2.4]]),
        *([[3, 4], [3.4, 4]], [[3.4, 4], [3.4, 4.4]], [[0.8, 3.2], [0.8, 3.2001]]),
    ],
    dtype=np.float64,
)


class Disc:
    """The compiled body, with what it writes on."""

    def __init__(self, segments: Segments) -> None:
        self.segments = segments.reshape(-1, 4)
        self.grid, self.columns, self.lines = lay_out_cells(self.segments)
        self.cells = file_in_cells(self.segments, self.grid, self.columns, self.lines)
        self.seen, self.stamp = np.zeros(len(segments), dtype=np.int64), 0
        self.near, self.velocity = np.zeros((len(segments), NEAR)), np.zeros(4)
        self.path, self.out = np.zeros((MOST_POINTS, 2)), np.zeros(7)

    def go(self, control: str, first: float, second: float) -> Array:
        """One move; answers the state written."""
        travel = abs(second) if control == "move" else abs(first) * ROBOT.velocity_step
        self.stamp += 1
        count = gather(
            *(self.out[0], self.out[1], travel + ROBOT.radius + DRIFT_M, self.segments),
            *(*self.cells, self.seen, self.stamp, self.grid, self.columns, self.lines, self.near),
        )
        rest = (ROBOT.max_speed, ROBOT.radius, self.near, count, self.velocity, self.path, self.out)
        if control == "move":
            move_disc(first, second, *rest)
        else:
            drive_disc(first, second, ROBOT.velocity_step, *rest)
        return self.out


@pytest.mark.parametrize("control", ["move", "velocity"])
def test_it_moves_touches_and_slides_as_pymunk_does(control: str) -> None:
    rng, body, disc = np.random.default_rng(1), Body(ROBOT, CLUTTER), Disc(CLUTTER)
    bumps = 0
    for k in range(400):
        if k % 20 == 0:
            body.pose = Pose(float(rng.uniform(2.4, 3.4)), float(rng.uniform(0.5, 3.5)), k)
        disc.out[:3] = body.pose.x, body.pose.y, body.pose.theta
        first, second = rng.uniform(-1.0, 1.0, 2)
        if control == "move":
            motion = body.move(first, 1.5 * (second + 1.0))
            out = disc.go("move", first, 1.5 * (second + 1.0))
        else:
            first = 0.7 if k % 3 else 0.7 * first
            motion, out = body.drive(first, second), disc.go("velocity", first, second)
        assert out[:2] == pytest.approx(body.pose.position, abs=0.002)
        assert abs(math.remainder(out[HEADING] - body.pose.theta, math.tau)) < 1e-9
        assert (bool(out[BUMP]), out[TURNED]) == (motion.bump, pytest.approx(motion.turned))
        assert out[DRIVEN] == pytest.approx(motion.driven, abs=0.002)
        assert int(out[POINTS]) == len(motion.path)
        bumps += motion.bump
    assert bumps >= 10


def test_it_never_enters_a_wall() -> None:
    rng, disc = np.random.default_rng(2), Disc(CLUTTER[:4])
    disc.out[:3] = 3.0, 2.5, 0.0
    for _ in range(200):
        x, y, *_ = disc.go("move", float(rng.uniform(-0.5, 0.5)), 3.0)
        assert min(x, y, 6.0 - x, 5.0 - y) > ROBOT.radius - 0.01


def test_a_free_drive_ends_exactly_where_it_shall() -> None:
    disc = Disc(CLUTTER)
    disc.out[:3] = 2.5, 2.5, 0.0
    x, y, heading, turned, driven, bump, _ = disc.go("move", -math.pi / 2, 1.0)
    assert (x, y, heading) == pytest.approx((2.5, 1.5, -math.pi / 2))
    assert (turned, driven, bump) == (-math.pi / 2, pytest.approx(1.0), 0.0)
