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
    row("a", "explore", "low", 0, success=1, coverage_auc=0.9, curve="0.1;0.9;1.0",
        distance_curve="0.1;0.8;1.0", path="1.00,1.00;3.00,1.00", marks="1,2.00,2.50",
        coverage=0.96, path_length=2.0, plan_area=38.5, map="two_rooms", boxes_moved=0,
        doors_changed=1),
    row("a", "explore", "high", 0, success=0, coverage_auc=0.5, curve="0.1;0.5;0.6",
        distance_curve="0.1;0.4;0.6", plan_area=250, boxes_moved=4, doors_changed=7),
]  # fmt: skip
