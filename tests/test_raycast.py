"""The laser kernel against its slow twin, against pymunk, and under the laws it must keep."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cogmap_gym.geometry import NO_SEGMENTS, Array, Pose, Segments
from cogmap_gym.observation import LaserSpec
from cogmap_gym.raycast import RayCaster
from tests.reference import laser_ranges

FEW = settings(max_examples=40, deadline=None)
SQUARE = np.array(
    [[[0, 0], [4, 0]], [[4, 0], [4, 4]], [[4, 4], [0, 4]], [[0, 4], [0, 0]]], dtype=np.float64
)
FULL_CIRCLE = LaserSpec(-math.pi, math.tau / 64, 64, 30.0)


def random_walls(rng: np.random.Generator, count: int, size: float) -> Segments:
    """Walls of about 2 m, one in five four times as long, over a square of side ``size``."""
    start = rng.uniform(0.0, size, (count, 2))
    reach = np.where(np.arange(count) % 5 == 0, 8.0, 2.0)[:, None]
    return np.stack((start, start + reach * rng.normal(0.0, 1.0, (count, 2))), axis=1)


def random_pose(rng: np.random.Generator, size: float) -> Pose:
    x, y = rng.uniform(-0.1 * size, 1.1 * size, 2)
    return Pose(x, y, rng.uniform(-math.pi, math.pi))


@st.composite
def lasers(draw: st.DrawFn) -> LaserSpec:
    """Fans of any width, closed full circles and single beams among them."""
    beams = draw(st.integers(1, 90))
    width = draw(st.sampled_from((0.01, 1.0, math.pi, 5.0, math.tau * (1.0 - 1e-12))))
    first = draw(st.sampled_from((-math.pi, -math.pi / 2, 0.0, 2.5)))
    return LaserSpec(first, width / max(beams - 1, 1), beams, draw(st.sampled_from((3.0, 30.1))))


def bracket(walls: Segments, pose: Pose, laser: LaserSpec) -> tuple[Array, Array]:
    """Ranges between which rounding may decide whether a beam meets an end."""
    low = laser_ranges(walls, pose, laser, slack=1e-7)
    return low, laser_ranges(walls, pose, laser, slack=-1e-7)


@FEW
@given(seed=st.integers(0, 10**6), count=st.integers(0, 60), laser=lasers())
def test_the_kernel_equals_its_slow_twin_on_random_worlds(seed, count, laser):
    rng = np.random.default_rng(seed)
    size = rng.choice((3.0, 30.0, 120.0))
    walls, pose = random_walls(rng, count, size), random_pose(rng, size)
    got = RayCaster(walls).ranges(pose, laser)
    assert got.shape == (laser.beams,)
    np.testing.assert_allclose(got, laser_ranges(walls, pose, laser), rtol=0.0, atol=1e-9)


@FEW
@given(
    numbers=st.lists(st.integers(-6, 6), min_size=4, max_size=60),
    place=st.tuples(st.integers(-12, 12), st.integers(-12, 12), st.integers(0, 7)),
    laser=lasers(),
)
def test_degenerate_worlds_on_a_lattice_are_as_the_twin_sees_them(numbers, place, laser):
    # Collinear, doubled, crossing and zero-length walls; the laser on walls and on ends.
    walls = np.array(numbers[: len(numbers) // 4 * 4], dtype=np.float64).reshape(-1, 2, 2)
    pose = Pose(place[0] / 2.0, place[1] / 2.0, place[2] * math.pi / 4.0)
    got = RayCaster(walls).ranges(pose, laser)
    low, high = bracket(walls, pose, laser)
    assert np.isfinite(got).all()
    assert (got >= low - 1e-6).all()
    assert (got <= high + 1e-6).all()


def test_a_world_of_thousands_of_walls_equals_the_twin_through_its_rings():
    rng = np.random.default_rng(5)
    walls = random_walls(rng, 3000, 150.0)
    caster, laser = RayCaster(walls), LaserSpec(beams=90, step=math.radians(2.0))
    for _ in range(10):
        pose = random_pose(rng, 150.0)
        want = laser_ranges(walls, pose, laser)
        np.testing.assert_allclose(caster.ranges(pose, laser), want, rtol=0.0, atol=1e-9)


def test_a_sparse_world_of_vast_extent_is_cast_in_bounded_memory():
    walls = np.concatenate((SQUARE, SQUARE + 1e6))
    np.testing.assert_allclose(
        RayCaster(walls).ranges(Pose(2.0, 2.0), FULL_CIRCLE),
        laser_ranges(walls, Pose(2.0, 2.0), FULL_CIRCLE),
        atol=1e-9,
    )


def test_the_kernel_sees_what_pymunk_sees():
    rng = np.random.default_rng(7)
    laser = LaserSpec(-math.pi, math.tau / 60, 60, 20.0)
    for _ in range(5):
        walls, pose = random_walls(rng, 60, 25.0), random_pose(rng, 25.0)
        space = pymunk.Space()
        for p, q in walls.tolist():
            space.add(pymunk.Segment(space.static_body, p, q, 0.0))
        want = []
        for angle in (pose.theta + laser.angles).tolist():
            end = pose.x + 20.0 * math.cos(angle), pose.y + 20.0 * math.sin(angle)
            hit = space.segment_query_first((pose.x, pose.y), end, 0.0, pymunk.ShapeFilter())
            want.append(20.0 * hit.alpha if hit else 20.0)
        np.testing.assert_allclose(RayCaster(walls).ranges(pose, laser), want, atol=1e-6)


@FEW
@given(seed=st.integers(0, 10**6))
def test_moving_world_and_laser_together_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    walls, pose = random_walls(rng, 30, 20.0), random_pose(rng, 20.0)
    moved_from_here = Pose(*rng.uniform(-50.0, 50.0, 2), rng.uniform(-math.pi, math.pi))
    here = RayCaster(walls).ranges(pose, FULL_CIRCLE)
    there = RayCaster(moved_from_here.apply(walls)).ranges(moved_from_here @ pose, FULL_CIRCLE)
    np.testing.assert_allclose(there, here, rtol=0.0, atol=1e-8)


@FEW
@given(seed=st.integers(0, 10**6))
def test_the_order_of_rows_and_of_ends_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    walls, pose = random_walls(rng, 40, 20.0), random_pose(rng, 20.0)
    want = RayCaster(walls).ranges(pose, FULL_CIRCLE)
    shuffled = RayCaster(walls[rng.permutation(40)]).ranges(pose, FULL_CIRCLE)
    np.testing.assert_array_equal(shuffled, want)
    turned = RayCaster(walls[:, ::-1]).ranges(pose, FULL_CIRCLE)
    np.testing.assert_allclose(turned, want, rtol=0.0, atol=1e-9)


def test_an_empty_world_reads_range_max_everywhere():
    laser = LaserSpec(range_max=8.1)
    assert (RayCaster(NO_SEGMENTS).ranges(Pose(3.0, 4.0, 1.0), laser) == 8.1).all()


def test_walls_at_and_beyond_range_max_are_no_return():
    wall = np.array([[[8.1, -1.0], [8.1, 1.0]]])
    assert RayCaster(wall).ranges(Pose(), LaserSpec(0.0, 0.1, 1, 8.1))[0] == 8.1
    assert RayCaster(wall).ranges(Pose(), LaserSpec(0.0, 0.1, 1, 8.0))[0] == 8.0
    assert RayCaster(wall).ranges(Pose(), LaserSpec(0.0, 0.1, 1, 9.0))[0] == pytest.approx(8.1)


def test_a_laser_far_outside_the_world_sees_its_near_side():
    got = RayCaster(SQUARE).ranges(Pose(-20.0, 2.0), LaserSpec(0.0, 0.1, 1, 100.0))
    assert got[0] == pytest.approx(20.0, abs=1e-12)
    assert RayCaster(SQUARE).ranges(Pose(-1e7, 2.0), LaserSpec(0.0, 0.1, 1, 100.0))[0] == 100.0


@FEW
@given(
    x=st.floats(0.1, 3.9), y=st.floats(0.1, 3.9), corner=st.integers(0, 3), turn=st.floats(-9, 9)
)
def test_no_beam_leaks_through_a_corner(x, y, corner, turn):
    turned = Pose(0.3, -0.7, turn)
    walls, here = turned.apply(SQUARE), turned.apply(np.array((x, y)))
    toward = walls[corner, 0] - here
    at_corner = LaserSpec(math.atan2(toward[1], toward[0]), 1e-16, 3, 30.0)
    got = RayCaster(walls).ranges(Pose(here[0], here[1]), at_corner)
    np.testing.assert_allclose(got, math.hypot(*toward), atol=1e-7)


@pytest.mark.parametrize("turn", np.linspace(-math.pi, math.pi, 9).tolist())
def test_inside_a_closed_room_every_beam_of_a_full_circle_returns(turn):
    closed = LaserSpec(-math.pi, math.tau / 16, 17, 30.0)
    got = RayCaster(SQUARE).ranges(Pose(2.0, 2.0, turn), closed)
    np.testing.assert_allclose(got, laser_ranges(SQUARE, Pose(2.0, 2.0, turn), closed), atol=1e-9)
    assert got.max() <= math.sqrt(8.0) + 1e-9


def test_a_laser_on_a_wall_or_on_its_end_reads_zero_and_never_nan():
    for x in (0.0, 1.0, 4.0):
        assert (RayCaster(SQUARE).ranges(Pose(x, 0.0, 0.3), FULL_CIRCLE) == 0.0).all()


def test_an_edge_on_wall_shows_its_nearer_end():
    wall = np.array([[[5.0, 0.0], [2.0, 0.0]]])
    got = RayCaster(wall).ranges(Pose(), LaserSpec(-0.1, 0.1, 3, 30.0))
    assert got.tolist() == [30.0, pytest.approx(2.0), 30.0]


@FEW
@given(seed=st.integers(0, 10**6))
def test_toggled_doors_equal_a_world_built_anew(seed):
    rng = np.random.default_rng(seed)
    walls, doors = random_walls(rng, 20, 12.0), random_walls(rng, 6, 12.0)
    caster, pose = RayCaster(walls, doors), random_pose(rng, 12.0)
    assert not caster.solid.any()
    for _ in range(4):
        solid = rng.random(6) < 0.5
        for row, shut in enumerate(solid.tolist()):
            caster.set_solid(row, shut)
        assert caster.solid.tolist() == solid.tolist()
        anew = RayCaster(np.concatenate((walls, doors[solid])))
        got, want = caster.ranges(pose, FULL_CIRCLE), anew.ranges(pose, FULL_CIRCLE)
        np.testing.assert_array_equal(got, want)


def test_solid_is_a_copy_and_rows_are_checked():
    caster = RayCaster(NO_SEGMENTS, SQUARE)
    caster.solid[:] = True
    assert not caster.solid.any()
    for row in (-1, 4):
        with pytest.raises(IndexError, match="row"):
            caster.set_solid(row, True)


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda c: pickle.loads(pickle.dumps(c))])
def test_copies_and_pickles_see_the_same_and_toggle_apart(clone):
    caster = RayCaster(SQUARE, np.array([[[2.0, 0.0], [2.0, 4.0]]]))
    caster.set_solid(0, True)
    before = caster.ranges(Pose(1.0, 1.0), FULL_CIRCLE)
    other = clone(caster)
    np.testing.assert_array_equal(other.ranges(Pose(1.0, 1.0), FULL_CIRCLE), before)
    other.set_solid(0, False)
    np.testing.assert_array_equal(caster.ranges(Pose(1.0, 1.0), FULL_CIRCLE), before)
    assert other.ranges(Pose(1.0, 1.0), FULL_CIRCLE).max() > before.max()


def test_every_call_returns_fresh_memory_and_the_fan_may_change_between_calls():
    caster = RayCaster(SQUARE)
    first = caster.ranges(Pose(1.0, 1.0), FULL_CIRCLE)
    kept = first.copy()
    assert caster.ranges(Pose(1.0, 1.0), LaserSpec()).shape == (360,)
    again = caster.ranges(Pose(1.0, 1.0), FULL_CIRCLE)
    first[:] = -1.0
    np.testing.assert_array_equal(again, kept)


@pytest.mark.parametrize(
    "walls", [np.zeros((3, 4)), np.array([[[0.0, math.nan], [1.0, 1.0]]]), np.zeros((0, 4))]
)
def test_bad_walls_are_refused_by_name(walls):
    with pytest.raises(ValueError, match="walls"):
        RayCaster(walls)
