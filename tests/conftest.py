"""What every test shares: no display, and the same examples on every run."""

from __future__ import annotations

import os

from hypothesis import settings

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "agg")

settings.register_profile("same", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("same")
