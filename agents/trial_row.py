"""The columns of a row of a sweep: scores of one trial, of what was true and what was believed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import shapely

from agents.rollout import Episode
from agents.watch import Watch
from cogmap_gym.courses import EXPLORED
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, Points
from cogmap_gym.oracle_tour import tour_length
from cogmap_gym.trial_scores import (
    CURVE_POINTS,
    SHARES,
    coverage_curve,
    curve_area,
    distance_area,
    distance_curve,
    distance_to,
    goal_scores,
    horizon,
)

Row = dict[str, Any]
PATH_M = 0.05
"""How far a path may lie from where the robot went, as it stands in the file [m]. Ours."""
GOAL_SCORES = ("spl", "spl_learning", "soft_spl")
"""Scores of trials with goals."""
SHARES_SEEN = ("coverage", "area", "coverage_auc")
"""Scores of any trial."""
BELIEFS = (
    "ate", "rpe", "map_scale", "map_distortion", "pointing_home", "pointing_places",
    "rooms_found", "link_precision", "link_recall", "edit_distance", "exit_order",
)  # fmt: skip
"""Scores of what a robot believed, as far as it tells."""
SCORES = (
    "success", "goals", "goals_met", *GOAL_SCORES, *SHARES_SEEN,
    *(f"distance_{share:.0%}" for share in SHARES), "tour_ratio", "moves", "path_length",
    "collisions", "reward", *BELIEFS, "plan_area", "tour", "doors_changed", "boxes_moved",
    "curve", "distance_curve", "path", "marks", "cpu_ms", "peak_mb", "map_bytes", "commit",
    "params", "error",
)  # fmt: skip
"""What a row tells of its trial."""
TIMES = ("cpu_ms", "peak_mb")
"""Columns that differ from run to run."""


def nothing(goals: int) -> Row:
    """The scores of a trial that broke down: nought, and all its goals missed.

    Args:
        goals: how many it had.
    """
    flat = curve_text(np.zeros(CURVE_POINTS))
    scores: Row = dict.fromkeys((*SHARES_SEEN, *(GOAL_SCORES if goals else ())), 0.0)
    counts = {"goals": goals, "goals_met": 0} if goals else {}
    return {"success": 0, **counts, **scores, "curve": flat, "distance_curve": flat}


def plan_columns(plan: FloorPlan, name: str) -> Row:
    """The columns that tell of the plan: its free area [m^2] and the oracle's tour [m].

    Args:
        plan: the truth.
        name: the keyword ``map``.
    """
    return {"plan_area": plan.area, "tour": _tour_length(name)}


def scores_of(watch: Watch, episode: Episode, env: Any, name: str) -> Row:
    """The columns of an episode that came to its end.

    Args:
        watch: what was written down on the way.
        episode: how it went.
        env: its environment, unwrapped.
        name: the keyword ``map``.
    """
    seen = np.array([*watch.seen, episode.info["coverage"]])
    driven = np.array([*watch.driven, episode.info["path_length"]])
    goals = [phase for phase in episode.phases if phase["task"] != "explore"]
    known = plan_columns(env.plan, name)
    far, reached = horizon(known["tour"]), distance_to(EXPLORED, seen, driven)
    marks = {mark: pose.position for mark, pose in env.task.marks.items()}
    return {
        "success": int(episode.is_success),
        **goal_scores(goals, episode.info, env.task.goals),
        "coverage": float(seen[-1]),
        "area": curve_area(seen, env.max_moves),
        "coverage_auc": distance_area(seen, driven, far),
        **{f"distance_{share:.0%}": distance_to(share, seen, driven) for share in SHARES},
        "tour_ratio": None if reached is None or not known["tour"] else reached / known["tour"],
        "moves": episode.steps,
        "path_length": float(driven[-1]),
        "collisions": watch.bumps,
        "reward": episode.reward,
        **watch.beliefs(),
        **known,
        **watch.changes(),
        "curve": curve_text(coverage_curve(seen, env.max_moves)),
        "distance_curve": curve_text(distance_curve(seen, driven, far)),
        "path": path_text(episode.path[:, :2]),
        "marks": ";".join(f"{k},{x:.2f},{y:.2f}" for k, (x, y) in sorted(marks.items())),
        "cpu_ms": 1e3 * float(np.median(watch.seconds)),
    }


@cache
def _tour_length(name: str) -> float:
    """Of a plan, by the keyword ``map``; kept, for it takes seconds."""
    return tour_length(FloorPlan.load(name))


def curve_text(curve: Array) -> str:
    """A curve as it stands in the file."""
    return ";".join(f"{share:.4f}" for share in curve)


def path_text(path: Points) -> str:
    """A path (N, 2) as it stands in the file, without points that tell nothing."""
    line = shapely.remove_repeated_points(shapely.LineString(path), PATH_M)
    points = shapely.get_coordinates(shapely.simplify(line, PATH_M))
    return ";".join(f"{x:.2f},{y:.2f}" for x, y in points)
