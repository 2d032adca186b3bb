"""The MFIS: normalisation (thesis 3.4) and Algorithm 5. Old surfaces only lengthen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from agents.cogmap.mfis import (
    EMPTY_MFIS,
    FORGOTTEN,
    MFIS,
    Edit,
    enter,
    normalise,
    recognise,
    tag,
    transfer,
    without_dead,
)
from agents.cogmap.params import Landmarks, Transfer
from agents.cogmap.view import EMPTY_VIEW, View
from cogmap_gym.geometry import Pose, Segments, lengths
from tests.simulated import same_rows, segments

LITERAL = Transfer(literal=True)
ANGLES = st.floats(-math.pi, math.pi)
METRES = st.floats(-20.0, 20.0)


NO_PAIRS = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Done:
    """What a view whose surfaces are all in good sight did to the map."""

    mfis: MFIS
    ids: NDArray[np.int64]
    edits: list[Edit]


def seen(surfaces: Segments, physical: bool = False, hits: int = 10000) -> View:
    """A view that rests on this many beams a surface."""
    count = len(surfaces)
    return View(
        np.zeros((0, 2)),
        surfaces,
        np.full((count, 2), physical),
        np.full((count, 2), 0.01),
        np.zeros((count, 2), dtype=np.int64),
        np.full(count, hits),
    )


def entered(
    surfaces: Segments | View,
    mfis: MFIS = EMPTY_MFIS,
    pose: Pose | None = None,
    params: Transfer | None = None,
    physical: bool = False,
) -> Done:
    """Algorithm 5 for a view none of whose surfaces is a landmark yet."""
    view = surfaces if isinstance(surfaces, View) else seen(surfaces, physical)
    count, params, pose = len(view.surfaces), params or Transfer(), pose or Pose()
    landmarks = Landmarks(literal=params.literal)
    none, rows = np.zeros(count, dtype=np.int64), np.arange(len(mfis))
    mfis, ids = transfer(view, mfis, none, [pose] * count, rows, 7, params, landmarks)
    mfis, edits = enter(view, mfis, NO_PAIRS, pose, 7, params)
    return Done(mfis, ids, list(edits))


def lengthened(
    known: Segments,
    surfaces: Segments,
    physical: tuple[bool, bool] = (False, False),
    params: Transfer | None = None,
) -> Segments:
    """The map after a view from its origin that shows ``surfaces`` as each of ``known``."""
    mfis = entered(known, physical=physical[0]).mfis
    i, j = np.meshgrid(np.arange(len(surfaces)), np.arange(len(known)), indexing="ij")
    pairs = np.stack((i.ravel(), j.ravel()), axis=-1)
    after, edits = normalise(
        seen(surfaces, physical[1]), mfis, pairs, Pose(), 8, params or Transfer()
    )
    changed = {e.id for e in edits}
    assert all((after.surfaces[e.id - 1] == e.after).all() for e in edits if e is edits[-1])
    unchanged = np.array([k + 1 not in changed for k in range(len(known))])
    assert (after.surfaces[unchanged] == known[unchanged]).all()
    return after.surfaces


def test_the_first_view_is_entered_as_it_is_and_named_from_one() -> None:
    surfaces, pose = segments((0, 0, 3, 0), (3, 0, 3, 2)), Pose(1.0, 2.0, 0.3)
    done = entered(surfaces, pose=pose)
    assert done.ids.tolist() == [1, 2]
    assert done.mfis.ids.tolist() == [1, 2]
    assert done.mfis.surfaces == pytest.approx(pose.apply(surfaces))
    assert done.mfis.born.tolist() == done.mfis.seen.tolist() == [7, 7]
    assert [e.before for e in done.edits] == [None, None]


def test_what_is_small_or_rests_on_few_beams_does_not_enter() -> None:
    assert len(entered(segments((0, 0, 0.45, 0))).mfis) == 0
    done = entered(seen(segments((0, 0, 3, 0)), hits=4))
    assert done.ids.tolist() == [0]
    assert len(done.mfis) == 0


def test_a_surface_whose_heading_is_not_known_stays_out_but_not_as_written() -> None:
    view = seen(segments((0, 0, 0.5, 0)), hits=5)
    doubtful = replace(Transfer(), max_heading_sd=0.04)
    for params, count in ((doubtful, 0), (replace(doubtful, literal=True), 1)):
        assert len(entered(view, params=params).mfis) == count


def test_a_surface_waits_in_the_buffer_until_its_heading_is_known_well() -> None:
    glimpse, square = seen(segments((0, 0, 0.6, 0.02)), hits=12), seen(segments((0, 0, 3, 0)))
    first = entered(glimpse)
    assert len(first.mfis) == 1
    assert not first.edits
    mfis, edits = enter(square, first.mfis, np.array([[0, 0]]), Pose(), 7, Transfer())
    assert [(e.id, e.before) for e in edits] == [(1, None)]
    assert mfis.surfaces == pytest.approx(segments((0, 0, 3, 0)))
    worse, edits = enter(glimpse, mfis, np.array([[0, 0]]), Pose(), 8, Transfer())
    assert (worse.surfaces == mfis.surfaces).all(), "what is entered never turns"
    assert not edits


def test_a_surface_that_goes_out_of_sight_is_entered_as_it_was_seen_best() -> None:
    first = entered(seen(segments((0, 0, 0.6, 0.02)), hits=12))
    mfis, edits = enter(EMPTY_VIEW, first.mfis, NO_PAIRS, Pose(), 8, Transfer())
    assert [(e.id, e.sighted) for e in edits] == [(1, 7)]
    assert mfis.surfaces == pytest.approx(first.mfis.surfaces)


def test_as_written_a_surface_is_entered_at_first_sight() -> None:
    assert len(entered(seen(segments((0, 0, 0.6, 0.02)), hits=12), params=LITERAL).edits) == 1


def test_step_4_what_intersects_a_known_surface_is_left_out() -> None:
    mfis = entered(segments((0, 0, 4, 0))).mfis
    done = entered(segments((2, -1, 2, 1)), mfis)
    assert done.ids.tolist() == [0]
    assert len(done.mfis) == 1


def test_step_4_a_corner_is_no_intersection_but_as_written_it_is() -> None:
    mfis = entered(segments((0, 0, 4, 0))).mfis
    corner = segments((3.9, -0.1, 3.9, 3))
    assert entered(corner, mfis).ids.tolist() == [2]
    assert entered(corner, mfis, params=LITERAL).ids.tolist() == [0]


def test_step_5_what_is_known_gets_its_old_id_and_is_not_entered_twice() -> None:
    mfis = entered(segments((0, 0, 4, 0), (0, 3, 4, 3))).mfis
    done = entered(segments((0.5, 0.1, 3, 0.12), (5, 0, 5, 3)), mfis)
    assert done.ids.tolist() == [1, 3]
    assert len(done.mfis) == 3
    assert done.mfis.surfaces[:2].tolist() == mfis.surfaces.tolist()


@pytest.mark.parametrize("params", [Transfer(), LITERAL], ids=["default", "literal"])
def test_a_view_entered_twice_is_entered_once(params: Transfer) -> None:
    surfaces = segments((0, 0, 3, 0), (3.2, 0, 3.2, 2), (0, 4, -2, 4))
    once = entered(surfaces, params=params)
    twice = entered(surfaces, once.mfis, params=params)
    assert len(twice.mfis) == 3
    assert not twice.edits
    assert params.literal or twice.ids.tolist() == [1, 2, 3]


def test_landmarks_keep_their_ids_and_only_the_rest_is_transferred() -> None:
    mfis = entered(segments((0, 0, 4, 0))).mfis
    view = seen(segments((0, 9, 4, 9), (5, 0, 5, 3)))
    rows = np.zeros(1, dtype=np.int64)
    frames = [Pose()] * 2
    after, ids = transfer(view, mfis, np.array([1, 0]), frames, rows, 3, Transfer(), Landmarks())
    assert ids.tolist() == [1, 2]
    assert after.surfaces[1:] == pytest.approx(view.surfaces[1:])


def test_each_surface_is_entered_by_its_own_frame() -> None:
    view = seen(segments((0, 0, 4, 0), (0, 3, 4, 3)))
    frames, none = [Pose(1.0, 0.0, 0.0), Pose(0.0, 2.0, 0.0)], np.zeros(2, dtype=np.int64)
    mfis, _ = transfer(view, EMPTY_MFIS, none, frames, none[:0], 3, Transfer(), Landmarks())
    assert mfis.surfaces == pytest.approx(segments((1, 0, 5, 0), (0, 5, 4, 5)))


def test_an_empty_view_changes_nothing() -> None:
    mfis = entered(segments((0, 0, 4, 0))).mfis
    done = entered(EMPTY_VIEW, mfis)
    assert (done.mfis.surfaces == mfis.surfaces).all()
    assert done.ids.shape == (0,)
    after, edits = normalise(EMPTY_VIEW, mfis, NO_PAIRS, Pose(), 3, Transfer())
    assert (after.surfaces == mfis.surfaces).all()
    assert edits == []


def test_figure_3_16_a_surface_is_lengthened_to_what_is_seen_of_it_along_its_own_line() -> None:
    after = lengthened(segments((0, 0, 4, 0)), segments((-1, 0.1, 6, 0.2)))
    assert after == pytest.approx(segments((-1, 0, 6, 0)))


def test_figure_3_16_a_surface_of_which_less_is_seen_keeps_its_length() -> None:
    known = segments((0, 0, 4, 0))
    assert (lengthened(known, segments((1, 0.1, 3, 0.1))) == known).all()


def test_a_surface_does_not_grow_by_the_noise_of_an_end() -> None:
    known = segments((0, 0, 4, 0))
    assert (lengthened(known, segments((-0.04, 0, 4.04, 0))) == known).all()


def test_as_written_a_surface_grows_by_whatever_is_seen_of_it() -> None:
    seen = segments((-0.04, 0, 4.04, 0))
    after = lengthened(segments((0, 0, 4, 0)), seen, (True, False), LITERAL)
    assert after == pytest.approx(seen)


def test_the_end_of_a_wall_moves_only_for_as_much_as_is_no_noise() -> None:
    known = segments((0, 0, 4, 0))
    assert (lengthened(known, segments((0, 0, 4.2, 0)), (True, False)) == known).all()
    grown = lengthened(known, segments((0, 0, 4.4, 0)), (True, False))
    assert grown == pytest.approx(segments((0, 0, 4.4, 0)))


def test_a_surface_stops_where_the_next_on_its_line_begins() -> None:
    known = segments((0, 0, 2, 0), (3, 0, 5, 0), (6, 0, 7, 0))
    after = lengthened(known, segments((-1, 0, 8, 0)))
    assert (after[:, :, 1] == 0.0).all()
    spans = after[np.argsort(after[:, 0, 0]), :, 0]
    assert spans[0, 0] == -1.0
    assert spans[-1, 1] == 8.0
    assert (spans[1:, 0] >= spans[:-1, 1] - 1e-9).all()


@given(
    theta=ANGLES,
    x=METRES,
    y=METRES,
    low=st.floats(-3.0, 3.9),
    size=st.floats(0.1, 9.0),
    off=st.floats(-0.3, 0.3),
    ends=st.tuples(st.booleans(), st.booleans()),
)
def test_a_surface_only_lengthens_along_its_own_line_wherever_the_origin_is(
    theta: float, x: float, y: float, low: float, size: float, off: float, ends: tuple[bool, bool]
) -> None:
    moved = Pose(x, y, theta)
    known = moved.apply(segments((0, 0, 4, 0)))
    after = moved.inverse().apply(
        lengthened(known, moved.apply(segments((low, off, low + size, off))), ends)
    )
    assert np.abs(after[0, :, 1]).max() < 1e-6
    assert after[0, 0, 0] < 1e-6
    assert after[0, 1, 0] > 4.0 - 1e-6
    assert after[0, 0, 0] >= min(low, 0.0) - 1e-6
    assert after[0, 1, 0] <= max(low + size, 4.0) + 1e-6


@given(seed=st.integers(0, 99))
def test_transfer_does_not_depend_on_the_order_of_known_surfaces(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = segments((0, 0, 4, 0), (4, 0, 4, 3), (0, 5, -3, 5), (1, 2, 2, 2.5))
    new = segments((0.2, 0.1, 3, 0.1), (6, 0, 6, 2), (1.5, 1, 1.6, 3), (-1, 5.1, -4, 5))
    here = entered(new, entered(known).mfis)
    there = entered(new, entered(known[rng.permutation(4)]).mfis)
    assert same_rows(here.mfis.surfaces, there.mfis.surfaces)


def test_recognising_and_tagging_change_nothing_else_and_share_no_memory() -> None:
    mfis = entered(segments((0, 0, 4, 0), (5, 0, 5, 3))).mfis
    later = tag(recognise(mfis, np.array([1]), 9), np.array([0]), FORGOTTEN)
    assert later.seen.tolist() == [7, 9]
    assert later.asr.tolist() == [FORGOTTEN, 0]
    assert mfis.seen.tolist() == [7, 7]
    assert mfis.asr.tolist() == [0, 0]
    assert (later.surfaces == mfis.surfaces).all()


def test_all_rows_of_a_map_belong_together() -> None:
    mfis = entered(segments((0, 0, 4, 0), (5, 0, 5, 3), (0, 9, 1, 9))).mfis
    columns = (mfis.physical, mfis.anchor, mfis.anchor_sd, mfis.heading_sd, mfis.born, mfis.seen)
    assert {len(column) for column in (mfis.surfaces, *columns, mfis.asr, mfis.ids)} == {3}
    assert lengths(mfis.surfaces).tolist() == [4.0, 3.0, 1.0]


def test_forgotten_surfaces_leave_the_table_once_they_are_many_and_names_stay() -> None:
    rows = segments(*((10.0 * k, 0, 10.0 * k + 2, 0) for k in range(6)))
    mfis = tag(entered(seen(rows)).mfis, np.array([0, 2, 3, 5]), FORGOTTEN)
    assert without_dead(mfis, np.array([3]), 3) is mfis
    fewer = without_dead(mfis, np.array([3]), 2)
    assert fewer.ids.tolist() == [2, 3, 5, 6], "what is in use stays, and the last name given"
    assert np.array_equal(fewer.surfaces[fewer.rows_of(np.array([5, 2]))], rows[[4, 1]])
    assert fewer.last_id == mfis.last_id
