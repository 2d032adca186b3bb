"""Scores of experiment 3 against the truth: the goals, the doors on the way, the network.

The questions of issue 3 are

- goals: every way home and to a place came out well;
- phases: so did both laps;
- doors: the goals were met, and each by the doors of the thesis's own robot, in order; a
  turn-back within 1 m of a door is not counted;
- network: at the end the places are the eight true rooms, one to one, and the ten links right;
- thesis: doors and network both.

What went wrong is told by stage, which is a phase by its number and task, and by cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Array, point_segment_distances
from cogmap_gym.metrics import boundary_scores
from cogmap_gym.run_record import Record
from cogmap_gym.thesis_tasks import CHORDS, OWN_DOORS, PHASES, RING
from cogmap_gym.topology import Crossing

EXPERIMENT = 3
"""The experiment that is judged here."""
TURN_BACK_M = 1.0
"""Crossing a door and back without going farther from it is no crossing [m]. Issue 3."""
STAGES = tuple(
    f"{number} {phase.task.replace('explore', 'lap')}"
    for number, phase in enumerate(PHASES[EXPERIMENT], start=1)
)
"""The names of the phases."""


@dataclass(frozen=True, slots=True)
class Failure:
    """One thing that went wrong."""

    phase: int
    """In which phase, from 0."""
    question: str
    """``"goals"``, ``"laps"``, ``"doors"`` or ``"network"``."""
    cause: str
    """In few words, the same for all runs in which it went wrong like that."""
    text: str
    """As it was in this run."""


def score_journeys(record: Record) -> dict[str, Any]:
    """All figures of an episode of experiment 3 that ``metrics.score`` does not have.

    The boundaries are those at the end.
    """
    doors = doors_by_phase(record)
    phases = range(len(STAGES))
    found = [f for k in phases for f in (*_outcome(record, k), *_route(record, k, doors[k]))]
    found = sorted((*found, *_network(record)), key=lambda failure: failure.phase)
    causes = {
        "goals": ("goals",),
        "phases": ("goals", "laps"),
        "doors": ("goals", "doors"),
        "network": ("network",),
        "thesis": ("goals", "doors", "network"),
    }
    why = {name: [_say(f) for f in found if f.question in kinds] for name, kinds in causes.items()}
    return {
        **{name: not texts for name, texts in why.items()},
        **{f"{name}_why": "; ".join(texts) for name, texts in why.items()},
        "failures": [[STAGES[f.phase], f.cause, f.text] for f in found],
        "doors_by_phase": doors,
        **boundary_scores(record, len(record.steps) - 1),
    }


def _say(failure: Failure) -> str:
    return f"{STAGES[failure.phase]}: {failure.text}"


def doors_by_phase(record: Record) -> list[list[str]]:
    """For each phase the doors truly crossed, in order, without turn-backs.

    A move belongs to the phase in which it was decided on, even if it ends that phase.
    """
    moved_in = [record.steps[crossing.step - 1].phase for crossing in record.crossings]
    return [
        without_turn_backs(
            record.plan,
            record.poses,
            [c for c, phase in zip(record.crossings, moved_in, strict=True) if phase == k],
        )
        for k in range(len(STAGES))
    ]


def without_turn_backs(plan: FloorPlan, poses: Array, crossings: Sequence[Crossing]) -> list[str]:
    """The doors of some crossings, less those crossed and at once crossed back again.

    Both crossings drop out if the robot was never farther than 1 m from the door between them.

    Args:
        plan: the truth.
        poses: (T, 3) true poses.
        crossings: in order of time.
    """
    kept: list[Crossing] = []
    for crossing in crossings:
        if kept and kept[-1].door == crossing.door:
            between = poses[kept[-1].step : crossing.step, :2]
            gaps = point_segment_distances(between, plan.doors[crossing.door][None])
            if gaps.max() <= TURN_BACK_M:
                kept.pop()
                continue
        kept.append(crossing)
    return [crossing.door for crossing in kept]


def route_fault(crossed: Sequence[str], wanted: Sequence[str]) -> str:
    """How a way differs first from the one that it should be; empty where it does not."""
    same = 0
    while same < min(len(crossed), len(wanted)) and crossed[same] == wanted[same]:
        same += 1
    more, missing = crossed[same:], wanted[same:]
    if not more:
        return f"did not cross {missing[0]}" if missing else ""
    rest = iter(more)
    if all(door in rest for door in missing):
        return f"extra crossing of {more[0]}"
    return f"took {more[0]} instead of {missing[0]}"


def _outcome(record: Record, phase: int) -> list[Failure]:
    """Whether a phase came out well, and how it ended if not."""
    if phase < len(record.successes) and record.successes[phase]:
        return []
    plan = PHASES[EXPERIMENT][phase]
    steps = [step for step in record.steps if step.phase == phase]
    question = "goals" if plan.goal else "laps"
    if not steps:
        return [Failure(phase, question, "never begun", "never begun, its mark was not given")]
    x, y = steps[-1].pose[:2].tolist()
    where = f"in {record.plan.room_at(x, y) or 'a doorway'} at ({x:.1f}, {y:.1f})"
    if plan.goal and len(steps) < plan.budget:
        text = f"declared {where}"
        return [Failure(phase, question, "declared in the wrong place", text)]
    text = f"not done in {len(steps)} moves, last {where}"
    return [Failure(phase, question, "budget used up", text)]


def _route(record: Record, phase: int, crossed: Sequence[str]) -> list[Failure]:
    """Whether a goal was gone to by the thesis's own doors."""
    wanted = OWN_DOORS[phase]
    if wanted is None or not any(step.phase == phase for step in record.steps):
        return []
    cause = route_fault(crossed, wanted)
    if not cause or (cause.startswith("did not") and not record.successes[phase]):
        return []  # a goal that was not met has failed already
    text = f"{cause} ({' '.join(crossed) or 'no door'}, not {' '.join(wanted) or 'none'})"
    return [Failure(phase, "doors", cause, text)]


def _network(record: Record) -> list[Failure]:
    """The faults of the network at the end, each in the phase since which it stood."""
    ends = [_last_step(record, phase) for phase in range(len(STAGES))]
    by_phase = [
        {(fault.kind, fault.about): fault for fault in record.network_faults(end, _rooms(phase))}
        for phase, end in enumerate(ends)
    ]
    failures = []
    for key, fault in by_phase[-1].items():
        since = len(STAGES) - 1
        while since > 0 and key in by_phase[since - 1]:
            since -= 1
        failures.append(Failure(since, "network", fault.kind, fault.text))
    return failures


def _last_step(record: Record, phase: int) -> int:
    """The last step of a phase, or of those before."""
    return max((t for t, step in enumerate(record.steps) if step.phase <= phase), default=0)


def _rooms(phase: int) -> tuple[str, ...]:
    """The rooms that the thesis's robot had been in at the end of a phase."""
    return (*RING, *(room for room, first in CHORDS.items() if phase >= first))
