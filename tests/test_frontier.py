"""The frontier robot's parts: grid, ways, scan matching, pose graph."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.frontier.agent import FrontierAgent
from agents.frontier.driver import move_towards
from agents.frontier.flood_kernel import UNREACHED, flood
from agents.frontier.grid import OccupancyGrid
from agents.frontier.grid_kernel import update_clearance
from agents.frontier.icp import PointMap, match, odometry_sds
from agents.frontier.matching import ScanMatching
from agents.frontier.params import Params
from agents.frontier.patrol import way_to_doubtful_wall
from agents.frontier.planner import frontiers, prices, straight_reach, way_to
from agents.frontier.positions import DeadReckoning
from agents.frontier.scans import clean_ranges, free_way, hits_in_robot
from agents.frontier.surfels import Surfels, surfels_of
from cogmap_gym.geometry import Points, Pose, Segments
from cogmap_gym.observation import LaserSpec, RobotSpec
from tests import reference
from tests.rooms import corridor, plan, square_room
from tests.simulated import scan, solid

LASER, ROBOT, PARAMS = LaserSpec(), RobotSpec(), Params()
MIDDLE = Pose(3.0, 3.0, 0.0)
TWO_ROOMS = plan(
    walls=[
        [[0, 0], [8, 0], [8, 4], [0, 4], [0, 0]],
        [[4, 0], [4, 1.5]],
        [[4, 2.5], [4, 4]],
    ],
)
LEAF: Segments = np.array([[[4.0, 1.5], [4.0, 2.5]]])


def looked(grid: OccupancyGrid, walls: Segments, pose: Pose, step: int = 0, turns: int = 1) -> None:
    """Enter exact scans from a pose; several turn the robot all round."""
    for k in range(turns):
        at = pose @ Pose(theta=k * math.tau / turns)
        grid.add(at, clean_ranges(np.float32(scan(walls, at, LASER)), LASER), step)


def new_grid() -> OccupancyGrid:
    return OccupancyGrid(PARAMS.grid, PARAMS.planner.comfort, LASER)


def votes_at(grid: OccupancyGrid, *points: tuple[float, float]) -> list[int]:
    return grid.votes[grid.cells(np.array(points))].tolist()


def mask_at(grid: OccupancyGrid, point: tuple[float, float]) -> np.ndarray:
    mask = np.zeros(grid.votes.shape, dtype=np.bool_)
    mask[grid.cells(np.array([point]))] = True
    return mask


def surfels(walls: Segments, pose: Pose, seed: int) -> Surfels:
    ranges = scan(walls, pose, LASER, np.random.default_rng(seed))
    return surfels_of(
        hits_in_robot(clean_ranges(np.float32(ranges), LASER), LASER), PARAMS.matching
    )


def test_what_beams_pass_is_free_where_they_end_occupied_and_the_rest_unknown() -> None:
    grid = new_grid()
    looked(grid, solid(square_room()), MIDDLE)
    ahead, aside, wall, beyond, behind = votes_at(
        grid, (5.0, 3.0), (3.5, 5.5), (6.01, 3.02), (6.5, 3.0), (1.0, 3.0)
    )
    assert ahead < 0
    assert aside < 0
    assert wall > 0
    assert beyond == behind == 0


@pytest.mark.parametrize("value", [math.nan, math.inf, 0.0, -1.0, LASER.range_max])
def test_a_beam_without_return_is_evidence_of_nothing(value: float) -> None:
    grid = new_grid()
    grid.add(Pose(), clean_ranges(np.full(LASER.beams, value, dtype=np.float32), LASER), 0)
    seen = np.argwhere(grid.votes != 0)
    assert np.hypot(*grid.centres(seen).T).max() <= PARAMS.grid.body


def test_a_shut_door_is_noticed_at_once_and_an_open_one_after_two_views() -> None:
    grid, walls = new_grid(), solid(TWO_ROOMS)
    at, door = Pose(2.0, 2.0, 0.0), (4.01, 2.01)
    for _ in range(4):
        looked(grid, walls, at)
    assert votes_at(grid, door)[0] < 0
    shut = np.concatenate((walls, LEAF))
    looked(grid, shut, at)
    assert votes_at(grid, door)[0] > 0
    looked(grid, walls, at)
    assert votes_at(grid, door)[0] > 0
    looked(grid, walls, at)
    assert votes_at(grid, door)[0] < 0


def test_the_grid_grows_to_where_beams_end_and_keeps_what_it_knew() -> None:
    grid, walls = new_grid(), solid(corridor(length=40.0))
    looked(grid, walls, Pose(1.0, 1.0, 0.0))
    before = votes_at(grid, (5.0, 1.0))
    looked(grid, walls, Pose(30.0, 1.0, 0.0))
    assert votes_at(grid, (5.0, 1.0)) == before
    assert votes_at(grid, (38.0, 1.0))[0] < 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
@settings(max_examples=30, deadline=None)
def test_the_clearance_equals_its_slow_twin(seed: int, cap: int) -> None:
    rng = np.random.default_rng(seed)
    votes = rng.choice(np.array((-1, 0, 1), dtype=np.int8), (17, 23), p=(0.6, 0.3, 0.1))
    found = np.zeros(votes.shape, dtype=np.float32)
    update_clearance(found, votes, (0, 17, 0, 23), cap)
    assert np.allclose(found, reference.clearance(votes, cap), atol=1e-5)
    part = np.zeros(votes.shape, dtype=np.float32)
    update_clearance(part, votes, (5, 9, 4, 20), cap)
    assert np.array_equal(part[5:9, 4:20], found[5:9, 4:20])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_the_flood_equals_its_slow_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    price = rng.choice(np.array((0, 10, 13, 40, 200), dtype=np.int16), (9, 11))
    costs, origin, end = flood(price, 4 * 11 + 5, np.zeros(price.shape, dtype=np.bool_))
    found = {divmod(int(k), 11): int(costs[k]) for k in np.flatnonzero(costs != UNREACHED)}
    assert end == -1
    assert found == reference.cheapest(price, (4, 5))
    for cell in np.flatnonzero(origin >= 0):
        assert costs[origin[cell]] < costs[cell]


def test_frontiers_are_where_the_known_ends_and_not_along_walls() -> None:
    grid, walls = new_grid(), solid(square_room())
    looked(grid, walls, MIDDLE)
    ends = grid.centres(np.argwhere(frontiers(grid, PARAMS.planner)))
    assert len(ends) > 0
    assert (ends[:, 0] < 3.3).all()
    looked(grid, walls, MIDDLE, turns=12)
    assert not frontiers(grid, PARAMS.planner).any()


def test_a_way_leads_through_the_middle_of_a_door_and_none_through_a_shut_one() -> None:
    grid, walls = new_grid(), solid(TWO_ROOMS)
    for pose in (Pose(2.0, 2.0), Pose(6.0, 2.0)):
        looked(grid, walls, pose, turns=12)
    price = prices(grid, PARAMS.planner, 0, through_unknown=False)
    start, goal = np.array((1.0, 3.5)), mask_at(grid, (7.0, 3.5))
    way = way_to(grid, price, start, goal)
    assert way is not None
    at_door = way.points[np.argmin(np.abs(way.points[:, 0] - 4.0))]
    assert abs(at_door[1] - 2.0) < 0.15
    row = straight_reach(grid, price, way.points, start)
    assert 0 < row < len(way.points) - 1
    looked(grid, np.concatenate((walls, LEAF)), Pose(2.0, 2.0), 1)
    price = prices(grid, PARAMS.planner, 1, through_unknown=False)
    assert way_to(grid, price, start, goal) is None


def test_a_door_may_have_opened_where_a_wall_parts_robot_and_mark() -> None:
    grid, walls = new_grid(), solid(TWO_ROOMS)
    for pose in (Pose(2.0, 2.0), Pose(6.0, 2.0)):
        looked(grid, walls, pose, turns=12)
    shut = np.concatenate((walls, LEAF))
    looked(grid, shut, Pose(2.0, 2.0), 1)
    price = prices(grid, PARAMS.planner, 1, through_unknown=False)
    ends = (np.array((2.0, 2.0)), np.array((6.0, 2.0)))
    way = way_to_doubtful_wall(grid, PARAMS.planner, price, ends, 2)
    assert way is not None
    assert abs(way.target[0] - 4.0) < 0.1
    looked(grid, shut, Pose(2.0, 2.0), 2, turns=12)
    again = way_to_doubtful_wall(grid, PARAMS.planner, price, ends, 2)
    assert again is None or abs(again.target[1] - 2.0) > 0.5


def test_a_disc_gets_as_far_as_its_edge_touches() -> None:
    post: Points = np.array([[2.0, 0.15]])
    assert free_way(post, 0.0, 0.25) == pytest.approx(2.0 - math.sqrt(0.25**2 - 0.15**2))
    assert free_way(post, math.radians(20.0), 0.25) == math.inf


def test_a_drive_ends_before_what_the_laser_sees_and_a_short_one_is_blocked() -> None:
    wall: Points = np.stack((np.full(41, 1.0), np.linspace(-1.0, 1.0, 41)), axis=1)
    ahead = np.array((3.0, 0.0))
    move = move_towards(ahead, Pose(), wall, ROBOT, PARAMS.driver, 3.0)
    driven = ROBOT.max_forward * (float(move.action[1]) + 1.0) / 2.0
    assert driven == pytest.approx(1.0 - ROBOT.radius - PARAMS.driver.clearance, abs=1e-5)
    assert not move.blocked
    assert move_towards(ahead, Pose(), wall - (0.7, 0.0), ROBOT, PARAMS.driver, 3.0).blocked


def test_normals_look_at_the_robot_and_stand_on_their_walls() -> None:
    found = surfels(solid(square_room()), MIDDLE, seed=0)
    on_wall = np.argmax(np.abs(found.points), axis=1)
    clear = np.abs(np.abs(found.points[:, 0]) - np.abs(found.points[:, 1])) > 0.4
    rows = np.flatnonzero(clear)
    across = found.normals[rows, on_wall[rows]]
    assert (np.abs(across) > 0.98).all()
    assert ((found.points * found.normals).sum(axis=1) < 0.0).all()


@pytest.mark.parametrize("map_from_plan", [Pose(), Pose(40.0, -30.0, 2.0)])
@pytest.mark.parametrize("off", [Pose(0.2, -0.15, 0.1), Pose(-0.1, 0.1, -0.17)])
def test_icp_finds_the_pose_of_a_scan_wherever_the_origin_is(
    off: Pose, map_from_plan: Pose
) -> None:
    walls, start, end = solid(square_room()), MIDDLE, Pose(3.4, 2.8, 0.3)
    known = PointMap(surfels(walls, start, seed=1).moved(map_from_plan @ start))
    truth = map_from_plan @ end
    sds = np.array((0.2, 0.2, 0.2))
    found = match(surfels(walls, end, seed=2), known, truth @ off, sds, PARAMS.matching)
    assert found.pose.distance(truth) < 0.02
    assert abs((truth.inverse() @ found.pose).theta) < math.radians(0.4)
    assert found.share > 0.9


def test_along_a_bare_corridor_odometry_decides_and_across_it_the_walls() -> None:
    walls, start, end = solid(corridor(length=200.0)), Pose(100.0, 1.0), Pose(101.0, 1.0)
    known = PointMap(surfels(walls, start, seed=1).moved(start))
    guess = end @ Pose(0.05, 0.1, 0.05)
    sds = odometry_sds(Pose(1.0, 0.0, 0.0), PARAMS.matching)
    found = match(surfels(walls, end, seed=2), known, guess, sds, PARAMS.matching).pose
    assert abs(found.y - end.y) < 0.02
    assert abs(found.theta - end.theta) < math.radians(0.5)
    assert found.x == pytest.approx(guess.x, abs=0.03)


def test_a_graph_with_a_closed_loop_comes_back_to_where_it_began() -> None:
    pytest.importorskip("gtsam", reason="needs the extra slam")
    from agents.frontier.pose_graph import PoseGraph

    side, drift = Pose(2.0, 0.0, math.pi / 2.0), Pose(0.05, 0.0, 0.03)
    covariance = np.diag((0.1, 0.1, 0.05)) ** 2
    graph, poses = PoseGraph(Pose()), [Pose()]
    for node in range(1, 5):
        graph.add(node - 1, node, side @ drift, covariance, closes=False)
        poses.append(poses[-1] @ side @ drift)
    assert poses[-1].distance(Pose()) > 0.15
    graph.add(0, 4, Pose(), np.diag((0.01, 0.01, 0.005)) ** 2, closes=True)
    solved = graph.solve(poses)
    assert solved[0].distance(Pose()) < 1e-3
    assert solved[4].distance(Pose()) < 0.02
    assert solved[2].distance(Pose(2.0, 2.0)) < 0.1


def test_who_may_correct_the_past_keeps_its_scans_and_pays_for_them() -> None:
    sizes = {}
    for source in (DeadReckoning(), ScanMatching()):
        agent = FrontierAgent(source)
        agent.reset(ROBOT, LASER)
        for step in range(3):
            ranges = np.float32(scan(solid(square_room()), MIDDLE, LASER))
            agent.act({"scan": ranges, "odometry": np.zeros(3), "bump": 0, "mark": 0, "goal": 0})
            assert agent.now == step
        sizes[type(source)] = agent.map_bytes
    assert 0 < sizes[DeadReckoning] < sizes[ScanMatching]
    assert sizes[DeadReckoning] == agent.grid.known_bytes
