"""Broken files of plans: whatever a file holds, it loads or a ValueError tells what is wrong."""

from __future__ import annotations

import copy
import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from cogmap_gym import plan_file
from cogmap_gym.floor_plan import FloorPlan
from tests.drawings import ARIA, FREE, VECTORMAP, WALL, two_rooms, write_ros

SMALL = np.pad(np.full((24, 30), FREE, dtype=np.uint8), 2, constant_values=WALL)
FUZZED = settings(
    max_examples=60, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip


def image_of(kind: str) -> bytes:
    """The small hall as an image file."""
    Image.fromarray(SMALL).save(stream := io.BytesIO(), format=kind)
    return stream.getvalue()


def ros_text() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return write_ros(Path(folder), two_rooms()).read_bytes()


@st.composite
def mutated(draw: st.DrawFn, content: bytes) -> bytes:
    """The content with some bytes changed, taken out, doubled, put in or cut off."""
    out = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(out) - 1, 0)))
        end = at + draw(st.integers(0, 6))
        match draw(st.integers(0, 4)):
            case 0:
                out[at:end] = draw(st.binary(max_size=6))
            case 1:
                del out[at:end]
            case 2:
                out[at:at] = out[at:end]
            case 3:
                out[at:end] = draw(st.sampled_from([b"nan", b"-", b"1e9", b"9" * 9, b"\0", b"0,"]))
            case _:
                del out[at:]
    return bytes(out)


def loads_or_tells(source: Any) -> None:
    """Load a plan; nothing but a ValueError that names its source may be raised."""
    told = ""
    try:
        assert FloorPlan.load(source).area > 0.0
    except ValueError as error:
        told = str(error)
    where = "mapping" if isinstance(source, dict) else Path(source).name
    assert not told or where in told


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.vectormap.txt", VECTORMAP.encode()),
        ("a.map", ARIA.encode()),
        ("map.yaml", ros_text()),
        ("own.yaml", plan_file.find("two_rooms").read_bytes()),
    ],
)
def test_a_mutated_file_loads_or_is_told(name: str, content: bytes, tmp_path: Path) -> None:
    Image.fromarray(two_rooms()).save(tmp_path / "map.pgm")

    @FUZZED
    @given(mutated(content))
    def fuzz(changed: bytes) -> None:
        (tmp_path / name).write_bytes(changed)
        loads_or_tells(tmp_path / name)

    fuzz()


ODD = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4)
    | st.sampled_from([1e308, -1e308, 0.0, 10**400]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)  # fmt: skip
"""What a program may put where a number, a name or a list of points is expected."""


@st.composite
def spoilt(draw: st.DrawFn, plan: dict[str, Any]) -> dict[str, Any]:
    """A mapping in which something, however deep, is something else."""
    spoilt = inside = copy.deepcopy(plan)
    while True:
        key = draw(
            st.sampled_from(sorted(inside) if isinstance(inside, dict) else range(len(inside)))
        )
        value = inside[key]
        if not (isinstance(value, dict | list) and value and draw(st.booleans())):
            inside[key] = draw(ODD)
            return spoilt
        inside = value


@pytest.mark.parametrize("kind", ["plan", "picture"])
def test_a_spoilt_mapping_loads_or_is_told(kind: str, tmp_path: Path) -> None:
    Image.fromarray(SMALL).save(tmp_path / "hall.png")
    picture = {
        "image": str(tmp_path / "hall.png"), "metres_per_pixel": 0.1, "origin": [0.0, 0.0, 0.0],
        "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.1, "mode": "trinary",
        "name": "hall", "home": [1.4, 1.4, 0.0],
    }  # fmt: skip
    plan = FloorPlan.load("two_rooms").to_mapping() if kind == "plan" else picture
    plan = json.loads(json.dumps(plan))

    @FUZZED
    @given(spoilt(plan))
    def fuzz(changed: dict[str, Any]) -> None:
        loads_or_tells(changed)

    fuzz()


@pytest.mark.parametrize("kind", ["png", "ppm", "bmp", "jpeg"])
def test_a_mutated_image_loads_or_is_told(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "hall.img"

    @FUZZED
    @given(mutated(image_of(kind)))
    def fuzz(changed: bytes) -> None:
        path.write_bytes(changed)
        loads_or_tells({"image": str(path), "metres_per_pixel": 0.1})

    fuzz()


@FUZZED
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.3), st.floats(0.3, 0.9))
def test_any_noise_loads_or_is_told(seed: int, cell: float, share: float) -> None:
    rng = np.random.default_rng(seed)
    blocks = rng.random((10, 12)) < share
    pixels = np.where(np.kron(blocks, np.ones((5, 5))), FREE, WALL).astype(np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        Image.fromarray(pixels).save(Path(folder) / "noise.png")
        loads_or_tells({"image": f"{folder}/noise.png", "metres_per_pixel": cell})


@FUZZED
@given(st.lists(st.tuples(*[st.integers(0, 12)] * 4), min_size=1, max_size=24))
def test_any_lines_load_or_are_told(lines: list[tuple[int, ...]]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.txt"
        path.write_text("\n".join(",".join(map(str, line)) for line in lines))
        loads_or_tells(path)
