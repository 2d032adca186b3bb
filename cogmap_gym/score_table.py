"""The tables of issues 2 and 3 from the rows of many episodes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from cogmap_gym.metrics import wilson

Row = Mapping[str, Any]
"""What ``cogmap_gym.metrics.score`` returns, with experiment, odometry, seed and literal; for
experiment 3 with what ``cogmap_gym.journey_scores.score_journeys`` returns."""
RING_QUESTIONS = {
    "a": "(a) loop closed by association",
    "b": "(b) six ASRs and links right after lap 1",
    "c": "(c) no second map after lap 2",
    "d": "(d) home within 1.0 m",
}
JOURNEY_QUESTIONS = {
    "goals": "all goals met",
    "phases": "every phase done, both laps too",
    "doors": "all goals met by the thesis's own doors in order",
    "network": "8 ASRs and 10 exits rightly linked at the end",
    "thesis": "own doors in order and the network right",
}
RING_ASKED = {"low": (0.95, 0.95, 0.95, 0.95), "medium": (0.92, 0.88, 0.90, 0.92)}
"""Least rates of a to d [-]. Issue 2; other levels are reported only."""
JOURNEY_ASKED = {
    "low": (0.92, None, None, None, 0.80),
    "medium": (0.80, None, None, None, 0.65),
}
"""Least rates in experiment 3 [-]. Issue 3; other levels are reported only."""
HEAD = "| figure | seen | 95 % interval | asked |\n|---|---|---|---|\n"


def rates_table(rows: Iterable[Row]) -> str:
    """A Markdown table for each experiment, level and parameter set, with its failures."""
    ordered = sorted(rows, key=lambda row: (*_group(row), row["seed"]))
    return "\n".join(_section(key, list(group)) for key, group in groupby(ordered, _group))


def questions_of(experiment: int) -> dict[str, str]:
    """The keys of a row that answer a question, each with the question."""
    return JOURNEY_QUESTIONS if experiment == 3 else RING_QUESTIONS


def broken(experiment: int, why: str, stage: str) -> dict[str, Any]:
    """The row of an episode that broke down: every question is answered by no."""
    questions = questions_of(experiment)
    failures = {"failures": [[stage, "raised", why]]} if experiment == 3 else {}
    whys = {f"{question}_why": why for question in questions}
    return {**dict.fromkeys(questions, False), **whys, **failures}


def reasons(row: Row) -> list[str]:
    """Why a run failed, cause by cause; nothing where it did not."""
    if row["experiment"] == 3:
        return [f"{stage}: {text}" for stage, _, text in row["failures"]]
    return [f"({q}) {row[f'{q}_why']}" for q in RING_QUESTIONS if not row[q]]


def _group(row: Row) -> tuple[int, str, bool]:
    return row["experiment"], row["odometry"], row["literal"]


def _section(key: tuple[int, str, bool], rows: Sequence[Row]) -> str:
    experiment, odometry, literal = key
    name = "Params.literal()" if literal else "default parameters"
    title = f"## Experiment {experiment}, {odometry} odometry, {name}, {len(rows)} runs\n\n"
    questions, asked = questions_of(experiment), _asked(experiment, odometry, literal=literal)
    lines = [
        _rate(text, sum(bool(row[q]) for row in rows), len(rows), least)
        for (q, text), least in zip(questions.items(), asked, strict=True)
    ]
    scored = [row for row in rows if "raised" not in row]
    lines += [] if not scored else [*_doors(scored), *_rooms(scored), *_drift(scored)]
    lines += [] if not scored else _surfaces(scored)
    stages = _stages(rows) if experiment == 3 else ""
    return f"{title}{HEAD}{''.join(lines)}\n{stages}{_failures(rows)}"


def _asked(experiment: int, odometry: str, *, literal: bool) -> tuple[float | None, ...]:
    nothing = (None,) * len(questions_of(experiment))
    asked: Mapping[str, tuple[float | None, ...]]
    asked = JOURNEY_ASKED if experiment == 3 else RING_ASKED
    return nothing if literal else asked.get(odometry, nothing)


def _rate(text: str, successes: int, trials: int, least: float | None) -> str:
    low, high = wilson(successes, trials)
    seen = f"{successes}/{trials} = {successes / trials:.1%}" if trials else "no trial"
    wanted = "" if least is None else f">= {least:.0%}"
    return f"| {text} | {seen} | {low:.1%} to {high:.1%} | {wanted} |\n"


def _value(text: str, seen: str, asked: str = "") -> str:
    return f"| {text} | {seen} | | {asked} |\n"


def _doors(rows: Sequence[Row]) -> list[str]:
    true, seen = (sum(row[key] for row in rows) for key in ("crossings", "noticed"))
    false = sum(row["false_crossings"] for row in rows) / len(rows)
    return [
        _rate("door crossings noticed", seen, true, 0.97),
        _value("false crossings a run", f"{false:.2f}", "<= 0.2"),
    ]


def _rooms(rows: Sequence[Row]) -> list[str]:
    asrs, closed = (sum(row[key] or 0 for row in rows) for key in ("asrs", "closed"))
    ious = [iou for row in rows for iou in row["ious"]]
    when = "at the end" if rows[0]["experiment"] == 3 else "after lap 1"
    return [
        _rate(f"ASR boundaries closed {when}", closed, asrs, 0.93),
        _value("IoU with the true room, median", _median(ious), ">= 0.85"),
        _value("IoU, tenth percentile", f"{np.quantile(ious, 0.1):.3f}" if ious else "-"),
    ]


def _drift(rows: Sequence[Row]) -> list[str]:
    both = [row for row in rows if row["mfis_error"] is not None]
    mfis, reckoned = ([row[key] for row in both] for key in ("mfis_error", "reckoning_error"))
    drifted = bool(both) and float(np.median(reckoned)) > 0.0
    ratio = f"{np.median(mfis) / np.median(reckoned):.3f}" if drifted else "-"
    after = [row["closed_error"] for row in both]
    return [
        _value("MFIS pose error on re-entering ASR1, median [m]", _median(mfis)),
        _value("dead reckoning's on the same runs, median [m]", _median(reckoned)),
        _value("ratio of the medians", ratio, "<= 0.2"),
        _value("MFIS pose error at the end of that stay, median [m]", _median(after)),
    ]


def _surfaces(rows: Sequence[Row]) -> list[str]:
    cover = [row["cover"] for row in rows if row["cover"] is not None]
    growth = [
        row["surfaces_2"] / row["surfaces_1"] - 1.0 for row in rows if row["cover"] is not None
    ]
    names, false = (sum(row[key] for row in rows) for key in ("names", "false_names"))
    broken = sum(len(row["edit_violations"]) for row in rows)
    return [
        _value("surface length over union after lap 2, median", _median(cover), "<= 1.1"),
        _value("surfaces after lap 2 against lap 1, median", _median(growth), "<= 0.200"),
        _rate("names of old surfaces right, all steps", names - false, names, None),
        _value("edits that do not lengthen along the line", str(broken), "0"),
    ]


def _median(values: Sequence[float]) -> str:
    return f"{float(np.median(values)):.3f}" if len(values) else "-"


def _stages(rows: Sequence[Row]) -> str:
    """The failures counted by stage and cause: once a run, and where they were its first."""
    first = Counter(tuple(row["failures"][0][:2]) for row in rows if row["failures"])
    every = Counter(key for row in rows for key in {tuple(f[:2]) for f in row["failures"]})
    order = sorted(every, key=lambda key: (key[0], -first[key], -every[key], key[1]))
    head = "| stage | cause | runs | first in |\n|---|---|---|---|\n"
    lines = [f"| {stage} | {cause} | {every[stage, cause]} | {first[stage, cause]} |\n"
             for stage, cause in order]  # fmt: skip
    what = "each run counts once; first in: in how many it came before all others"
    return f"Failures by stage and cause ({what}):\n\n{head}{''.join(lines)}\n"


def _failures(rows: Sequence[Row]) -> str:
    lines = [f"- seed {row['seed']}: {'; '.join(reasons(row))}" for row in rows if reasons(row)]
    lines += [f"- seed {row['seed']}: missed {', '.join(row['missed_at'])}" for row in rows
              if row.get("missed_at")]  # fmt: skip
    lines += [f"- seed {row['seed']}: false crossings at {row['false_at']}" for row in rows
              if row.get("false_at")]  # fmt: skip
    return "Failures by run:\n\n" + "\n".join(lines or ["- none"]) + "\n"
