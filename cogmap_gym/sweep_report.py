"""The page of a sweep, self-contained: tables with intervals, figures, failures, where it is from.

A row is what ``agents/sweep.py`` writes, as text.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from cogmap_gym.statistics import Interval
from cogmap_gym.sweep_overview import NOTE, overviews
from cogmap_gym.sweep_table import EXPLORE, Cell, Duel, Row, grouped, quartiles, rank

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>cogmap_gym: sweep</title><style>
body {{ font: 15px/1.5 sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; margin: 1em 0; }}
th, td {{ padding: 0.25em 0.8em; text-align: right; border-bottom: 1px solid #ddd; }}
th:first-child, td:first-child {{ text-align: left; position: sticky; left: 0; background: #fff; }}
td {{ white-space: nowrap; }}
img {{ max-width: 100%; }}
div {{ overflow-x: auto; font-size: 85%; }}
</style></head><body>
<h1>Sweep</h1>
<p>{head}</p>
{body}
</body></html>
"""
INTERVALS = (
    "In brackets 95 % intervals. Rates of one outcome a trial: Wilson. Rates of several goals a "
    "trial: cluster bootstrap, which draws trials, not goals, within each map. Scores: "
    "interquartile mean, bootstrap stratified by map. A trial that broke down scores 0 and "
    "misses all its goals."
)
QUARTILES = (
    "Medians, in brackets quartiles, over the trials that tell it; a distance that was never "
    "reached is infinite. Distances to a share of the free area seen; the ratio is that to 95 % "
    "over a near-optimal tour on the true plan. ATE and RPE of the pose believed at the time."
)
MEASURES = {
    "distance_90%": ("to 90 % [m]", ".0f", 1.0),
    "distance_95%": ("to 95 % [m]", ".0f", 1.0),
    "tour_ratio": ("over the tour", ".1f", 1.0),
    "spl": ("SPL", ".2f", 1.0),
    "collisions": ("contacts", ".0f", 1.0),
    "moves": ("moves", ".0f", 1.0),
    "path_length": ("way [m]", ".0f", 1.0),
    "ate": ("ATE [m]", ".2f", 1.0),
    "rpe": ("RPE over 10 m [m]", ".2f", 1.0),
    "pointing_home": ("pointing home [deg]", ".1f", 1.0),
    "pointing_places": ("pointing to places [deg]", ".1f", 1.0),
    "map_scale": ("scale of the map", ".2f", 1.0),
    "map_distortion": ("distortion index [%]", ".1f", 1.0),
    "rooms_found": ("rooms found [%]", ".0f", 100.0),
    "link_precision": ("link precision [%]", ".0f", 100.0),
    "link_recall": ("link recall [%]", ".0f", 100.0),
    "edit_distance": ("edit distance", ".0f", 1.0),
    "exit_order": ("exits in order [%]", ".0f", 100.0),
    "cpu_ms": ("CPU a step [ms]", ".1f", 1.0),
    "peak_mb": ("peak memory [MB]", ".0f", 1.0),
    "map_bytes": ("map [kB]", ".0f", 1e-3),
}
"""Columns of the second table of a task: head, form, and factor from the file's unit."""
DUELS = (
    "Both on the same trials. Difference: mean of the score's differences, paired by trial. Beats: "
    "probability of improvement, the share of pairs of trials on a map in which the robot's score "
    "is the higher, a draw counting half. In brackets 95 % intervals, bootstrap stratified by map."
)


def report_page(
    rows: Sequence[Row],
    found: Sequence[Cell],
    against: Sequence[Duel],
    baseline: str,
    pictures: Mapping[str, Figure],
) -> str:
    """The whole page as HTML, pictures within.

    Args:
        rows: all trials.
        found: the leaderboard.
        against: every robot against the baseline.
        baseline: its name.
        pictures: figures by title.
    """
    body = [_glance(rows, found)]
    for task in dict.fromkeys(c.task for c in found):
        body.append(_leaderboard(task, [c for c in found if c.task == task]))
        body.append(_measures(task, [row for row in rows if row["task"] == task]))
    if against:
        body.append(_duels(against, baseline))
    body += [_picture(title, figure) for title, figure in pictures.items()]
    broken = [row for row in rows if row["error"]]
    if broken:
        items = "".join(f"<li>{html.escape(_told(row))}</li>" for row in broken)
        body.append(f"<h2>Trials that broke down</h2><ul>{items}</ul>")
    body.append(_origin(rows))
    maps = ", ".join(sorted({row["map"] for row in rows}))
    head = html.escape(f"{len(rows)} trials on {maps}.")
    return PAGE.format(head=head, body="\n".join(body))


def _glance(rows: Sequence[Row], found: Sequence[Cell]) -> str:
    """A small table for each level of odometry."""
    parts = [
        f"<h3>{html.escape(told.title)}</h3>\n{table(told.head, told.lines)}"
        for told in overviews(rows, found)
    ]
    return f"<h2>At a glance</h2>\n{''.join(parts)}<p>{NOTE}</p>"


def _leaderboard(task: str, found: Sequence[Cell]) -> str:
    rate = "saw 95 % in time" if task == EXPLORE else "goals met"
    score = "coverage AUC" if task == EXPLORE else "soft SPL"
    head = ("robot", "odometry", "dynamics", "trials", "broke down", rate, score)
    values = [
        (
            c.agent, c.odometry, c.dynamics, str(c.trials), str(c.failed), _percent(c.rate),
            _interval(c.score),
        )
        for c in found
    ]  # fmt: skip
    return f"<h2>{html.escape(task)}</h2>\n{table(head, values)}<p>{INTERVALS}</p>"


def _measures(task: str, rows: Sequence[Row]) -> str:
    """All that is measured beside, as medians and quartiles; what nobody tells is left out."""
    groups = grouped(rows, ("agent", "odometry", "dynamics"))
    shown = {name: told for name, told in MEASURES.items() if any(row[name] for row in rows)}
    head = ("robot", "odometry", "dynamics", *(told[0] for told in shown.values()))
    values = [
        (*key, *(_quartiles(quartiles(some, name), *told[1:]) for name, told in shown.items()))
        for key, some in sorted(groups.items(), key=lambda item: (item[0][0], *rank(*item[0][1:])))
    ]
    title = html.escape(f"{task}: ways, beliefs and costs")
    return f"<h3>{title}</h3>\n<div>{table(head, values)}</div><p>{QUARTILES}</p>"


def _duels(against: Sequence[Duel], baseline: str) -> str:
    head = ("robot", "task", "odometry", "dynamics", "trials", "difference of the score", "beats")
    values = [
        (
            d.agent, d.task, d.odometry, d.dynamics, str(d.trials), _interval(d.difference, "+.2f"),
            _percent(d.improvement),
        )
        for d in against
    ]  # fmt: skip
    title = html.escape(f"Against {baseline}")
    return f"<h2>{title}</h2>\n{table(head, values)}<p>{DUELS}</p>"


def _origin(rows: Sequence[Row]) -> str:
    """Which code and which parameters the rows come from; more than one is said aloud."""
    head = ("robot", "commit", "parameters", "trials")
    groups = grouped(rows, ("agent", "commit", "params"))
    values = [(*(word or "-" for word in key), str(len(some))) for key, some in groups.items()]
    mixed = len(groups) > len({key[0] for key in groups})
    note = (
        "<p><strong>Rows of different code or parameters are mixed.</strong></p>" if mixed else ""
    )
    return f"<h2>Code and parameters</h2>\n{note}{table(head, sorted(values))}"


def _picture(title: str, figure: Figure) -> str:
    figure.savefig(buffer := io.BytesIO(), format="png", dpi=130)
    data = base64.b64encode(buffer.getvalue()).decode()
    alt = html.escape(title)
    return f'<h2>{alt}</h2>\n<img alt="{alt}" src="data:image/png;base64,{data}">'


def table(head: Sequence[str], values: Iterable[Sequence[str]]) -> str:
    """A table as HTML."""
    lines = ["".join(f"<th>{html.escape(name)}</th>" for name in head)]
    lines += ["".join(f"<td>{html.escape(value)}</td>" for value in row) for row in values]
    return "<table>\n" + "\n".join(f"<tr>{line}</tr>" for line in lines) + "\n</table>\n"


def _told(row: Row) -> str:
    key = ", ".join(row[name] for name in ("agent", "task", "map", "odometry", "dynamics", "seed"))
    return f"{key}: {row['error'].rpartition('|')[2].strip()}"


def _percent(value: Interval) -> str:
    return _interval((100.0 * value[0], 100.0 * value[1], 100.0 * value[2]), ".0f", " %")


def _interval(value: Interval, form: str = ".2f", unit: str = "") -> str:
    """A figure with its interval, where there is one."""
    middle, low, high = (_number(x, form) for x in value)
    known = np.isfinite(value[1])
    return f"{middle}{unit} ({low} to {high})" if known else f"{middle}{unit}"


def _quartiles(value: Interval, form: str, factor: float) -> str:
    middle, low, high = (_number(factor * x, form) for x in value)
    return middle if np.isnan(value[0]) else f"{middle} ({low}\u2013{high})"


def _number(value: float, form: str) -> str:
    return "-" if np.isnan(value) else "\u221e" if np.isinf(value) else format(value, form)
