"""How much memory this process has held at most since a moment, on Linux."""

from __future__ import annotations

from pathlib import Path

CLEAR = Path("/proc/self/clear_refs")
STATUS = Path("/proc/self/status")
RESET_PEAK = "5"
"""Sets the peak to what is held now: proc(5), since Linux 4.0."""


def forget_peak() -> bool:
    """Begin to watch anew; False where this system can't."""
    try:
        CLEAR.write_text(RESET_PEAK)
    except OSError:
        return False
    return True


def peak_megabytes() -> float | None:
    """The most resident memory since ``forget_peak`` [MB], VmHWM; None where nobody tells."""
    try:
        lines = STATUS.read_text().splitlines()
    except OSError:
        return None
    told = [line.split()[1] for line in lines if line.startswith("VmHWM")]
    return float(told[0]) * 1024.0 / 1e6 if told else None
