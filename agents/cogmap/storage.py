"""The robot's memory in a file: plain arrays and JSON in one ``.npz``, nothing executable."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.asr import ASR
from agents.cogmap.association import Beams
from agents.cogmap.exits import Exit
from agents.cogmap.mapper import Mapping
from agents.cogmap.memory import Intent, Journey, Leads, Mark, Memory, Stay
from agents.cogmap.mfis import MFIS
from agents.cogmap.places import Network
from agents.cogmap.view import View
from cogmap_gym.geometry import Pose

KINDS: dict[str, Callable[..., Any]] = {
    kind.__name__: kind
    for kind in (
        ASR,
        Beams,
        Exit,
        Intent,
        Journey,
        Leads,
        Mapping,
        Mark,
        Memory,
        MFIS,
        Network,
        Pose,
        Stay,
        View,
    )
}
"""What a memory is made of; a file that names anything else is refused."""
VERSION = 1
"""Of the file's layout."""

Array = NDArray[Any]


def write_memory(path: str | Path, memory: Memory) -> None:
    """Write a memory to a file, whole or not at all.

    Args:
        path: the file, ``.npz`` by custom.
        memory: what to keep.
    """
    arrays: list[Array] = []
    text = json.dumps({"version": VERSION, "memory": _packed(memory, arrays)})
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(target.name + ".part")
    with part.open("wb") as file:
        named: dict[str, Any] = {f"a{k}": a for k, a in enumerate(arrays)}
        named["text"] = np.frombuffer(text.encode(), np.uint8)
        np.savez_compressed(file, **named)
    part.replace(target)


def memory_bytes(memory: Memory) -> int:
    """How large a memory is when nothing is compressed [bytes]."""
    arrays: list[Array] = []
    text = json.dumps(_packed(memory, arrays))
    return len(text) + sum(array.nbytes for array in arrays)


def read_memory(path: str | Path) -> Memory:
    """Read a memory from a file.

    Args:
        path: a file of ``write_memory``.

    Raises:
        ValueError: the file is not one, or of another version; it names the file.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            content = json.loads(bytes(file["text"]).decode())
            if content.get("version") != VERSION:
                raise ValueError(f"expected version {VERSION}, got {content.get('version')!r}")
            memory = _unpacked(content["memory"], dict(file))
    except (
        OSError,
        EOFError,
        KeyError,
        TypeError,
        ValueError,
        AttributeError,
        zipfile.BadZipFile,
    ) as error:
        raise ValueError(f"{path}: not a memory of the cogmap robot: {error}") from error
    if not isinstance(memory, Memory):
        raise ValueError(f"{path}: expected a Memory, got {type(memory).__name__}")
    return memory


def _packed(value: Any, arrays: list[Array]) -> Any:
    """A value as JSON; arrays go to the list, and their place in it into the JSON."""
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, tuple):
        return {"tuple": [_packed(v, arrays) for v in value]}
    if isinstance(value, frozenset):
        return {"set": sorted(value)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [f.name for f in dataclasses.fields(value)]
        return {
            "kind": type(value).__name__,
            "fields": {n: _packed(getattr(value, n), arrays) for n in names},
        }
    assert value is None or isinstance(value, str | int | float), f"cannot keep a {type(value)}"
    return value


def _unpacked(value: Any, arrays: dict[str, Array]) -> Any:
    """The inverse of ``_packed``."""
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[f"a{value['array']}"]
    if "tuple" in value:
        return tuple(_unpacked(v, arrays) for v in value["tuple"])
    if "set" in value:
        return frozenset(value["set"])
    fields = {name: _unpacked(v, arrays) for name, v in value["fields"].items()}
    return KINDS[value["kind"]](**fields)
