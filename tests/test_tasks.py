"""Laws of the tasks: marks, goals, declarations, rewards, events and ends."""

from __future__ import annotations

import numpy as np
import pytest

from cogmap_gym.body import Motion
from cogmap_gym.courses import Explore, GoHome, course_of
from cogmap_gym.coverage import Coverage
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, point_segment_distances
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.phases import Course, Itinerary, Phase
from cogmap_gym.routes import Routes
from cogmap_gym.tasks import Task
from cogmap_gym.thesis_tasks import Thesis
from cogmap_gym.world import World

OFFICE = FloorPlan.load("thesis_office")
TWO_ROOMS = FloorPlan.load("two_rooms")
CLOCKWISE = ("ASR2", "ASR3", "ASR4", "ASR5", "ASR6")


class Script:
    """A course of given phases, for tests."""

    def __init__(self, *phases: Phase, mark_rooms: dict[int, str] | None = None) -> None:
        self._itinerary = Itinerary(phases, mark_rooms or {})

    def check(self, plan: FloorPlan) -> None:
        """Any plan will do."""

    def most_moves(self, plan: FloorPlan) -> int:
        return 100

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:
        return self._itinerary


def begun(course: Course, plan: FloorPlan = TWO_ROOMS) -> tuple[Task, World]:
    world = World(plan, RobotSpec())
    task = Task(course, world, LaserSpec())
    task.reset(np.random.default_rng(0))
    return task, world


def hop(task: Task, world: World, x: float, y: float) -> tuple[float, bool]:
    """Put the robot somewhere as if it had driven there."""
    world.place(Pose(x, y, 0.0))
    return task.step(Motion(0.0, 0.0, False, np.array(((x, y), (x, y)))), declared=False)


def middle(plan: FloorPlan, room: str) -> tuple[float, float]:
    """A point of a room far from walls and doors."""
    world = World(plan, RobotSpec())
    low, high = plan.rooms[room].min(axis=0), plan.rooms[room].max(axis=0)
    best, at = 0.0, (0.0, 0.0)
    for x in np.arange(low[0], high[0], 0.3):
        for y in np.arange(low[1], high[1], 0.3):
            point = np.array(((x, y),))
            gap = point_segment_distances(point, plan.door_segments()).min()
            room_here = plan.room_at(x, y) == room
            size = min(world.clearance((x, y)), gap - 1.1) if room_here else 0.0
            if size > best:
                best, at = float(size), (float(x), float(y))
    assert best > 0.0, room
    return at


MIDDLE = {room: middle(OFFICE, room) for room in OFFICE.room_names}


def test_home_is_mark_1_at_the_start_and_at_no_other_time() -> None:
    task, world = begun(Explore())
    assert (task.mark, task.goal) == (1, 0)
    for _ in range(3):
        task.step(world.move(0.3, 0.1), declared=False)
        assert task.mark == 0


def test_a_declaration_within_a_metre_of_home_succeeds_and_ends_the_episode() -> None:
    task, world = begun(Script(Phase("home", 1, 9)))
    hop(task, world, 2.9, 2.5)
    reward, over = task.step(None, declared=True)
    assert over
    assert reward == pytest.approx(10.0 - 0.01)
    info = task.info()
    assert info["success"][1] == 1.0
    assert info["is_success"]
    assert info["final_distance"][1] == pytest.approx(0.9)


def test_a_wrong_declaration_closes_the_goal_and_the_next_follows() -> None:
    task, world = begun(Script(Phase("home", 1, 9), Phase("explore", 0)))
    hop(task, world, 3.3, 2.5)
    reward, over = task.step(None, declared=True)
    assert not over
    assert reward == pytest.approx(-10.0 - 0.01)
    assert task.goal == 0
    assert task.info()["success"][1] == 0.0
    assert task.info()["phase"] == 1


def test_declarations_while_exploring_are_ignored() -> None:
    task, _ = begun(Script(Phase("explore", 0), Phase("home", 1)))
    reward, over = task.step(None, declared=True)
    assert (reward, over, task.goal) == (-0.01, False, 0)


def test_a_goal_whose_budget_runs_out_fails() -> None:
    task, world = begun(Script(Phase("home", 1, 2)))
    assert not task.step(world.move(0.1, 0.1), declared=False)[1]
    assert task.step(world.move(0.1, 0.1), declared=False)[1]
    assert task.info()["success"][1] == 0.0


def test_where_no_route_is_open_declaring_anywhere_is_right() -> None:
    task, world = begun(Script(Phase("home", 1, 9)))
    hop(task, world, 6.0, 2.5)
    world.set_door("E1", True)
    reward, _ = task.step(None, declared=True)
    assert reward > 9.0
    assert task.info()["success"][1] == 1.0


def test_the_reward_under_a_goal_adds_up_to_the_way_made_good() -> None:
    task, world = begun(Script(Phase("home", 1, 99)))
    hop(task, world, 6.0, 2.5)
    world.place(Pose(6.0, 2.5, np.pi))
    rewards = [task.step(world.move(0.0, 1.0), declared=False)[0] for _ in range(4)]
    assert sum(rewards) == pytest.approx(4.0 - 0.04, abs=0.03)


def test_a_mark_is_given_once_inside_its_room_and_clear_of_doors() -> None:
    phases = (Phase("explore", 0, 6, budget_is_success=True), Phase("goto:2", 2, 9))
    task, world = begun(Script(*phases, mark_rooms={2: "R2"}))
    marks = []
    for x in (3.0, 4.6, 6.0, 6.2, 2.0):
        hop(task, world, x, 2.5)
        marks.append(task.mark)
    assert marks == [0, 0, 2, 0, 0]
    hop(task, world, 2.0, 2.5)
    assert task.goal == 2
    hop(task, world, 6.3, 2.5)
    assert task.step(None, declared=True)[1]
    assert task.info()["success"][2] == 1.0


def test_a_goal_whose_room_was_never_visited_fails_and_is_passed_over() -> None:
    phases = (Phase("explore", 0, 1), Phase("goto:2", 2, 9), Phase("home", 1, 9))
    task, world = begun(Script(*phases, mark_rooms={2: "R2"}))
    task.step(world.move(0.0, 0.1), declared=False)
    assert task.goal == 1
    assert [result.task for result in task.results] == ["explore", "goto:2"]
    assert task.info()["success"][2] == 0.0


def test_exploring_pays_for_the_share_newly_seen() -> None:
    task, world = begun(Explore())
    before = task.info()["coverage"]
    reward, _ = hop(task, world, 5.0, 2.5)
    after = task.info()["coverage"]
    assert reward == pytest.approx(after - before - 0.01)
    assert after > before


def test_coverage_is_whole_once_every_corner_was_looked_at_and_not_before() -> None:
    world = World(TWO_ROOMS, RobotSpec())
    coverage = Coverage(world, LaserSpec())
    coverage.look(Pose(2.0, 2.5, np.pi))
    assert 0.1 < coverage.share < 0.5
    for x in (1.0, 3.0, 5.0, 7.4):
        for y in (1.0, 2.5, 4.0):
            for theta in np.arange(0.0, 6.3, 0.5):
                coverage.look(Pose(x, y, theta))
    assert coverage.share > 0.99


def test_what_lies_behind_a_shut_door_never_counts() -> None:
    mapping = {**TWO_ROOMS.to_mapping(), "closed": ["E1"]}
    world = World(FloorPlan.load(mapping), RobotSpec())
    coverage = Coverage(world, LaserSpec())
    for theta in np.arange(0.0, 6.3, 0.5):
        coverage.look(Pose(2.0, 2.5, theta))
    assert coverage.share > 0.98


def test_routes_are_as_long_as_the_ruler_says() -> None:
    world = World(TWO_ROOMS, RobotSpec())
    routes = Routes(world)
    home = Pose(2.0, 2.5)
    assert routes.distance(Pose(6.0, 2.5), home) == pytest.approx(4.0, abs=0.02)
    assert routes.distance(Pose(3.0, 3.5), home) == pytest.approx(2**0.5, rel=0.01)
    world.set_door("E1", True)
    assert routes.distance(Pose(6.0, 2.5), home) == np.inf


def test_going_home_begins_at_a_moment_that_the_seed_draws() -> None:
    calls = set()
    for seed in range(6):
        world = World(OFFICE, RobotSpec())
        task = Task(GoHome(), world, LaserSpec())
        task.reset(np.random.default_rng(seed))
        phase = task.phase
        assert phase is not None
        calls.add((phase.coverage, phase.budget))
    assert len(calls) == 6


def test_a_clockwise_lap_forces_its_direction_and_ends_beyond_the_last_door() -> None:
    task, world = begun(Thesis(1), OFFICE)
    assert task.info()["events"] == ("shut E6",)
    for room in CLOCKWISE:
        hop(task, world, *MIDDLE[room])
        assert ("E6" in world.shut_doors) == (room == "ASR2")
    assert task.info()["phase"] == 0
    door = OFFICE.door_segments()[OFFICE.door_names.index("E6")].mean(axis=0)
    hop(task, world, door[0], door[1] + 0.8)
    assert task.info()["phase"] == 0
    hop(task, world, door[0], door[1] + 1.1)
    assert task.info()["phase"] == 1
    assert task.results[0].success
    assert "shut E6" in task.info()["events"]


def test_a_lap_that_turns_back_does_not_count() -> None:
    task, world = begun(Thesis(1), OFFICE)
    for room in (*CLOCKWISE[:-1], *CLOCKWISE[2::-1], "ASR1"):
        hop(task, world, *MIDDLE[room])
    assert task.info()["phase"] == 0


def test_events_wait_for_the_robot_to_be_out_of_the_way() -> None:
    task, world = begun(Thesis(3), OFFICE)
    door = OFFICE.doors["E1"].mean(axis=0)
    for room in (*CLOCKWISE, "ASR1"):
        hop(task, world, *MIDDLE[room])
    assert task.goal == 1
    world.place(Pose(door[0], door[1], 0.0))
    task.step(None, declared=True)
    assert "E1" not in world.shut_doors
    assert task.info()["events"] == ()
    hop(task, world, *MIDDLE["ASR1"])
    assert "E1" in world.shut_doors
    assert task.info()["events"] == ("shut E1",)


def test_experiment_2_goes_anticlockwise_and_home_twice() -> None:
    task, world = begun(Thesis(2), OFFICE)
    for _ in range(2):
        for room in (*CLOCKWISE[::-1], "ASR1"):
            hop(task, world, *MIDDLE[room])
            assert ("E1" in world.shut_doors) == (room == "ASR6")
        assert task.goal == 1
        world.place(OFFICE.home)
        task.step(None, declared=True)
    assert task.succeeded
    assert [r.task for r in task.results] == ["explore", "home", "explore", "home"]


def test_experiment_3_can_be_done_as_the_thesis_did_it() -> None:
    task, world = begun(Thesis(3), OFFICE)

    def visit(*rooms: str, declare: bool = False) -> None:
        for room in rooms:
            hop(task, world, *MIDDLE[room])
        if declare:
            task.step(None, declared=True)

    def home() -> None:
        hop(task, world, OFFICE.home.x, OFFICE.home.y)
        task.step(None, declared=True)

    visit(*CLOCKWISE, "ASR1")
    assert set(task.marks) == {1, 2, 3, 4}
    home()
    visit(*CLOCKWISE[::-1], "ASR1")
    visit("ASR6", "ASR5", declare=True)
    assert world.present_barriers == {"B5"}
    assert world.shut_doors == {"E9", "E10"}
    visit("ASR7", "ASR3", declare=True)
    assert world.present_barriers == frozenset()
    visit("ASR2")
    assert world.shut_doors == {"E1"}
    visit("ASR8", "ASR6", "ASR1")
    home()
    visit("ASR6", "ASR8", "ASR2", declare=True)
    assert task.succeeded
    assert len(task.results) == 7


def test_bad_tasks_and_plans_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="experiment"):
        course_of("thesis", 4)
    with pytest.raises(ValueError, match="experiment"):
        course_of("explore", 1)
    with pytest.raises(ValueError, match="task"):
        course_of("fly", None)
    with pytest.raises(ValueError, match="ASR6"):
        begun(Thesis(1), TWO_ROOMS)
