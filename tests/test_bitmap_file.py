"""Bitmaps: how their pixels are read, and how mistakes are told."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cogmap_gym import bitmap_file
from cogmap_gym.bitmap_file import read_bitmap
from cogmap_gym.floor_plan import FloorPlan
from tests.drawings import FREE, two_rooms, write_ros

LEVELS = np.array([[0, 60, 100, 150, 204, 205, 206, 254, 255]], dtype=np.uint8)


def free_levels(folder: Path, pixels: Any = LEVELS, **keys: Any) -> list[bool]:
    """Which pixels of one row are read as free."""
    Image.fromarray(pixels).save(folder / "row.png")
    described = {"image": "row.png", "resolution": 0.05, "free_thresh": 0.196, **keys}
    return read_bitmap(described, folder, "here").raster.free[0].tolist()


def test_pixels_lighter_than_the_threshold_are_free_as_in_map_server(tmp_path: Path) -> None:
    assert free_levels(tmp_path) == [level > 205 for level in LEVELS[0]]
    assert free_levels(tmp_path, mode="scale") == [level > 205 for level in LEVELS[0]]
    assert free_levels(tmp_path, negate=1) == [level < 50 for level in LEVELS[0]]
    assert free_levels(tmp_path, free_thresh=0.5) == [level > 127 for level in LEVELS[0]]
    assert free_levels(tmp_path, mode="raw") == [level < 19 for level in LEVELS[0]]


def test_a_picture_takes_white_for_free_and_light_grey_for_furniture(tmp_path: Path) -> None:
    Image.fromarray(LEVELS).save(tmp_path / "row.png")
    described = {"image": "row.png", "metres_per_pixel": 0.05}
    free = read_bitmap(described, tmp_path, "here").raster.free[0]
    assert free.tolist() == [level > 229 for level in LEVELS[0]]


def test_colours_count_by_their_mean_and_what_is_transparent_is_unknown(tmp_path: Path) -> None:
    row = np.array([[(255, 255, 255, 255), (255, 255, 255, 0), (255, 0, 0, 255)]], dtype=np.uint8)
    assert free_levels(tmp_path, row) == [True, False, False]
    assert free_levels(tmp_path, row[..., :3]) == [True, True, False]


def test_deep_grey_is_read_as_eight_bits_are(tmp_path: Path) -> None:
    assert free_levels(tmp_path, LEVELS.astype(np.uint16) * 257) == free_levels(tmp_path)


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "no image": ({"image": None}, r"expected 'image' and one of"),
    "no scale": ({"resolution": None}, r"expected 'image' and one of .*'resolution'"),
    "two scales": ({"metres_per_pixel": 0.05}, "expected 'image' and one of"),
    "negative scale": ({"resolution": -0.05}, r"resolution: .*1e-06 m or more, got -0\.05"),
    "no scale at all": ({"resolution": 0}, r"resolution: .*1e-06 m or more, got 0\.0"),
    "scale of nothing": ({"resolution": "1.0e-200"}, "resolution: .*1e-06 m or more, got 1e-200"),
    "scale nan": ({"resolution": ".nan"}, "resolution: .*finite.*nan"),
    "scale as text": ({"resolution": "five"}, "resolution: .*'five'"),
    "vast": ({"resolution": 100}, r"resolution: .*at most 500 m, got 100\.0 m a pixel"),
    "tiny": ({"resolution": 0.0001}, r"free space: expected room for a robot"),
    "origin of two": ({"origin": "[0, 0]"}, r"origin: expected 3 numbers, got \[0, 0\]"),
    "origin nan": ({"origin": "[0, .nan, 0]"}, "origin: .*nan"),
    "negate": ({"negate": 2}, "negate: expected 0 or 1, got 2"),
    "mode": ({"mode": "binary"}, "mode: expected one of .*'binary'"),
    "thresholds": ({"free_thresh": 0.9}, r"free_thresh, occupied_thresh: .*0\.9 and 0\.65"),
    "typo": ({"orgin": "[0, 0, 0]"}, r"orgin: unknown, got \[0, 0, 0\]"),
    "home in the wall": ({"home": "[0.1, 0.1, 0]"}, r"home: .*free space, got \[0\.1, 0\.1\]"),
    "home far away": ({"home": "[99, 0, 0]"}, r"home: .*free space, got \[99\.0"),
    "home near a wall": ({"home": "[0.4, 1, 0]"}, r"home: .*0\.25 m or more .*\[0\.4, 1\.0\]"),
    "home of two": ({"home": "[1, 1]"}, r"home: expected 3 numbers, got \[1, 1\]"),
    "rooms absent": ({"rooms": "none.png"}, r"rooms: .*no such file: .*none\.png"),
    "name": ({"name": "''"}, "name: .*''"),
}


@pytest.mark.parametrize(("change", "message"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_with_file_key_and_value(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    image = two_rooms()
    Image.fromarray(image).save(tmp_path / "map.pgm")
    path = write_ros(tmp_path, image)
    text = [line for line in path.read_text().splitlines() if line.split(":")[0] not in change]
    text += [f"{key}: {value}" for key, value in change.items() if value is not None]
    path.write_text("\n".join(text))
    with pytest.raises(ValueError, match=rf"map\.yaml: {message}"):
        FloorPlan.load(path)


def png_of_size(width: int, height: int) -> bytes:
    """A PNG whose head promises more than it holds."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + content))
        return struct.pack(">I", len(content)) + kind + content + check

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"\0" * 99))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "expected a whole image"),
        (b"P5\n10 10\n255\n" + bytes(99), "expected a whole image, .*not large enough"),
        (b"P5\n99999 99999\n255\n", "expected a whole image"),
        (b"P5\n9999 9999\n255\n", "expected a whole image, .*at most 16777216 pixels.*9999 x 9999"),
        (b"P5\n-4 4\n255\n" + bytes(16), "expected a whole image"),
        (b"P5\n1 1e9\n255\n", "expected a whole image"),
        (png_of_size(60000, 60000), "expected a whole image"),
        (png_of_size(8000, 8000), "expected a whole image, .*8000 x 8000"),
        (png_of_size(80, 80), "expected a whole image"),
        (b"GIF89a" + bytes(100), "expected a whole image"),
        (b"P5\n8 8\n255\n" + bytes(64), "expected free space, got none"),
        (b"P5\n4 4\n255\n" + b"\xff" * 16, "free space: expected room for a robot"),
    ],
)
def test_an_image_that_is_none_is_told(content: bytes, message: str, tmp_path: Path) -> None:
    path = write_ros(tmp_path, two_rooms())
    (tmp_path / "map.pgm").write_bytes(content)
    with pytest.raises(ValueError, match=rf"map\.yaml: (image: )?{message}"):
        FloorPlan.load(path)


def test_an_image_that_is_absent_huge_or_oddly_named_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_ros(tmp_path, two_rooms())
    for odd in ("gone.pgm", "a" * 5000, "a\0b", ".", str(tmp_path)):
        with pytest.raises(ValueError, match="mapping: image: expected an image, got no such"):
            FloorPlan.load({"image": odd, "resolution": 0.05})
    with pytest.raises(ValueError, match="mapping: image: expected the path of an image, got 7"):
        FloorPlan.load({"image": 7, "resolution": 0.05})
    monkeypatch.setattr(bitmap_file, "MAX_FILE", 100)
    with pytest.raises(ValueError, match=r"image: expected at most 100 bytes, .*map\.pgm has"):
        FloorPlan.load(path)


def test_rooms_of_another_size_or_none_are_told(tmp_path: Path) -> None:
    path = write_ros(tmp_path, two_rooms(), rooms="rooms.png")
    Image.fromarray(np.zeros((3, 4), dtype=np.uint8)).save(tmp_path / "rooms.png")
    with pytest.raises(ValueError, match=r"rooms: .*\(70, 134\), got \(3, 4\)"):
        FloorPlan.load(path)
    noise = np.random.default_rng(1000).integers(0, 255, (70, 134), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / "rooms.png")
    with pytest.raises(ValueError, match="rooms: expected areas of one colour"):
        FloorPlan.load(path)
    Image.fromarray(np.full((70, 134), FREE, dtype=np.uint8)).save(tmp_path / "rooms.png")
    assert len(FloorPlan.load(path).rooms) == 1
