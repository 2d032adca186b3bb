"""A table in a file that grows by whole rows, whatever happens to who writes it."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any


class ResultFile:
    """Rows in a CSV file, appended line by line; whoever is killed leaves whole lines."""

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        """Open the file, or begin it; a last line that was cut short is cut off.

        Args:
            path: the file; its folder is made.
            columns: their names, in order.

        Raises:
            ValueError: the file is of other columns.
        """
        self.path, self.columns = path, tuple(columns)
        path.parent.mkdir(parents=True, exist_ok=True)
        head = _line(columns)
        if not path.exists():
            path.write_bytes(head)
        content = path.read_bytes()
        if not content.startswith(head):
            raise ValueError(f"{path}: expected the columns {','.join(columns)}")
        whole = content[: content.rfind(b"\n") + 1]
        if whole != content:
            os.truncate(path, len(whole))

    def rows(self) -> list[dict[str, str]]:
        """All rows, as text."""
        with self.path.open(newline="") as file:
            return list(csv.DictReader(file))

    def done(self, key: Sequence[str]) -> set[tuple[str, ...]]:
        """The keys of all rows, as text; a key is the values of some columns."""
        return {tuple(row[name] for name in key) for row in self.rows()}

    def add(self, row: Mapping[str, Any]) -> None:
        """Append a row in one write, and see it to the disk."""
        line = _line(["" if row[name] is None else row[name] for name in self.columns])
        with self.path.open("ab", buffering=0) as file:
            file.write(line)
            os.fsync(file.fileno())


def _line(values: Iterable[Any]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(values)
    return text.getvalue().encode()
