"""Gaps and exits of a view: Algorithm 2 and doorways, in hand-built rooms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from agents.cogmap.bounded_space import Openings, openings
from agents.cogmap.lines import extract_view
from agents.cogmap.params import Gaps, Lines
from agents.cogmap.view import EMPTY_VIEW, View
from cogmap_gym.geometry import Pose, Segments, lengths, segments_cross
from cogmap_gym.observation import LaserSpec

LASER = LaserSpec()
DEFAULT = Gaps()
LITERAL = replace(Gaps(), literal=True)


def boxes(*corners: tuple[float, float, float, float]) -> Segments:
    """The outlines of axis-parallel boxes (x0, y0, x1, y1)."""
    sides = [
        ((a, b), (c, d))
        for x0, y0, x1, y1 in corners
        for (a, b), (c, d) in (
            ((x0, y0), (x1, y0)),
            ((x1, y0), (x1, y1)),
            ((x1, y1), (x0, y1)),
            ((x0, y1), (x0, y0)),
        )
    ]
    return np.array(sides, dtype=np.float64)


def scan(walls: Segments, pose: Pose, rng: np.random.Generator) -> np.ndarray:
    """Ranges of a laser at a pose, with the noise of the SICK LMS-200."""
    angles = pose.theta + LASER.angles
    d = np.stack((np.cos(angles), np.sin(angles)), axis=-1)[:, None]
    p, r = walls[:, 0] - pose.position, walls[:, 1] - walls[:, 0]
    denominator = d[..., 0] * r[:, 1] - d[..., 1] * r[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (p[:, 0] * r[:, 1] - p[:, 1] * r[:, 0]) / denominator
        u = (p[:, 0] * d[..., 1] - p[:, 1] * d[..., 0]) / denominator
    hit = np.where((u >= 0) & (u <= 1) & (t > 0), t, LASER.range_max).min(axis=1)
    return hit + rng.normal(0.0, LASER.sd, hit.shape)


def look(walls: Segments, pose: Pose, seed: int = 0) -> View:
    """The view at a pose."""
    return extract_view(scan(walls, pose, np.random.default_rng(seed)), LASER, Lines())


def seen(walls: Segments, pose: Pose, params: Gaps = DEFAULT) -> Openings:
    """The openings at a pose."""
    return openings(look(walls, pose), params)


# Two rooms of 6 x 6 m with a doorway of 0.9 m in the wall of 0.2 m between them.
ROOMS = boxes(
    (-0.2, -0.2, 12.4, 0.0),
    (-0.2, 6.0, 12.4, 6.2),
    (-0.2, 0.0, 0.0, 6.0),
    (12.2, 0.0, 12.4, 6.0),
    (6.0, 0.0, 6.2, 2.5),
    (6.0, 3.4, 6.2, 6.0),
)
DOOR = np.array((6.1, 2.95))
DESK = boxes((3.0, 4.2, 4.6, 5.0))


@pytest.mark.parametrize(
    ("x", "y"),
    [(1.2, 3.0), (3.0, 1.0), (3.0, 5.0), (4.9, 2.9), (5.4, 2.7), (8.0, 4.0), (10.5, 2.0)],
)
def test_a_doorway_is_found_at_one_place_from_both_rooms(x: float, y: float) -> None:
    pose = Pose(x, y, math.atan2(DOOR[1] - y, DOOR[0] - x))
    exits = pose.apply(seen(ROOMS, pose).exits)
    assert exits.shape == (1, 2, 2)
    assert np.hypot(*(exits[0].mean(axis=0) - DOOR)) < 0.15
    assert lengths(exits)[0] == pytest.approx(0.9, abs=0.08)
    assert abs(exits[0, 1, 0] - exits[0, 0, 0]) < 0.1


def test_an_exit_runs_from_right_to_left_so_that_the_robot_is_on_its_left() -> None:
    exits = seen(ROOMS, Pose(3.0, 2.95, 0.0)).exits
    assert exits[0, 0, 1] < 0.0 < exits[0, 1, 1]


@pytest.mark.parametrize("seed", range(5))
def test_a_door_in_the_corner_of_a_room_is_found(seed: int) -> None:
    walls = boxes(
        (-0.2, -0.2, 10.0, 0.0),
        (-0.2, 6.0, 10.0, 6.2),
        (-0.2, 0.0, 0.0, 6.0),
        (9.8, 0.0, 10.0, 6.0),
        (5.0, 0.0, 5.2, 5.1),
    )
    pose = Pose(2.5, 4.5, math.radians(15.0))
    exits = pose.apply(openings(look(walls, pose, seed), Gaps()).exits)
    assert exits.shape == (1, 2, 2)
    assert np.hypot(*(exits[0].mean(axis=0) - (5.1, 5.55))) < 0.15


def test_both_ends_of_a_corridor_keep_their_doors() -> None:
    walls = boxes(
        (0.0, 1.0, 12.0, 1.2),
        (0.0, -1.2, 12.0, -1.0),
        (8.0, 0.45, 8.2, 1.0),
        (8.0, -1.0, 8.2, -0.45),
        (12.0, -1.2, 12.2, 1.2),
        (-0.2, -1.2, 0.0, 1.2),
    )
    pose = Pose(4.0, 0.2, 0.0)
    exits = pose.apply(seen(walls, pose).exits)
    assert exits.shape == (1, 2, 2)
    assert np.hypot(*(exits[0].mean(axis=0) - (8.1, 0.0))) < 0.15


@pytest.mark.parametrize(
    "furniture",
    [
        boxes((3.5, 1.0, 4.3, 2.6)),
        boxes((3.5, 0.9, 4.3, 2.6), (3.5, 3.4, 4.3, 5.0)),
        boxes((3.5, 2.0, 3.9, 2.4), (3.5, 3.2, 3.9, 3.6)),
        boxes((5.5, 0.0, 6.0, 2.0), (5.5, 2.8, 6.0, 6.0)),
    ],
    ids=["a desk", "two desks in a row", "two pillars", "a niche between cupboards"],
)
def test_furniture_makes_no_exit(furniture: Segments) -> None:
    room = boxes(
        (-0.2, -0.2, 6.2, 0.0), (-0.2, 6.0, 6.2, 6.2), (-0.2, 0.0, 0.0, 6.0), (6.0, 0.0, 6.2, 6.0)
    )
    for heading in (-30.0, 0.0, 30.0):
        pose = Pose(1.0, 3.0, math.radians(heading))
        assert not len(seen(np.concatenate((room, furniture)), pose).exits)


def test_a_shut_door_in_its_recess_is_no_exit() -> None:
    shut = np.concatenate((ROOMS, np.array([[(6.1, 2.5), (6.1, 3.4)]])))
    assert not len(seen(shut, Pose(3.0, 2.95, 0.0)).exits)


def test_openings_do_not_depend_on_the_frame() -> None:
    view = look(np.concatenate((ROOMS, DESK)), Pose(1.5, 2.0, 0.3))
    moved = Pose(7.0, -3.0, 2.5)
    other = replace(view, points=moved.apply(view.points), surfaces=moved.apply(view.surfaces))
    for params in (Gaps(), LITERAL):
        a, b = openings(view, params), openings(other, params, moved.position)
        np.testing.assert_allclose(moved.apply(a.exits), b.exits, atol=1e-9)
        np.testing.assert_allclose(moved.apply(a.gaps), b.gaps, atol=1e-9)
        np.testing.assert_array_equal(a.occluding, b.occluding)


def test_a_mirrored_view_has_mirrored_openings() -> None:
    view = look(np.concatenate((ROOMS, DESK)), Pose(1.5, 2.0, 0.3))
    flip = np.array((1.0, -1.0))
    beams = len(view.points) - 1 - view.beams[::-1, ::-1]
    mirrored = View(
        view.points[::-1] * flip,
        view.surfaces[::-1, ::-1] * flip,
        view.physical[::-1, ::-1],
        view.spacing[::-1, ::-1],
        beams,
        view.hits[::-1],
    )
    a, b = openings(view, Gaps()), openings(mirrored, Gaps())
    np.testing.assert_allclose(a.exits[::-1, ::-1] * flip, b.exits, atol=1e-9)
    np.testing.assert_allclose(a.gaps[::-1, ::-1] * flip, b.gaps, atol=1e-9)


@pytest.mark.parametrize("params", [Gaps(), LITERAL])
def test_an_empty_view_has_no_openings(params: Gaps) -> None:
    found = openings(EMPTY_VIEW, params)
    assert found.gaps.shape == found.exits.shape == (0, 2, 2)
    assert found.occluding.shape == (0, 2)


def hand_view(*surfaces: tuple[tuple[float, float], tuple[float, float]]) -> View:
    """A view of given surfaces, ten beams each and one beam that hits nothing between them."""
    rows = np.array(surfaces, dtype=np.float64)
    t = np.linspace(0.0, 1.0, 10)[:, None]
    points, beams = [], []
    for start, end in rows:
        beams.append((len(points), len(points) + 9))
        points.extend([*(start + t * (end - start)), np.full(2, np.nan)])
    return View(
        np.array(points[:-1]),
        rows,
        np.ones((len(rows), 2), np.bool_),
        np.full((len(rows), 2), 0.1),
        np.array(beams),
        np.full(len(rows), 10),
    )


# Two walls before the robot with a third one behind the space between them.
PASSAGE = hand_view(((3.0, -4.0), (3.0, -1.0)), ((6.0, -0.5), (6.0, 0.5)), ((3.0, 1.0), (3.0, 4.0)))


def test_figure_3_5_two_gaps_become_the_nearer_gap_that_covers_them() -> None:
    for params in (Gaps(), LITERAL):
        found = openings(PASSAGE, params)
        np.testing.assert_allclose(found.gaps, [[(3.0, -1.0), (3.0, 1.0)]])
        assert found.occluding.all()


def test_figure_3_7_merging_brings_out_an_exit_in_the_literal_form() -> None:
    view = hand_view(((3.0, -4.0), (3.0, -0.5)), ((9.0, 0.0), (9.0, 0.8)), ((3.0, 0.5), (3.0, 4.0)))
    found = openings(view, LITERAL)
    np.testing.assert_allclose(found.exits, [[(3.0, -0.5), (3.0, 0.5)]])
    assert not len(found.gaps)


def test_figure_3_4_a_gap_outside_the_bounded_space_is_not_made() -> None:
    view = hand_view(
        ((5.0, -4.0), (5.0, -2.0)), ((3.0, -0.5), (3.0, 0.5)), ((5.0, 2.0), (5.0, 4.0))
    )
    for params in (Gaps(), LITERAL):
        assert len(openings(view, params).gaps) == 2


def test_the_default_form_covers_gaps_that_are_not_neighbours() -> None:
    view = hand_view(
        ((3.0, -4.0), (3.0, -1.0)),
        ((7.0, -1.0), (7.0, -0.7)),
        ((8.0, 0.0), (8.0, 0.3)),
        ((9.0, 1.5), (9.0, 1.9)),
        ((3.0, 1.0), (3.0, 4.0)),
    )
    assert len(openings(view, Gaps()).gaps) == 1


def test_no_gap_crosses_a_surface_and_every_gap_can_be_crossed() -> None:
    rng = np.random.default_rng(7)
    walls = np.concatenate((ROOMS, DESK))
    for _ in range(20):
        pose = Pose(rng.uniform(0.5, 5.5), rng.uniform(0.5, 4.0), rng.uniform(-3.0, 3.0))
        view = look(walls, pose)
        found = openings(view, Gaps())
        assert (lengths(found.gaps) > 0.6).all()
        assert not segments_cross(found.gaps, view.surfaces * 0.98).all(axis=1).any()
        assert found.occluding.shape == (len(found.gaps), 2)


def test_what_is_behind_an_exit_is_no_gap() -> None:
    found = seen(ROOMS, Pose(3.0, 2.95, 0.0))
    assert len(found.exits) == 1
    assert not (found.gaps[:, :, 0] > 3.4).all(axis=1).any()


def test_garbage_scans_are_answered_without_complaint() -> None:
    rng = np.random.default_rng(11)
    for k in range(30):
        ranges = rng.uniform(0.0, 4.0, LASER.beams) * (1.0 if k % 2 else rng.integers(0, 2))
        ranges[rng.random(LASER.beams) < 0.2] = math.nan
        view = extract_view(np.repeat(ranges[::8], 8), LASER, Lines())
        for params in (DEFAULT, LITERAL):
            assert np.isfinite(openings(view, params).exits).all()
