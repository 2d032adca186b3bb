"""The table of issue 2 from the rows of many episodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from cogmap_gym.metrics import wilson

Row = Mapping[str, Any]
"""What ``cogmap_gym.metrics.score`` returns, with experiment, odometry, seed and literal."""
QUESTIONS = {
    "a": "(a) loop closed by association",
    "b": "(b) six ASRs and links right after lap 1",
    "c": "(c) no second map after lap 2",
    "d": "(d) home within 1.0 m",
}
ASKED = {"low": (0.95, 0.95, 0.95, 0.95), "medium": (0.92, 0.88, 0.90, 0.92)}
"""Least rates of a to d [-]. Issue 2; other levels are reported only."""
HEAD = "| figure | seen | 95 % interval | asked |\n|---|---|---|---|\n"


def rates_table(rows: Iterable[Row]) -> str:
    """A Markdown table for each experiment, level and parameter set, with its failures."""
    ordered = sorted(rows, key=lambda row: (*_group(row), row["seed"]))
    return "\n".join(_section(key, list(group)) for key, group in groupby(ordered, _group))


def _group(row: Row) -> tuple[int, str, bool]:
    return row["experiment"], row["odometry"], row["literal"]


def _section(key: tuple[int, str, bool], rows: Sequence[Row]) -> str:
    experiment, odometry, literal = key
    name = "Params.literal()" if literal else "default parameters"
    title = f"## Experiment {experiment}, {odometry} odometry, {name}, {len(rows)} runs\n\n"
    asked = (None,) * 4 if literal else ASKED.get(odometry, (None,) * 4)
    lines = [
        _rate(text, sum(bool(row[q]) for row in rows), len(rows), least)
        for (q, text), least in zip(QUESTIONS.items(), asked, strict=True)
    ]
    scored = [row for row in rows if "raised" not in row]
    lines += [] if not scored else [*_doors(scored), *_rooms(scored), *_drift(scored)]
    lines += [] if not scored else _surfaces(scored)
    return f"{title}{HEAD}{''.join(lines)}\n{_failures(rows)}"


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
    return [
        _rate("ASR boundaries closed after lap 1", closed, asrs, 0.93),
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


def _failures(rows: Sequence[Row]) -> str:
    lines = [
        f"- seed {row['seed']}: "
        + "; ".join(f"({q}) {row[f'{q}_why']}" for q in QUESTIONS if not row[q])
        for row in rows
        if not all(row[q] for q in QUESTIONS)
    ]
    lines += [f"- seed {row['seed']}: missed {', '.join(row['missed_at'])}" for row in rows
              if row.get("missed_at")]  # fmt: skip
    lines += [f"- seed {row['seed']}: false crossings at {row['false_at']}" for row in rows
              if row.get("false_at")]  # fmt: skip
    return "Failures by run:\n\n" + "\n".join(lines or ["- none"]) + "\n"
