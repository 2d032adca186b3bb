"""Where a row of a sweep comes from, the code and the robot's parameters; none are mixed."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from agents.registry import make_agent

DIGITS = 12
"""Of a digest [-]."""


def params_of(agent: Any) -> str:
    """A digest of a robot's parameters, empty for one without any.

    They are what it holds as ``params`` and every value of a class from a module named ``params``,
    in the robot and in what it has for a ``source`` of poses.
    """
    parts = (agent, getattr(agent, "source", None))
    told = [text for part in parts for text in _told(part)]
    return _digest("\n".join(told)) if told else ""


def _told(part: Any) -> list[str]:
    held = getattr(part, "__dict__", {})
    return [
        f"{name}={held[name]!r}"
        for name in sorted(held)
        if name == "params" or type(held[name]).__module__.rpartition(".")[2] == "params"
    ]


@cache
def commit() -> str:
    """The commit of the code, and a digest of what was changed since; outside git the version."""
    told = _git("describe", "--always", "--dirty=+")
    if told.endswith("+"):
        return told + _digest(_git("diff", "HEAD"))
    try:
        return told or f"version {version('cogmap-gym')}"
    except PackageNotFoundError:
        return "unknown"


def check_rows(path: Path, rows: Iterable[Mapping[str, str]], agents: Iterable[str]) -> None:
    """See that rows of a file come from this code and these robots as they are now.

    Args:
        path: the file, for messages.
        rows: what it holds.
        agents: the robots that shall run, by name.

    Raises:
        ValueError: a row is of another commit or of other parameters; it names file, field and
            both values.
    """
    params = {name: params_of(make_agent(name)) for name in agents}
    for row in rows:
        _check(path, "commit", row["commit"], commit())
        if row["agent"] in params and not (row["error"] and not row["params"]):
            _check(path, f"params of {row['agent']}", row["params"], params[row["agent"]])


def _check(path: Path, field: str, was: str, now: str) -> None:
    if was != now:
        raise ValueError(
            f"{path}: {field}: the file holds rows of {was!r}, now it is {now!r}; "
            f"take another folder, or --mix"
        )


def _git(*words: str) -> str:
    """What git says about the repository of this file; empty where it says nothing."""
    told = subprocess.run(  # noqa: S603 - the words stand above
        ["git", *words],  # noqa: S607 - git as the user has it
        cwd=Path(__file__).parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return told.stdout.strip()


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]
