"""The robot of docs/benchmark.md takes part as the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from agents.registry import make_agent
from agents.sweep import COLUMNS, Trial, run_trial

PAGE = (Path(__file__).parents[1] / "docs" / "benchmark.md").read_text("utf-8")


@pytest.fixture
def my_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (block,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    (tmp_path / "my_robot.py").write_text(block)
    monkeypatch.syspath_prepend(tmp_path)
    assert len(block.splitlines()) <= 20
    return "my_robot:MyRobot"


@pytest.mark.parametrize("task", ["explore", "home"])
def test_the_robot_of_the_page_takes_part(task: str, my_robot: str) -> None:
    row = run_trial(Trial(my_robot, task, "two_rooms", "medium", 0))
    assert row["error"] is None
    assert row["coverage"] > 0.3


def test_the_page_tells_of_every_column() -> None:
    table = PAGE[PAGE.index("## Columns") : PAGE.index("All but `cpu_ms`")]
    first = [line.split("|")[1] for line in table.splitlines() if line.startswith("|")]
    told = re.findall(r"`([^`]+)`", " ".join(first))
    assert told == [name for name in COLUMNS if name not in ("task", "map", "odometry", "seed")]


@pytest.mark.parametrize(
    "name", ["nobody", "no_such_module:Robot", "math:Robot", "math:pi", "math:"]
)
def test_a_robot_that_cannot_be_found_is_refused_by_name(name: str) -> None:
    with pytest.raises(ValueError, match="agent: "):
        make_agent(name)
