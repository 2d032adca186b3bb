"""Reaching a point: paths, moves, and whole drives of a disc through doors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from agents.cogmap.navigator import clear_distance, plan_path, sample_surfaces, steer
from agents.cogmap.params import Navigation
from cogmap_gym.geometry import Points, Pose, Segments, lengths, point_segment_distances
from cogmap_gym.observation import RobotSpec

PARAMS = Navigation()
ROBOT = RobotSpec()
NOTHING = np.zeros((0, 2))


def polyline(*corners: tuple[float, float]) -> Segments:
    """Segments from corner to corner."""
    points = np.array(corners, dtype=np.float64)
    return np.stack((points[:-1], points[1:]), axis=1)


def two_rooms(door: float, width: float) -> Segments:
    """8 x 5 m cut in two by a wall of 0.2 m with a doorway whose middle is at y = ``door``."""
    low, high = door - width / 2, door + width / 2
    return np.concatenate(
        (
            polyline((0, 0), (8, 0), (8, 5), (0, 5), (0, 0)),
            polyline((3.9, 0), (3.9, low), (4.1, low), (4.1, 0)),
            polyline((3.9, 5), (3.9, high), (4.1, high), (4.1, 5)),
        )
    )


def box(x: float, y: float, w: float, h: float) -> Segments:
    """The outline of a piece of furniture."""
    return polyline((x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y))


def legs(path: Points) -> Segments:
    """The straight parts of a path."""
    return np.stack((path[:-1], path[1:]), axis=1)


def clearance(path: Points, walls: Segments) -> float:
    """Smallest distance between a path and walls."""
    return float(point_segment_distances(sample_surfaces(legs(path), 0.02), walls).min())


def test_in_the_open_the_path_is_the_straight_line() -> None:
    path = plan_path(NOTHING, np.zeros(2), np.array((5.0, 1.0)), PARAMS)
    np.testing.assert_allclose(path, [(0.0, 0.0), (5.0, 1.0)])


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.785])
@pytest.mark.parametrize("width", [0.8, 0.9, 1.2])
def test_a_path_leads_safely_through_a_doorway_however_it_is_turned(
    angle: float, width: float
) -> None:
    turned = Pose(1.37, -2.9, angle)
    walls = turned.apply(two_rooms(1.7, width))
    start, goal = turned.apply(np.array([(1.0, 3.5), (7.0, 4.0)]))
    path = plan_path(sample_surfaces(walls, 0.05), start, goal, PARAMS)
    assert path is not None
    np.testing.assert_allclose(path[[0, -1]], (start, goal))
    assert clearance(path, walls) >= ROBOT.radius + 0.02
    assert len(path) <= 7


def test_a_path_keeps_its_distance_where_it_can() -> None:
    walls = polyline((2.0, -2.0), (2.0, 0.1))
    path = plan_path(sample_surfaces(walls, 0.05), np.zeros(2), np.array((4.0, 0.0)), PARAMS)
    assert path is not None
    assert clearance(path, walls) > 0.4


def test_a_shut_door_leaves_no_route() -> None:
    walls = np.concatenate((two_rooms(2.5, 0.9), polyline((4.0, 2.0), (4.0, 3.0))))
    start, goal = np.array((1.0, 2.5)), np.array((7.0, 2.5))
    assert plan_path(sample_surfaces(walls, 0.05), start, goal, PARAMS) is None


def test_an_enclosed_robot_has_no_route() -> None:
    walls = box(-0.5, -0.5, 1.0, 1.0)
    goal = np.array((3.0, 0.0))
    assert plan_path(sample_surfaces(walls, 0.05), np.zeros(2), goal, PARAMS) is None


def test_a_robot_that_touches_a_wall_gets_away_from_it() -> None:
    walls = two_rooms(2.5, 0.9)
    start = np.array((0.25, 0.26))
    path = plan_path(sample_surfaces(walls, 0.05), start, np.array((7.0, 2.5)), PARAMS)
    assert path is not None
    assert clearance(path, walls) >= 0.24
    assert clearance(path[1:], walls) >= ROBOT.radius


def test_a_goal_beside_a_wall_moves_to_where_the_robot_fits() -> None:
    walls = two_rooms(2.5, 0.9)
    goal = np.array((7.95, 2.5))
    path = plan_path(sample_surfaces(walls, 0.05), np.array((5.0, 2.5)), goal, PARAMS)
    assert path is not None
    assert ROBOT.radius <= clearance(path[-1:].repeat(2, axis=0), walls)
    assert np.hypot(*(path[-1] - goal)) <= PARAMS.goal_reach


def test_a_goal_deep_inside_furniture_has_no_route() -> None:
    points = np.stack(np.meshgrid(np.arange(4, 6, 0.1), np.arange(-1, 1, 0.1)), -1).reshape(-1, 2)
    assert plan_path(points, np.zeros(2), np.array((5.0, 0.0)), PARAMS) is None


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.2, 2.7])
def test_a_moved_scene_has_an_equally_good_path(angle: float) -> None:
    walls, moved = two_rooms(2.5, 0.9), Pose(12.34, -5.67, angle)
    start, goal = np.array((1.03, 1.04)), np.array((7.02, 4.01))
    a = plan_path(sample_surfaces(walls, 0.05), start, goal, PARAMS)
    there = moved.apply(walls)
    b = plan_path(sample_surfaces(there, 0.05), moved.apply(start), moved.apply(goal), PARAMS)
    assert a is not None
    assert b is not None
    assert lengths(legs(b)).sum() == pytest.approx(lengths(legs(a)).sum(), rel=0.04)
    assert clearance(b, there) == pytest.approx(clearance(a, walls), abs=0.08)


def test_the_clear_distance_ends_where_the_disc_touches() -> None:
    points = np.array([(2.0, 0.0), (1.0, 0.3), (-0.5, 0.0), (math.nan, 0.0)])
    assert clear_distance(points, 0.0, 0.25, 5.0) == pytest.approx(1.75)
    assert clear_distance(points, 0.0, 0.31, 5.0) < 1.0
    assert clear_distance(points, math.pi, 0.25, 5.0) == pytest.approx(0.25)
    assert clear_distance(NOTHING, 0.0, 0.25, 5.0) == 5.0
    assert clear_distance(np.array([(0.1, 0.0)]), 0.0, 0.25, 5.0) == 0.0
    assert clear_distance(np.array([(0.1, 0.0)]), math.pi, 0.25, 5.0) == 5.0


def test_the_clear_distance_does_not_depend_on_the_frame() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-3.0, 3.0, (50, 2)) + np.array((3.2, 0.0))
    turned = Pose(0.0, 0.0, 1.1)
    assert clear_distance(points, 0.2, 0.25, 9.0) == pytest.approx(
        clear_distance(turned.apply(points), 1.3, 0.25, 9.0)
    )


def test_sampled_surfaces_keep_their_ends_and_spacing() -> None:
    segments = polyline((0.0, 0.0), (1.0, 0.0), (1.0, 0.35))
    points = sample_surfaces(segments, 0.1)
    assert {(0.0, 0.0), (1.0, 0.0), (1.0, 0.35)} <= {tuple(p) for p in points}
    assert point_segment_distances(points, segments).min(axis=1).max() < 1e-12
    assert len(points) == 11 + 5
    assert sample_surfaces(np.zeros((0, 2, 2)), 0.1).shape == (0, 2)


def test_a_move_turns_first_when_the_path_is_aside() -> None:
    path = np.array([(0.0, 0.0), (0.0, 2.0)])
    assert steer(path, NOTHING, PARAMS, ROBOT) == (ROBOT.max_turn, 0.0)
    turn, forward = steer(path[:, ::-1] * 3.0, NOTHING, PARAMS, ROBOT)
    assert (turn, forward) == (0.0, ROBOT.max_forward)


def test_a_move_is_short_beside_a_wall_and_never_ends_in_one() -> None:
    path = np.array([(0.0, 0.0), (3.0, 0.0)])
    beside = sample_surfaces(polyline((-1.0, 0.35), (4.0, 0.35)), 0.05)
    ahead = sample_surfaces(polyline((1.5, -1.0), (1.5, 1.0)), 0.05)
    assert 0.3 <= steer(path, beside, PARAMS, ROBOT)[1] <= 1.0
    assert steer(path, ahead, PARAMS, ROBOT)[1] <= 1.5 - ROBOT.radius


def test_no_path_left_is_no_move() -> None:
    assert steer(np.zeros((2, 2)), NOTHING, PARAMS, ROBOT) == (0.0, 0.0)


def scan(walls: Segments, pose: Pose, rng: np.random.Generator) -> Points:
    """Where the 360 beams of a noisy laser end, in the robot's frame."""
    angles = np.radians(np.arange(-90.0, 90.0, 0.5))
    d = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    local = pose.inverse().apply(walls)
    p, r = local[:, 0], local[:, 1] - local[:, 0]
    denominator = d[:, :1] * r[:, 1] - d[:, 1:] * r[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (p[:, 0] * r[:, 1] - p[:, 1] * r[:, 0]) / denominator
        u = (p[:, 0] * d[:, 1:] - p[:, 1] * d[:, :1]) / denominator
    hit = np.where((u >= 0) & (u <= 1) & (t > 0), t, np.inf).min(axis=1)
    return d * (hit + rng.normal(0.0, 0.012, hit.shape))[:, None]


def drive(walls: Segments, start: Pose, goal: Points, rng: np.random.Generator) -> tuple[bool, int]:
    """Drive to a goal with medium odometry: whether it was reached, and the contacts."""
    truth = believed = start
    memory: list[Points] = []
    contacts = 0
    for _ in range(60):
        # Where the robot is, the map tells it to a few centimetres at each view.
        believed = Pose(truth.x + rng.normal(0, 0.02), truth.y + rng.normal(0, 0.02), truth.theta)
        points = scan(walls, truth, rng)
        memory = [*memory[-7:], believed.apply(points)]
        known = np.concatenate(memory)
        if np.hypot(*(goal - believed.position)) < 0.4:
            return truth.distance(Pose(*goal)) < 0.6, contacts
        path = plan_path(known, believed.position, goal, PARAMS, ROBOT)
        if path is None:
            turn, forward = ROBOT.max_turn, 0.0
        else:
            inverse = believed.inverse()
            turn, forward = steer(inverse.apply(path), inverse.apply(known), PARAMS, ROBOT)
        turn += rng.normal(0.0, math.radians(1.0)) + math.radians(0.25)
        forward *= 1.0 + rng.normal(0.0, 0.02) + 0.01
        there = truth @ Pose(0.0, 0.0, turn)
        line = np.stack((there.position, (there @ Pose(forward)).position))
        steps = np.linspace(line[0], line[1], 1 + math.ceil(forward / 0.005))
        near = point_segment_distances(steps, walls).min(axis=1)
        bad = np.flatnonzero((near < ROBOT.radius) & (near < near[0]))
        contacts += len(bad) > 0
        end = steps[max(bad[0] - 1, 0)] if len(bad) else steps[-1]
        truth = Pose(end[0], end[1], there.theta)
    return False, contacts


def random_rooms(rng: np.random.Generator) -> tuple[Segments, Pose, Points]:
    """Two furnished rooms, a start in the one and a goal in the other."""
    door = rng.uniform(0.8, 4.2)
    walls = two_rooms(door, rng.uniform(0.8, 1.0))
    pieces = []
    for _ in range(rng.integers(2, 6)):
        w, h = rng.uniform(0.4, 1.2, 2)
        x, y = rng.uniform(0.0, 8.0 - w), rng.uniform(0.0, 5.0 - h)
        at_door = x - 0.9 < 4.0 < x + w + 0.9 and y - 0.9 < door < y + h + 0.9
        in_wall = x - 0.1 < 4.0 < x + w + 0.1
        apart = all(
            max(x, a) - min(x + w, a + c) > 0.8 or max(y, b) - min(y + h, b + d) > 0.8
            for a, b, c, d in pieces
        )
        if apart and not at_door and not in_wall:
            pieces.append((x, y, w, h))
            walls = np.concatenate((walls, box(x, y, w, h)))
    places = []
    for low, high in ((0.5, 3.2), (4.8, 7.5)):
        while True:
            p = np.array((rng.uniform(low, high), rng.uniform(0.5, 4.5)))
            inside = any(x < p[0] < x + w and y < p[1] < y + h for x, y, w, h in pieces)
            if not inside and point_segment_distances(p[None], walls).min() > 0.35:
                places.append(p)
                break
    start = Pose(places[0][0], places[0][1], rng.uniform(-math.pi, math.pi))
    return walls, start, places[1]


def test_drives_through_doors_reach_their_goals_without_contact() -> None:
    reached, touched, possible, runs = 0, 0, 0, 40
    for seed in range(2000, 2000 + runs):
        rng = np.random.default_rng(seed)
        walls, start, goal = random_rooms(rng)
        if plan_path(sample_surfaces(walls, 0.05), start.position, goal, PARAMS) is None:
            continue
        possible += 1
        arrived, contacts = drive(walls, start, goal, rng)
        reached += arrived
        touched += contacts > 0
    assert possible > 0.8 * runs
    assert reached - touched >= 0.98 * possible - 1.0


def test_the_legs_of_a_path_are_pulled_straight() -> None:
    walls = two_rooms(2.5, 1.0)
    path = plan_path(
        sample_surfaces(walls, 0.05), np.array((1.0, 0.6)), np.array((7.0, 4.4)), PARAMS
    )
    assert path is not None
    assert len(path) <= 6
    assert lengths(legs(path)).sum() < 1.1 * math.hypot(6.0, 3.8)
