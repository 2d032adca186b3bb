"""Floor plans of other programs: which file is what, and the mapping of the plan in it.

| what | file |
|---|---|
| our own plans | ``.yaml``; see ``cogmap_gym.plan_file`` |
| bitmaps of ROS's map_server | ``.yaml`` with the keys ``image`` and ``resolution`` |
| pictures with a scale | ``.yaml`` or a mapping with the keys ``image`` and ``metres_per_pixel`` |
| AMRL vectormaps | ``.vectormap.txt`` |
| ARIA maps | ``.map`` |

What reads a format is imported when a file asks for it: the libraries for images load slowly.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shapely.errors import GEOSException

from cogmap_gym import generator, plan_file

READABLE = (".yaml", ".yml", ".vectormap.txt", ".map")
"""How the files of plans are called."""
PICTURES = (".png", ".pgm", ".pbm", ".ppm", ".bmp", ".jpg", ".jpeg")
"""How the files of images are called, which need a description."""
BITMAP_KEYS = ("image", "resolution", "metres_per_pixel")
"""Any of these keys tells the description of a bitmap from a plan."""


def mapping_of(source: str | Path | Mapping[str, Any]) -> tuple[Mapping[str, Any], str]:
    """The mapping of a plan, and its origin.

    Args:
        source: a packaged name, the path of a file, ``"office:SEED"``, the mapping of a plan, or
            the description of a bitmap (a mapping with the key ``image``).

    Raises:
        ValueError: no such plan, or a file that is none; names the file, the field, the value.
    """
    if isinstance(source, Mapping):
        return _described(source, Path(), "mapping")
    if isinstance(source, str) and generator.is_office(source):
        return generator.office(source), source
    return _of_file(plan_file.find(source))


def _of_file(path: Path) -> tuple[Mapping[str, Any], str]:
    origin, name = str(path), path.name.lower()
    if name.endswith((".yaml", ".yml")):
        return _described(plan_file.read(path), path.parent, origin)
    if name.endswith((".txt", ".map")):
        from cogmap_gym.segment_file import read_aria, read_vectormap
        from cogmap_gym.segment_plan import segment_plan

        read = read_vectormap if name.endswith(".txt") else read_aria
        try:
            return segment_plan(read(path), origin), origin
        except GEOSException as error:  # lines so close that rounding ties them in a knot
            raise ValueError(f"{path}: expected lines that can be joined, got: {error}") from error
    if name.endswith(PICTURES):
        raise ValueError(
            f"{path}: a picture needs a scale: expected "
            f'{{"image": {path.name!r}, "metres_per_pixel": 0.05}}, as a mapping or in a .yaml '
            f"file (show_map.py: --metres-per-pixel 0.05)"
        )
    raise ValueError(f"{path}: expected a file ending in one of {READABLE}, got {path.suffix!r}")


def _described(
    mapping: Mapping[str, Any], folder: Path, origin: str
) -> tuple[Mapping[str, Any], str]:
    """A plan as it is, or the plan that a bitmap shows."""
    if not any(key in mapping for key in BITMAP_KEYS):
        return mapping, origin
    from cogmap_gym.bitmap_file import read_bitmap
    from cogmap_gym.bitmap_plan import bitmap_plan

    return bitmap_plan(read_bitmap(mapping, folder, origin), origin), origin
