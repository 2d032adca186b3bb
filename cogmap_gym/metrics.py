"""Scores of an episode of Thesis-v0 against the truth: the figures of issue 2.

A ``Record`` holds what was true and what the robot believed, step by step; ``score`` makes
one flat row of it. The four questions are

a. the loop closed by association: lap 1 done, and during the true stay in the first room
   that ends it, at least two old surfaces of that room named in views, none wrongly;
b. at the end of that stay the places are the true rooms, one to one, and the links right;
c. at the end of the stay after lap 2, at most 1.1 times as much surface as wall covered, in
   the mean, and at most 20 % more surfaces than at the moment of b;
d. each way home ended within 1.0 m of home.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.edit_log import edit_violations
from cogmap_gym.geometry import Array, Pose
from cogmap_gym.log_metrics import rigid_fit
from cogmap_gym.map_metrics import NO_WALL, cover_ratios
from cogmap_gym.naming import old_names
from cogmap_gym.run_record import Record, Step
from cogmap_gym.topology import Visit, boundary_ious, noticed

FORGOTTEN = -1
"""The tag of a surface that is no longer part of the map."""
WILSON_Z = 1.959964
"""The 97.5 % point of the normal distribution: two-sided 95 % [-]."""
LEAST_NAMED = 2
"""Old surfaces to be named on re-entry [-]. Issue 2 (a)."""
MOST_COVER = 1.1
"""Largest mean of surface length over union [-]. Issue 2 (c)."""
MOST_GROWTH = 0.2
"""Largest growth of the number of surfaces from lap 1 to lap 2 [-]. Issue 2 (c)."""


def wilson(successes: float, trials: int) -> tuple[float, float]:
    """The Wilson 95 % score interval of a rate (E. B. Wilson, JASA 22, 1927).

    Returns:
        Its lower and upper bound; 0 and 1 without a trial.
    """
    if trials == 0:
        return 0.0, 1.0
    share, z2 = successes / trials, WILSON_Z**2
    centre = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    spread = math.sqrt(share * (1 - share) / trials + z2 / (4 * trials**2))
    half = WILSON_Z * spread / (1 + z2 / trials)
    return max(0.0, centre - half), min(1.0, centre + half)


def dead_reckoning(odometry: Iterable[Array]) -> Array:
    """Poses (T, 3) in the frame of the first, from measured motions alone."""
    pose, out = Pose(), []
    for motion in odometry:
        pose = pose @ Pose(*(float(v) for v in motion))
        out.append((pose.x, pose.y, pose.theta))
    return np.array(out).reshape(-1, 3)


def position_error(start: Array, true: Array, believed: Array) -> float:
    """How far a believed pose lies from the true one [m].

    Args:
        start: (3,) the true pose at the first step, where the believed frame lies.
        true: (3,) the true pose.
        believed: (3,) in the believed frame.
    """
    plan_from_start = Pose(*(float(v) for v in start))
    return float(np.hypot(*(plan_from_start.apply(believed[:2]) - true[:2])))


def score(record: Record) -> dict[str, Any]:
    """All figures of one episode, JSON-able; None where the episode did not get so far."""
    laps = record.lap_ends()
    first = laps[0] if laps else None
    second = laps[1] if len(laps) > 1 else None
    return {
        **_loop(record, first),
        **_network(record, first),
        **_doubles(record, first, second),
        **_homes(record),
        **_doors(record),
        **_drift(record, first),
        **_proofs(record),
    }


def _loop(record: Record, stay: Visit | None) -> dict[str, Any]:
    """Question a."""
    if stay is None:
        where = record.visits[-1].room if record.steps else "nowhere"
        return {"a": False, "a_why": f"lap 1 not done, last in {where}", "named": None}
    names = old_names(record, stay.first, stay.last, stay.first, record.steps[0].place)
    why = [f"{len(names.right)} named"] if len(names.right) < LEAST_NAMED else []
    why += [f"wrong: {sorted(names.wrong)}"] if names.wrong else []
    return {"a": not why, "a_why": "; ".join(why), "named": len(names.right)}


def _network(record: Record, stay: Visit | None) -> dict[str, Any]:
    """Question b, and the boundaries at that moment."""
    if stay is None:
        return {"b": False, "b_why": "lap 1 not done", "asrs": None, "closed": None, "ious": []}
    faults = record.network_faults(stay.last, record.rooms)
    return {
        "b": not faults,
        "b_why": "; ".join(fault.text for fault in faults),
        **boundary_scores(record, stay.last),
    }


def boundary_scores(record: Record, until: int) -> dict[str, Any]:
    """How many ASRs there are at a step, how many closed, and their IoU with the true rooms."""
    boundaries = record.steps[until].boundaries
    plan_from_map = rigid_fit(_believed(record)[:, :2], record.poses[:, :2])
    ious = boundary_ious(boundaries, record.rooms_of_places(until), plan_from_map, record.plan)
    return {
        "asrs": len(boundaries),
        "closed": sum(len(boundary) > 0 for boundary in boundaries.values()),
        "ious": [round(iou, 4) for iou in ious.values()],
    }


def _believed(record: Record) -> Array:
    return np.array([step.believed for step in record.steps])


def _doubles(record: Record, first: Visit | None, second: Visit | None) -> dict[str, Any]:
    """Question c."""
    if first is None or second is None:
        lap = 1 if first is None else 2
        nothing = {"cover": None, "surfaces_1": None, "surfaces_2": None}
        return {"c": False, "c_why": f"lap {lap} not done", **nothing}
    counts = [len(_kept(record.steps[stay.last])) for stay in (first, second)]
    step = record.steps[second.last]
    kept = _kept(step)
    ratios = cover_ratios(step.surfaces[kept], kept + 1, record.origins, record.faces)
    cover, growth = float(ratios.mean()), counts[1] / counts[0] - 1.0
    why = [f"covered {cover:.2f}x"] if cover > MOST_COVER else []
    why += [f"{growth:+.0%} surfaces"] if growth > MOST_GROWTH else []
    return {
        "c": not why,
        "c_why": "; ".join(why),
        "cover": cover,
        "surfaces_1": counts[0],
        "surfaces_2": counts[1],
    }


def _kept(step: Step) -> NDArray[np.int64]:
    """The rows of the surfaces that are part of the map."""
    return np.flatnonzero(step.entered & (step.tags != FORGOTTEN))


def _homes(record: Record) -> dict[str, Any]:
    """Question d."""
    done = [ok for task, ok in zip(record.tasks, record.successes, strict=True) if task == "home"]
    why = [f"way home {k + 1} failed" for k, ok in enumerate(done) if not ok]
    why += [] if done else ["no way home was begun"]
    return {
        "d": not why,
        "d_why": "; ".join(why),
        "home_distance": record.final_distance,
    }


def _doors(record: Record) -> dict[str, Any]:
    true, began = record.crossings, record.believed_crossings
    result = noticed(true, began)
    seen = {row for row, _ in result.pairs}
    claimed = {k for _, k in result.pairs}
    return {
        "crossings": result.true,
        "noticed": len(result.pairs),
        "false_crossings": result.false,
        "missed_at": [f"{c.door}@{c.step}" for k, c in enumerate(true) if k not in seen],
        "false_at": [t for k, t in enumerate(began) if k not in claimed],
    }


def _drift(record: Record, stay: Visit | None) -> dict[str, Any]:
    """Errors of the two poses at the first step back in the first room, before any association."""
    if stay is None:
        return {"mfis_error": None, "reckoning_error": None, "closed_error": None}
    reckoned = dead_reckoning(step.odometry for step in record.steps)
    start, poses, back = record.poses[0], record.poses, stay.first
    believed = _believed(record)
    return {
        "mfis_error": position_error(start, poses[back], believed[back]),
        "reckoning_error": position_error(start, poses[back], reckoned[back]),
        "closed_error": position_error(start, poses[stay.last], believed[stay.last]),
    }


def _proofs(record: Record) -> dict[str, Any]:
    names = old_names(record, 0, len(record.steps), len(record.steps), None)
    last = record.steps[-1]
    entered = {row + 1: last.surfaces[row] for row in np.flatnonzero(last.entered).tolist()}
    return {
        "steps": len(record.steps),
        "names": names.total,
        "false_names": names.false,
        "phantoms": sum(origin.line == NO_WALL for origin in record.origins.values()),
        "edit_violations": edit_violations(record.edits, entered),
    }
