"""Plan files: where they lie, and how they are read and written.

What a file says is checked in ``cogmap_gym.plan_schema``.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from cogmap_gym.plan_schema import KEYS, shown

MAX_BYTES = 32 * 1024 * 1024
"""Largest file that is read [bytes]. Ours: some 10^6 points; larger is a mistake."""
MAX_DEPTH = 8
"""Deepest nesting of a file [-]. Ours: a plan needs 4; the YAML library crashes at 10^5."""


class _Loader(yaml.CSafeLoader):
    """A safe loader that refuses a key written twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            name = str(key.value)
            if name in seen:
                message = f"the key {name!r} stands twice"
                raise yaml.constructor.ConstructorError(None, None, message, key.start_mark)
            seen.add(name)
        return super().construct_mapping(node, deep)


def maps_folder() -> Path:
    """The folder of the packaged plans: in the wheel, else in the repository."""
    packaged = Path(str(resources.files("cogmap_gym") / "maps"))
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[1] / "maps"


def map_names() -> tuple[str, ...]:
    """Names of the packaged plans, sorted."""
    return tuple(sorted(path.stem for path in maps_folder().glob("*.yaml")))


def find(source: str | Path) -> Path:
    """The file that a packaged name or a path stands for.

    Raises:
        ValueError: no such plan; lists the packaged names.
    """
    if str(source) in map_names():
        return maps_folder() / f"{source}.yaml"
    if not _is_file(Path(source)):
        raise ValueError(
            f"map: expected a file or one of {map_names()} or office:SEED, got {str(source)!r}"
        )
    return Path(source)


def read(path: Path) -> Mapping[str, Any]:
    """The mapping that a YAML file holds.

    Raises:
        ValueError: the file is too large, not text, not YAML, or holds no mapping.
    """
    size = path.stat().st_size
    if size > MAX_BYTES:
        raise ValueError(f"{path}: expected a plan of at most {MAX_BYTES} bytes, got {size}")
    try:
        text = path.read_text(encoding="utf-8")
        _check_depth(text)
        content = yaml.load(text, Loader=_Loader)  # noqa: S506 (a safe loader)
    except (yaml.YAMLError, ValueError, OSError) as error:
        raise ValueError(f"{path}: expected a plan in YAML, got: {error}") from error
    if not isinstance(content, Mapping):
        raise ValueError(f"{path}: expected a mapping of {KEYS}, got {shown(content)}")
    return content


def write(mapping: Mapping[str, Any], path: Path) -> None:
    """Write a mapping as YAML, one polyline or polygon a line, all or nothing."""
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        draft.write_text("".join(map(_lines, mapping.keys(), mapping.values())), encoding="utf-8")
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long a name, or a zero byte in it
        return False


def _check_depth(text: str) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            raise ValueError(f"lists nested more than {MAX_DEPTH} deep")


def _lines(key: str, value: Any) -> str:
    if isinstance(value, dict) and value:
        return f"{key}:\n" + "".join(f"  {_flow(k)}: {_flow(v)}\n" for k, v in value.items())
    if key in ("walls", "furniture") and value:
        return f"{key}:\n" + "".join(f"  - {_flow(item)}\n" for item in value)
    return f"{key}: {_flow(value)}\n"


def _flow(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, width=math.inf, allow_unicode=True)
    return text.removesuffix("\n").removesuffix("\n...")
