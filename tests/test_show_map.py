"""The picture of a plan, and the script that draws it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from matplotlib.collections import PolyCollection
from PIL import Image

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.plan_figures import plan_figure
from tests.drawings import two_rooms

ROOT = Path(__file__).parent.parent


def show(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "scripts/show_map.py", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_the_picture_has_every_room_and_keeps_the_shape_of_the_plan() -> None:
    for name in ("two_rooms", "thesis_office"):
        plan = FloorPlan.load(name)
        figure = plan_figure(plan)
        figure.canvas.draw()
        ax = figure.axes[0]
        rooms = next(c for c in ax.collections if isinstance(c, PolyCollection))
        assert len(rooms.get_paths()) == len(plan.rooms)
        assert ax.get_aspect() == 1.0
        assert ax.get_xlabel() == "x [m]"
        assert plan.name in ax.get_title()


def test_the_script_draws_a_picture_with_a_scale_and_saves_our_own_plan(tmp_path: Path) -> None:
    Image.fromarray(two_rooms()).save(tmp_path / "mine.png")
    arguments = ("--metres-per-pixel", 0.05, "--out", tmp_path / "o" / "m.png")
    done = show(tmp_path / "mine.png", *arguments, "--save", tmp_path / "s" / "mine.yaml")
    assert done.returncode == 0, done.stderr
    assert "mine: 12 wall segments, 2 rooms, 0 doors, 18 m^2 free" in done.stdout
    assert done.stdout.splitlines()[1:] == [
        str(tmp_path / "o" / "m.png"),
        str(tmp_path / "s" / "mine.yaml"),
    ]
    assert Image.open(tmp_path / "o" / "m.png").width > 600
    assert len(FloorPlan.load(tmp_path / "s" / "mine.yaml").rooms) == 2


def test_the_script_tells_what_is_wrong_in_words(tmp_path: Path) -> None:
    Image.fromarray(two_rooms()).save(tmp_path / "mine.png")
    done = show(tmp_path / "mine.png")
    assert done.returncode == 2
    assert "--metres-per-pixel" in done.stderr
    assert "Traceback" not in done.stderr
