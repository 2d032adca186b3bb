"""Closing a loop by association: a known place is recognised on evidence that tells it apart."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.cogmap.association import Beams, Hypothesis, best_hypothesis
from agents.cogmap.params import Association
from cogmap_gym.geometry import Pose, Segments
from tests.rooms import corridor, l_room, room_with_pillar
from tests.simulated import scan, segments, solid, view_of

P = Association()
ROOM = solid(room_with_pillar())
INSIDE = (Pose(1.2, 1.1, 0.3), Pose(1.8, 1.3, 0.8), Pose(1.6, 3.8, 0.1))
FAR = 90.0
"""Metres since the place was left: a lap."""


def faces(walls: Segments, poses: tuple[Pose, ...] = INSIDE) -> Segments:
    """The surfaces of a place as its robot saw them, directed, in the plan's frame."""
    views = (pose.apply(view_of(walls, pose).surfaces) for pose in poses)
    return np.concatenate(list(views))


def beams_of(walls: Segments, poses: tuple[Pose, ...] = INSIDE, drift: Pose | None = None) -> Beams:
    """Beams seen from ``poses``, laid where a robot with this drift believes them."""
    rng, origins, ends = np.random.default_rng(0), [], []
    for pose in poses:
        points = view_of(walls, pose, rng=rng).points
        points = points[np.isfinite(points).all(axis=1)]
        origins.append(np.broadcast_to(pose.position, points.shape))
        ends.append(pose.apply(points))
    believed = drift or Pose()
    return Beams(np.concatenate(origins), np.concatenate(ends)).moved(believed)


def found(place: Segments, beams: Beams, travelled: float = FAR) -> Hypothesis:
    return best_hypothesis(3, place, beams, travelled, P)


def residual(hypothesis: Hypothesis, drift: Pose) -> tuple[float, float]:
    """What is left of the drift after the shift, at the middle of the stay [m, rad]."""
    left, at = hypothesis.shift @ drift, np.array((1.5, 2.0))
    return float(np.hypot(*(left.apply(at) - at))), abs(left.theta)


def test_without_drift_the_place_is_recognised_where_it_is() -> None:
    hypothesis = found(faces(ROOM), beams_of(ROOM))
    assert hypothesis.place == 3
    assert hypothesis.holds(P)
    assert residual(hypothesis, Pose()) < (0.08, 0.03)


@pytest.mark.parametrize(
    "drift", [Pose(0.6, -0.4, 0.04), Pose(-0.7, 0.5, -0.05), Pose(0.0, 0.9, 0.0)], ids=repr
)
def test_the_drift_of_a_lap_is_found(drift: Pose) -> None:
    hypothesis = found(faces(ROOM), beams_of(ROOM, drift=drift))
    assert hypothesis.holds(P)
    metres, radians = residual(hypothesis, drift)
    assert metres < 0.12
    assert radians < 0.03


def test_drift_beyond_what_the_way_allows_is_not_found() -> None:
    drift = Pose(1.5, -1.0, 0.0)
    near = found(faces(ROOM), beams_of(ROOM, drift=drift), travelled=5.0)
    shift = near.shift.apply(drift.apply(np.array((1.5, 2.0)))) - drift.apply(np.array((1.5, 2.0)))
    assert np.abs(shift).max() < 2.0 * (P.base_shift + 5.0 * P.shift_per_metre)
    assert not near.holds(P)


def test_another_place_is_not_taken_for_the_known_one() -> None:
    hypothesis = found(faces(ROOM), beams_of(solid(corridor(12.0, 2.0)), (Pose(2.0, 1.0, 0.0),)))
    right = found(faces(ROOM), beams_of(ROOM))
    assert not hypothesis.holds(P)
    assert hypothesis.coverage < right.coverage - P.margin


def test_a_wall_that_beams_go_through_speaks_against_the_place() -> None:
    pose = (Pose(1.0, 1.0, 0.0),)
    long = segments((0, 0, 8, 0), (8, 0, 8, 2), (8, 2, 0, 2))
    short = segments((0, 0, 4, 0), (4, 0, 4, 2), (4, 2, 0, 2))
    right = found(faces(short, pose), beams_of(short, pose), 1.0)
    wrong = found(faces(short, pose), beams_of(long, pose), 1.0)
    assert right.contradiction < 0.02
    assert wrong.contradiction > P.max_contradiction


def test_what_stands_in_front_of_a_wall_speaks_not_against_it() -> None:
    ranges = scan(ROOM, INSIDE[0])
    assert np.isfinite(ranges).all()
    person = segments((1.9, 1.2, 1.9, 1.5), (1.9, 1.5, 2.1, 1.5))
    hypothesis = found(faces(ROOM), beams_of(np.concatenate((ROOM, person))))
    assert hypothesis.contradiction < 0.05


def test_a_place_without_surfaces_is_never_recognised() -> None:
    none = np.zeros((0, 2, 2))
    hypothesis = found(none, beams_of(ROOM))
    assert not hypothesis.holds(P)
    assert hypothesis.coverage == 0.0


def test_the_order_of_surfaces_and_beams_does_not_matter() -> None:
    place, beams = faces(ROOM), beams_of(ROOM, drift=Pose(0.5, 0.3, 0.03))
    here = found(place, beams)
    there = found(place[::-1], beams)
    assert here.shift == there.shift
    assert here.coverage == there.coverage


@settings(max_examples=8)
@given(theta=st.floats(-math.pi, math.pi), x=st.floats(-30.0, 30.0), y=st.floats(-30.0, 30.0))
def test_recognition_does_not_depend_on_where_the_origin_is(
    theta: float, x: float, y: float
) -> None:
    moved, drift = Pose(x, y, theta), Pose(0.6, -0.4, 0.04)
    walls = solid(l_room())
    poses = (Pose(1.5, 1.5, 0.3), Pose(2.5, 1.8, 0.9))
    place, beams = faces(walls, poses), beams_of(walls, poses, drift)
    there = found(moved.apply(place), beams.moved(moved))
    assert there.holds(P)
    back = moved.inverse() @ there.shift @ moved
    assert residual(Hypothesis(3, back, 1.0, 0.0, 0.0), drift) < (0.15, 0.03)


def test_an_old_surface_is_not_moved_by_the_search() -> None:
    place, beams = faces(ROOM), beams_of(ROOM, drift=Pose(0.5, 0.3, 0.03))
    before = place.copy(), beams.ends.copy()
    found(place, beams)
    assert (place == before[0]).all()
    assert (beams.ends == before[1]).all()


def test_a_fit_is_sure_only_if_it_is_good_and_near() -> None:
    def fit(coverage: float, contradiction: float, distance: float) -> bool:
        return Hypothesis(3, Pose(), coverage, contradiction, distance).sure(P)

    good, few, near = P.sure_coverage, P.sure_contradiction, P.base_shift
    assert fit(good, few, near)
    assert not fit(good - 0.01, few, near)
    assert not fit(good, few + 0.01, near)
    assert not fit(good, few, near + 0.01)


@pytest.mark.parametrize("turn", [0.0, 0.25, 0.5, 0.75])
def test_the_drift_allowed_is_as_large_in_every_direction(turn: float) -> None:
    drift = Pose(1.5 * math.cos(turn * math.pi), 1.5 * math.sin(turn * math.pi), 0.0)
    hypothesis = found(faces(ROOM), beams_of(ROOM, drift=drift), travelled=5.0)
    reach = P.base_shift + 5.0 * P.shift_per_metre
    assert hypothesis.distance <= reach + 2.0 * P.search_step
    assert not hypothesis.holds(P) or not hypothesis.sure(P)
