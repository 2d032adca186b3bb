"""Files written whole: whoever reads one sees the old file or all of the new one."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure

DPI = 180
"""Pixels an inch: letters of 5 pt are 12 pixels high."""


def save_png(figure: Figure, path: Path) -> Path:
    """Write a figure; returns its path."""
    figure.savefig(buffer := io.BytesIO(), format="png", dpi=DPI)
    return write_whole(path, buffer.getvalue())


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file so that a reader sees the old one or the whole new one."""
    part = path.with_name(f".{path.name}.part")
    part.write_bytes(content)
    return part.replace(path)
