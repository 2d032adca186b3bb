"""Small drawings of floor plans in the formats of other programs, written by the tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

SAMPLES = Path(__file__).parents[2] / "shared" / "data" / "plans"
"""Plans of real buildings that do not come with the project."""
needs_samples = pytest.mark.skipif(
    not SAMPLES.is_dir(), reason="the sample plans in ../shared/data/plans are absent"
)
CELL = 0.05
FREE, GREY, WALL = 254, 205, 0


def two_rooms() -> NDArray[np.uint8]:
    """Grey outside; two rooms of 3 x 3 m and a doorway of 1 m, walls of 0.1 m; (70, 134)."""
    pixels = np.full((70, 134), GREY, dtype=np.uint8)
    pixels[3:67, 3:131] = WALL
    pixels[5:65, 5:65] = FREE
    pixels[5:65, 69:129] = FREE
    pixels[25:45, 65:69] = FREE
    return pixels


def write_ros(folder: Path, pixels: NDArray[np.uint8], image: str = "map.pgm", **keys: Any) -> Path:
    """A map of ROS's map_server; keywords replace its keys, None leaves one out."""
    Image.fromarray(pixels).save(folder / image)
    fields = {
        "image": image,
        "resolution": CELL,
        "origin": "[0.0, 0.0, 0.0]",
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    } | keys
    path = folder / "map.yaml"
    path.write_text("".join(f"{k}: {v}\n" for k, v in fields.items() if v is not None))
    return path


VECTORMAP = """\
0.0, 0.0, 8.0, 0.0
8.0, 0.0, 8.0, 5.0
8.0,5.0,0.0,5.0

0.0,5.0, 0.0,0.0
4.0,0.0, 4.0,2.0
4.0,3.0, 4.0,5.0
9.0,1.0, 9.5,1.0
"""
"""Two rooms and a doorway, and a line that nobody can see."""

ARIA = """\
2D-Map
MinPos: 0 0
NumPoints: 2
Resolution: 20
NumLines: 6
Cairn: Goal 1 2 0.000000 "" ICON "not a wall"
Cairn: RobotHome 2000 2500 90.000000 "" ICON ""
Cairn: ForbiddenLine 0 0 0.000000 "" ICON "" 0 0 8000 5000
LINES
0 0 8000 0
8000 0 8000 5000
8000 5000 0 5000
0 5000 0 0
4000 0 4000 2000
4000 3000 4000 5000
DATA
12 13
14 15
"""
"""The same in millimetres, with home."""
