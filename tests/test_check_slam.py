"""Our SLAM rival beside another program's, which runs in an interpreter of its own."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.test_scripts import run

ECHO = f"""#!{sys.executable}
import sys
import numpy as np
if sys.argv[1] != "-c":
    np.savez(sys.argv[3], poses=np.load(sys.argv[2])["odometry"])
"""
"""An interpreter whose SLAM believes the wheels."""


def test_an_interpreter_without_the_other_program_is_refused_in_words() -> None:
    code, said = run("check_slam.py", "--yag", sys.executable)
    assert code == 2
    assert "yag" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_who_believes_the_wheels_is_as_wrong_as_they_are(tmp_path: Path) -> None:
    pytest.importorskip("gtsam")
    echo = tmp_path / "echo"
    echo.write_text(ECHO)
    echo.chmod(0o755)
    code, said = run("check_slam.py", "--yag", echo, "--offices", "1000:1001")
    assert code == 0, said
    lines = [line.split("\u2502")[3:6] for line in said.splitlines() if "1000" in line]
    errors = {name.strip(): (float(ate), float(rpe)) for name, ate, rpe in lines}
    assert errors["yag-slam"] == errors["odometry"]
    assert errors["ours"][0] < 0.1 * errors["odometry"][0]
