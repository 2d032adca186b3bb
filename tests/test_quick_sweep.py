"""`evaluate.py --quick` makes its whole page."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

ROOT = Path(__file__).parents[1]
FIGURES = {
    "Coverage",
    "Success against drift",
    "Success against office size",
    "Success in a living office",
    "Success against doors changed",
    "Paths, explore",
    "Paths, home",
}
TABLES = {"At a glance", "explore", "home", "Against random_walk", "Code and parameters"}
LEVELS = 2 * 2
"""Small tables at a glance: levels of odometry times what moves in the office."""


@pytest.mark.slow
def test_the_quick_sweep_makes_a_page_with_all_its_parts(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "scripts" / "evaluate.py"), "--quick"]
    subprocess.run([*command, "--out", str(tmp_path)], check=True, capture_output=True)
    with (tmp_path / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 4 * 2 * 2 * 2 * 2
    assert not [row["error"] for row in rows if row["error"]]
    page = (tmp_path / "report.html").read_text()
    assert set(re.findall(r"<h2>(.*?)</h2>", page)) == FIGURES | TABLES
    assert set(re.findall(r"<h3>(.*?): ways", page)) == {"explore", "home"}
    assert page.count("<table>") == len(TABLES) - 1 + 2 + LEVELS
    assert (tmp_path / "leaderboard.md").read_text().count("\n## ") == LEVELS
    assert page.count("data:image/png;base64,") == len(FIGURES)
    assert "http" not in page
    for title in FIGURES:
        name = title.lower().replace(",", "").replace(" ", "_")
        with Image.open(tmp_path / f"{name}.png") as picture:
            assert min(picture.size) > 300
        assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
