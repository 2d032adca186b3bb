"""Rows of a sweep, made by hand."""

from __future__ import annotations

from agents.sweep import COLUMNS


def row(agent: str, task: str, odometry: str, seed: int, **told: object) -> dict[str, str]:
    """A row, as text, that tells nothing but this."""
    key = {"agent": agent, "task": task, "map": "m", "odometry": odometry, "seed": seed}
    every = {**dict.fromkeys(COLUMNS, ""), "dynamics": "off", **key, **told}
    return {name: str(value) for name, value in every.items()}


GOALS = [
    row("a", "goto", "low", 0, goals=4, goals_met=3, soft_spl=0.6, cpu_ms=2.0),
    row("a", "goto", "low", 1, goals=4, goals_met=4, soft_spl=0.8, cpu_ms=4.0),
    row(
        "b", "goto", "low", 0, goals=4, goals_met=0, soft_spl=0.0,
        error="Traceback | ValueError: <oops>",
    ),
]  # fmt: skip
SEEN = [
    row("a", "explore", "low", 0, success=1, area=0.9, curve="0.1;0.9;1.0"),
    row("a", "explore", "high", 0, success=0, area=0.5, curve="0.1;0.5;0.6"),
]
