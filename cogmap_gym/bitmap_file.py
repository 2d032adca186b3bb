"""Bitmaps of floor plans: what their description says, and which of their pixels are free.

A description is the YAML of ROS's map_server, or the same with ``metres_per_pixel`` in place of
``resolution``, as a file or as a mapping. See ``maps/README.md`` for its keys.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from cogmap_gym.geometry import Pose
from cogmap_gym.plan_schema import MAX_COORDINATE, shown
from cogmap_gym.raster import Mask, Raster

SCALES = ("resolution", "metres_per_pixel")
"""What may give the side of a pixel [m]: the name in ROS, and a plain one."""
KEYS = (
    "image", *SCALES, "origin", "negate", "occupied_thresh", "free_thresh", "mode",
    "name", "home", "rooms",
)  # fmt: skip
"""The keys of a description; ``image`` and one scale are needed."""
MODES = ("trinary", "scale", "raw")
"""How the values of pixels are read, after ROS's map_server."""
MAX_PIXELS = 2**24
"""Most pixels of an image [-]. Ours: 4096 x 4096, the largest map of many mapping programs."""
MAX_FILE = 2**28
"""Largest image file [bytes]. Ours: 8 bytes a pixel."""
MIN_CELL_M = 1e-6
"""Least side of a pixel [m]. Ours: far below any plan, far above what squares to nothing."""
MAX_SIDE_M = 500.0
"""Longest side of a plan [m]. Ours: cells of 0.1 m over it take some 100 MB."""
ROS_FREE, PLAIN_FREE = 0.196, 0.1
"""Below this share of black a pixel is free, unless ``free_thresh`` says otherwise [-]. ROS's
default takes the usual grey 205 for unknown; in a plain picture furniture is often light grey."""
OCCUPIED = 0.65
"""Above this share of black a pixel is surely not free [-]. ROS's default."""
RAW_OCCUPIED = 100.0
"""The value of an occupied pixel in the mode ``raw`` [-]. ROS."""
FORMATS = ("PNG", "PPM", "BMP", "JPEG")
"""What images may be; ``PPM`` stands for PBM, PGM and PPM."""


@dataclass(frozen=True, slots=True, eq=False)
class Bitmap:
    """A bitmap as it was described."""

    name: str
    """What the plan is called."""
    raster: Raster
    """Which pixels are free; all others, unknown or partly occupied ones too, are wall."""
    home: tuple[float, float, float] | None
    """x, y [m] and degrees, if given."""
    rooms: NDArray[np.int64] | None
    """The colour of each cell in the image of rooms, the lowest row first, if there is one."""


def read_bitmap(description: Mapping[str, Any], folder: Path, origin: str) -> Bitmap:
    """The bitmap of a description.

    Args:
        description: with the keys ``KEYS``.
        folder: where paths in it start.
        origin: what messages call it.

    Raises:
        ValueError: naming the origin, the key and the value.
    """
    scale = _check_keys(description, origin)
    free_below = _free_below(description, scale, origin)
    mode = description.get("mode", "trinary")
    if mode not in MODES:
        raise ValueError(f"{origin}: mode: expected one of {MODES}, got {shown(mode)}")
    negate = description.get("negate", 0)
    if not isinstance(negate, int) or negate not in (0, 1):
        raise ValueError(f"{origin}: negate: expected 0 or 1, got {shown(negate)}")
    cell = _numbers(description[scale], 1, f"{origin}: {scale}")[0]
    if cell < MIN_CELL_M:
        raise ValueError(f"{origin}: {scale}: expected {MIN_CELL_M:g} m or more, got {cell}")
    x, y, yaw = _numbers(description.get("origin", [0.0, 0.0, 0.0]), 3, f"{origin}: origin")
    path = _path(description["image"], folder, f"{origin}: image")
    pixels = _pixels(path, f"{origin}: image")
    _check_side(pixels, cell, f"{origin}: {scale}")
    free = _free(pixels, mode, free_below, negate=bool(negate))
    home = description.get("home")
    return Bitmap(
        _name(description.get("name", path.stem), f"{origin}: name"),
        Raster(np.flipud(free), cell, Pose(x, y, yaw)),
        None if home is None else _numbers(home, 3, f"{origin}: home"),
        _rooms(description.get("rooms"), folder, free.shape, f"{origin}: rooms"),
    )


def _check_keys(description: Mapping[str, Any], origin: str) -> str:
    """Which of the two keys gives the scale."""
    unknown = [key for key in description if key not in KEYS]
    if unknown:
        value = shown(description[unknown[0]])
        raise ValueError(f"{origin}: {unknown[0]}: unknown, got {value}; a bitmap has keys {KEYS}")
    scales = [key for key in SCALES if key in description]
    if "image" not in description or len(scales) != 1:
        raise ValueError(
            f"{origin}: expected 'image' and one of {SCALES}, got the keys {shown([*description])}"
        )
    return scales[0]


def _free_below(description: Mapping[str, Any], scale: str, origin: str) -> float:
    default = ROS_FREE if scale == "resolution" else PLAIN_FREE
    given = [description.get("free_thresh", default), description.get("occupied_thresh", OCCUPIED)]
    free, occupied = _numbers(given, 2, f"{origin}: free_thresh, occupied_thresh")
    if not 0.0 < free <= occupied <= 1.0:
        raise ValueError(
            f"{origin}: free_thresh, occupied_thresh: expected 0 < free <= occupied <= 1, "
            f"got {free} and {occupied}"
        )
    return float(free)


def _numbers(value: Any, width: int, where: str) -> Any:
    """As many finite numbers as expected, as a tuple of floats; one may stand without a list."""
    row = [value] if width == 1 else value
    if not isinstance(row, (list, tuple)) or len(row) != width:
        raise ValueError(f"{where}: expected {width} numbers, got {shown(value)}")
    for number in row:
        is_number = isinstance(number, (int, float)) and not isinstance(number, bool)
        if not is_number or not abs(number) <= MAX_COORDINATE:
            raise ValueError(
                f"{where}: expected finite numbers within {MAX_COORDINATE:g}, got {shown(value)}"
            )
    return tuple(map(float, row))


def _name(value: Any, where: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{where}: expected a name (text), got {shown(value)}")
    return value


def _path(value: Any, folder: Path, where: str) -> Path:
    if not isinstance(value, (str, Path)) or not str(value):
        raise ValueError(f"{where}: expected the path of an image, got {shown(value)}")
    path = folder / value
    try:
        size = path.stat().st_size if path.is_file() else None
    except (OSError, ValueError):  # too long a name, or a zero byte in it
        size = None
    if size is None:
        raise ValueError(f"{where}: expected an image, got no such file: {shown(str(path))}")
    if size > MAX_FILE:
        raise ValueError(f"{where}: expected at most {MAX_FILE} bytes, {path} has {size}")
    return path


def _check_side(pixels: NDArray[np.uint8], cell: float, where: str) -> None:
    side = max(pixels.shape[:2]) * cell
    if side > MAX_SIDE_M:
        raise ValueError(
            f"{where}: expected a plan of at most {MAX_SIDE_M:g} m, got {cell} m a pixel, "
            f"which makes {side:g} m"
        )


def _pixels(path: Path, where: str) -> NDArray[np.uint8]:
    """The pixels of an image, (H, W, 4) with alpha, the top row first.

    Raises:
        ValueError: no image, one that is cut short, or one too large.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # odd metadata do not matter here
            with Image.open(path, formats=FORMATS) as image:
                if image.width * image.height > MAX_PIXELS:
                    size = f"{image.width} x {image.height}"
                    raise ValueError(f"at most {MAX_PIXELS} pixels are read, it has {size}")
                deep = image.mode.startswith(("I", "F"))
                eight = Image.fromarray(_eight_bits(np.asarray(image))) if deep else image
                return np.asarray(eight.convert("RGBA"))
    except Exception as error:  # a decoder of foreign bytes may raise anything
        message = f"{where}: expected a whole image, {path} cannot be read: {error}"
        raise ValueError(message) from error


def _eight_bits(values: NDArray[Any]) -> NDArray[np.uint8]:
    """Grey of 16 bits and more as 8 bits."""
    return np.asarray(np.clip(np.nan_to_num(values) / 257.0, 0.0, 255.0).round(), dtype=np.uint8)


def _free(pixels: NDArray[np.uint8], mode: str, free_below: float, *, negate: bool) -> Mask:
    """Which pixels (H, W) are surely free; transparent ones are unknown, so they are not."""
    grey = pixels[..., :3].mean(axis=2, dtype=np.float32)
    if mode == "raw":
        return np.asarray(grey < free_below * RAW_OCCUPIED)
    black = grey if negate else 255.0 - grey
    opaque = pixels[..., 3] == np.iinfo(np.uint8).max
    return np.asarray((black < free_below * 255.0) & opaque)


def _rooms(value: Any, folder: Path, shape: tuple[int, ...], where: str) -> Any:
    """The colours of an image of rooms as numbers, (rows, columns)."""
    if value is None:
        return None
    pixels = _pixels(_path(value, folder, where), where).astype(np.int64)
    if pixels.shape[:2] != shape:
        raise ValueError(
            f"{where}: expected an image as large as that of the plan, (height, width) {shape}, "
            f"got {pixels.shape[:2]}"
        )
    return np.flipud(pixels @ (1, 2**8, 2**16, 2**24))
