"""What the rivals promise, in whole episodes on offices of the development range."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from agents.registry import is_available
from agents.rival_trials import Exploration, explore_all, reach_goals

OFFICES = ("office:1040", "office:1043", "office:1046")
needs_gtsam = pytest.mark.skipif(not is_available("frontier_slam"), reason="needs the extra slam")


@cache
def explored(name: str, office: str) -> Exploration:
    return explore_all(name, office)


def test_the_oracle_sees_all_of_two_rooms_and_comes_home() -> None:
    assert explore_all("frontier_oracle", "two_rooms").coverage >= 0.99
    assert reach_goals("frontier_oracle", "CogMap/GoHome-v0", "two_rooms").is_success


@pytest.mark.parametrize("name", ["random_walk", "wall_follower"])
def test_who_keeps_no_map_finds_the_door_of_two_rooms_and_home(name: str) -> None:
    assert reach_goals(name, "CogMap/Explore-v0", "two_rooms").is_success
    assert reach_goals(name, "CogMap/GoHome-v0", "two_rooms").is_success


@pytest.mark.slow
@pytest.mark.parametrize("office", OFFICES)
def test_the_oracle_explores_99_percent_of_an_office(office: str) -> None:
    trial = explored("frontier_oracle", office)
    assert trial.complete
    assert trial.coverage >= 0.99


@pytest.mark.slow
@pytest.mark.parametrize("office", OFFICES)
@pytest.mark.parametrize("task", ["GoTo", "Shortcut"])
def test_the_oracle_reaches_every_reachable_goal(task: str, office: str) -> None:
    episode = reach_goals("frontier_oracle", f"CogMap/{task}-v0", office)
    assert episode.is_success
    assert (episode.success[2:] != 0).all()


@pytest.mark.slow
def test_where_no_route_is_left_the_oracle_says_so() -> None:
    episode = reach_goals("frontier_oracle", "CogMap/Shortcut-v0", OFFICES[0], unreachable=1.0)
    assert episode.is_success


@pytest.mark.slow
@needs_gtsam
@pytest.mark.parametrize("office", OFFICES)
def test_the_error_of_slam_is_at_most_a_tenth_of_odometrys(office: str) -> None:
    trial = explored("frontier_slam", office)
    assert trial.coverage >= 0.99
    assert np.mean(trial.errors) <= np.mean(trial.odometry_errors) / 10.0
    assert np.mean(trial.final_errors) <= np.mean(trial.odometry_errors) / 10.0


@pytest.mark.slow
@needs_gtsam
@pytest.mark.parametrize("name", ["frontier_slam", "frontier_scan_matching"])
def test_scan_matching_finds_home_and_marks_at_medium_odometry(name: str) -> None:
    for task in ("GoHome", "GoTo"):
        assert reach_goals(name, f"CogMap/{task}-v0", OFFICES[1]).is_success
