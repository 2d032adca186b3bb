"""The larger maps on which a step is timed: the real map, with further offices around it."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap import CogMapAgent
from agents.cogmap.memory import Memory
from agents.step_cost import Recorded, enlarged, record, seconds_a_step

WANTED = 400


@pytest.fixture(scope="module")
def run() -> list[Recorded]:
    return record(gym.make("CogMap/Explore-v0", map="thesis_office", max_moves=70), 1000)


@pytest.fixture(scope="module")
def large(run: list[Recorded]) -> Memory:
    return enlarged(run[40].before, run[-1].before, WANTED)


def test_an_enlarged_map_holds_the_real_one_unchanged(run: list[Recorded], large: Memory) -> None:
    real, mfis = run[40].before, large.mapping.mfis
    own = slice(len(real.mapping.mfis))
    assert len(mfis) == WANTED
    assert (mfis.surfaces[own] == real.mapping.mfis.surfaces).all()
    assert (mfis.asr[own] == real.mapping.mfis.asr).all()
    assert large.book[: len(real.book)] == real.book
    assert (large.path[-len(real.path) :] == real.path).all()


def test_every_copy_has_names_and_ground_of_its_own(large: Memory) -> None:
    places = [asr.id for asr in large.network.asrs]
    assert len(set(places)) == len(places)
    assert max(places) <= large.network.last_id
    assert [e.id for e in large.book] == list(range(1, len(large.book) + 1))
    middles = large.mapping.mfis.surfaces.mean(axis=1)
    assert len(np.unique(middles.round(6), axis=0)) == WANTED


def test_further_offices_change_no_decision(run: list[Recorded]) -> None:
    small, other = CogMapAgent(), CogMapAgent()
    for step in run[30:60]:
        small.memory = step.before
        other.memory = enlarged(step.before, run[-1].before, WANTED)
        assert (small.act(step.observation) == other.act(step.observation)).all()


def test_each_step_is_timed_once(run: list[Recorded]) -> None:
    steps = run[:5]
    taken = seconds_a_step(steps, [step.before for step in steps], CogMapAgent())
    assert taken.shape == (5,)
