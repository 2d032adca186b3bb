"""The Python of README.md runs as it stands, one block after the other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image

from tests.drawings import two_rooms

README = Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", README.read_text("utf-8"), re.DOTALL | re.MULTILINE)


@pytest.mark.slow
def test_every_block_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(two_rooms()).save("plan.png")
    names: dict[str, object] = {}
    for block in BLOCKS:
        exec(compile(block, str(README), "exec"), names)  # what a reader would paste
    assert len(BLOCKS) >= 3
