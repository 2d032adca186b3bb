"""Rows of different code or parameters do not get into one table unasked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from agents.cogmap import CogMapAgent, Params
from agents.frontier import FrontierAgent
from agents.frontier.matching import ScanMatching
from agents.frontier.params import Matching
from agents.provenance import check_rows, commit, params_of
from agents.registry import make_agent
from agents.sweep import COLUMNS

PATH = Path("results.csv")


def row(agent: str, **told: str) -> dict[str, str]:
    now = {"commit": commit(), "params": params_of(make_agent(agent))}
    return dict.fromkeys(COLUMNS, "") | {"agent": agent} | now | told


def test_a_digest_is_that_of_the_parameters_alone() -> None:
    assert params_of(CogMapAgent()) == params_of(make_agent("cogmap"))
    assert params_of(CogMapAgent()) != params_of(CogMapAgent(Params.literal()))
    assert params_of(make_agent("random_walk", 1)) == ""


def test_what_the_source_of_poses_is_told_counts_too() -> None:
    name = next(iter(Matching.__dataclass_fields__))
    other = replace(Matching(), **{name: 2 * getattr(Matching(), name)})
    first, second = (FrontierAgent(ScanMatching(m)) for m in (Matching(), other))
    assert params_of(first) != params_of(second)


def test_rows_of_today_are_gone_on_with() -> None:
    check_rows(PATH, [row("cogmap"), row("random_walk")], ["cogmap", "random_walk"])


def test_rows_of_another_commit_are_refused_with_both() -> None:
    with pytest.raises(ValueError, match=rf"results.csv: commit: .*'old'.*{commit()[:7]}"):
        check_rows(PATH, [row("cogmap", commit="old")], ["random_walk"])


def test_rows_of_other_parameters_are_refused_where_the_robot_shall_run() -> None:
    rows, now = [row("cogmap", params="0123")], params_of(make_agent("cogmap"))
    with pytest.raises(ValueError, match=rf"results.csv: params of cogmap: .*'0123'.*'{now}'"):
        check_rows(PATH, rows, ["cogmap"])
    check_rows(PATH, rows, ["random_walk"])


def test_a_robot_that_was_never_made_had_no_parameters_to_tell() -> None:
    check_rows(PATH, [row("cogmap", params="", error="Traceback")], ["cogmap"])
