"""The peak is that since it was forgotten."""

from __future__ import annotations

import numpy as np
import pytest

from cogmap_gym.peak_memory import forget_peak, peak_megabytes

HELD = 25_000_000
"""Numbers of 8 bytes: 200 MB."""


def test_the_peak_rises_with_what_is_held_and_is_forgotten() -> None:
    if not forget_peak():
        pytest.skip("this system keeps no peak that can be forgotten")
    before = peak_megabytes()
    assert before is not None
    held = np.ones(HELD)
    peak = peak_megabytes()
    assert peak is not None
    assert peak > before + 0.9 * held.nbytes / 1e6
    del held
    again = peak_megabytes()
    assert again is not None
    assert again > peak - 10.0, "what was held is remembered; the kernel counts roughly"
    forget_peak()
    now = peak_megabytes()
    assert now is not None
    assert now < peak - 100.0
