"""The page of a sweep: who did how well in which task, with intervals, and its figures.

A row is what ``agents/sweep.py`` writes, as text. What the rows do not hold is left out.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from cogmap_gym.colors import BLACK, BLUE, GREEN, ORANGE, PURPLE, ROOM_NAME, SKY, VERMILLION
from cogmap_gym.metrics import wilson
from cogmap_gym.statistics import Strata, bootstrap, interquartile_mean_of

Row = Mapping[str, str]
LEVELS = ("perfect", "low", "medium", "high", "severe")
"""Odometry levels, the best first."""
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, BLACK, SKY, ROOM_NAME)
"""Of robots, in the order of their names; colour-blind safe."""
STYLES = ("-", "--", ":")
"""Of lines, where there are more robots than colours."""
EXPLORE = "explore"
"""The task without a goal."""
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>cogmap_gym: sweep</title><style>
body {{ font: 15px/1.5 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; margin: 1em 0; }}
th, td {{ padding: 0.25em 0.8em; text-align: right; border-bottom: 1px solid #ddd; }}
th:first-child, td:first-child {{ text-align: left; }}
img {{ max-width: 100%; }}
</style></head><body>
<h1>Sweep</h1>
<p>{head}</p>
{body}
</body></html>
"""


@dataclass(frozen=True, slots=True)
class Cell:
    """One robot in one task at one odometry level."""

    agent: str
    task: str
    odometry: str
    trials: int
    failed: int
    """Trials that broke down."""
    rate: tuple[float, float, float]
    """Share of the goals met (explore: of the trials that saw 95 %), and its Wilson interval."""
    score: tuple[float, float, float]
    """Interquartile mean of the score (explore: ``area``; else ``soft_spl``), and its interval."""
    cpu_ms: float
    """Median over the trials of the median CPU time of a step."""
    map_bytes: float
    """Median size of the map at the end; NaN where the robot does not tell."""


def cells(rows: Sequence[Row], rng: np.random.Generator) -> list[Cell]:
    """The leaderboard, by task and level, the best rate first."""
    keys = dict.fromkeys((row["task"], row["odometry"], row["agent"]) for row in rows)
    found = [
        _cell(key, [r for r in rows if (r["task"], r["odometry"], r["agent"]) == key], rng)
        for key in keys
    ]
    return sorted(found, key=lambda c: (c.task, LEVELS.index(c.odometry), -c.rate[0], c.agent))


def _cell(key: tuple[str, str, str], rows: Sequence[Row], rng: np.random.Generator) -> Cell:
    task, odometry, agent = key
    sound = [row for row in rows if not row["error"]]
    if task == EXPLORE:
        met, asked = sum(row["success"] == "1" for row in sound), len(rows)
    else:
        met = sum(int(row["goals_met"]) for row in sound)
        asked = sum(int(row["goals"]) for row in sound) + len(rows) - len(sound)
    strata = scores_by_map(sound, "area" if task == EXPLORE else "soft_spl")
    middle = interquartile_mean_of(strata) if strata else float("nan")
    return Cell(
        agent,
        task,
        odometry,
        len(rows),
        len(rows) - len(sound),
        (met / asked if asked else float("nan"), *wilson(met, asked)),
        (middle, *bootstrap(strata, interquartile_mean_of, rng)),
        _median(sound, "cpu_ms"),
        _median(sound, "map_bytes"),
    )


def scores_by_map(rows: Sequence[Row], column: str) -> Strata:
    """The scores of a column, an array a map, in the order of the seeds."""
    maps = dict.fromkeys(row["map"] for row in rows)
    held = ([row for row in rows if row["map"] == name and row[column]] for name in maps)
    return [np.array([float(r[column]) for r in sorted(some, key=_seed)]) for some in held if some]


def _seed(row: Row) -> int:
    return int(row["seed"])


def _median(rows: Sequence[Row], column: str) -> float:
    held = [float(row[column]) for row in rows if row[column]]
    return float(np.median(held)) if held else float("nan")


def curves_figure(rows: Sequence[Row]) -> Figure | None:
    """The share seen against the share of the budget, a line a robot; None without a curve."""
    told = [row for row in rows if row["task"] == EXPLORE and row["curve"]]
    if not told:
        return None
    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    ax = figure.subplots()
    for k, agent in enumerate(sorted({row["agent"] for row in told})):
        every = np.array([_curve(row) for row in told if row["agent"] == agent])
        middle = np.sort(every, axis=0)[len(every) // 4 : -(len(every) // 4) or None].mean(axis=0)
        at = np.linspace(0.0, 100.0, len(middle))
        ax.plot(at, 100.0 * middle, STYLES[k // len(COLORS)], color=_color(k), label=agent)
    ax.set(
        xlabel="moves [% of the budget]", ylabel="free area seen [%]", ylim=(0, 102), xlim=(0, 100)
    )
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small", loc="lower right")
    return figure


def _curve(row: Row) -> list[float]:
    return [float(share) for share in row["curve"].split(";")]


def _color(k: int) -> str:
    return COLORS[k % len(COLORS)]


def drift_figure(found: Sequence[Cell]) -> Figure | None:
    """Goals met against odometry, a panel a task; None with one level alone."""
    levels = [level for level in LEVELS if any(c.odometry == level for c in found)]
    tasks = list(dict.fromkeys(c.task for c in found))
    if len(levels) < 2:
        return None
    figure = Figure(figsize=(3.4 * len(tasks) + 1.6, 3.6), layout="constrained")
    axes = figure.subplots(1, len(tasks), sharey=True, squeeze=False)
    agents = sorted({c.agent for c in found})
    for ax, task in zip(axes[0], tasks, strict=True):
        for k, agent in enumerate(agents):
            mine = {c.odometry: c.rate for c in found if (c.task, c.agent) == (task, agent)}
            at = [i for i, level in enumerate(levels) if level in mine]
            rates = 100.0 * np.array([mine[levels[i]] for i in at]).reshape(-1, 3)
            spread = np.abs(rates[:, 1:] - rates[:, :1]).T
            aside = 0.05 * (k - 0.5 * (len(agents) - 1))
            style = STYLES[k // len(COLORS)]
            ax.errorbar(np.array(at) + aside, rates[:, 0], spread, ls=style, marker="o", ms=3,
                        lw=1.2, color=_color(k), label=agent)  # fmt: skip
        ax.set(title=task, xlabel="odometry", ylim=(-2, 102))
        ax.set_xticks(range(len(levels)), levels)
        ax.grid(alpha=0.3)
    axes[0, 0].set_ylabel("met [%]")
    axes[0, -1].legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def report_page(rows: Sequence[Row], found: Sequence[Cell], pictures: Mapping[str, Figure]) -> str:
    """The whole page as HTML, pictures within."""
    body = [_table(task, [c for c in found if c.task == task]) for task in _tasks(found)]
    for title, figure in pictures.items():
        figure.savefig(buffer := io.BytesIO(), format="png", dpi=130)
        data = base64.b64encode(buffer.getvalue()).decode()
        alt = html.escape(title)
        body.append(f'<h2>{alt}</h2>\n<img alt="{alt}" src="data:image/png;base64,{data}">')
    broken = [row for row in rows if row["error"]]
    if broken:
        items = "".join(f"<li>{html.escape(_told(row))}</li>" for row in broken)
        body.append(f"<h2>Trials that broke down</h2><ul>{items}</ul>")
    maps = sorted({row["map"] for row in rows})
    commits = ", ".join(sorted({row["commit"] for row in rows if row["commit"]}))
    head = html.escape(f"{len(rows)} trials on {', '.join(maps)}; code: {commits or 'unknown'}.")
    return PAGE.format(head=head, body="\n".join(body))


def _tasks(found: Sequence[Cell]) -> list[str]:
    return list(dict.fromkeys(c.task for c in found))


def _told(row: Row) -> str:
    key = ", ".join(row[name] for name in ("agent", "task", "map", "odometry", "seed"))
    return f"{key}: {row['error'].rpartition('|')[2].strip()}"


def _table(task: str, found: Sequence[Cell]) -> str:
    if task == EXPLORE:
        rate, score = "saw 95 % in time", "mean share seen over the budget"
    else:
        rate, score = "goals met", "soft SPL"
    head = ("robot", "odometry", "trials", rate, score, "CPU a step [ms]", "map [kB]")
    lines = ["".join(f"<th>{html.escape(name)}</th>" for name in head)]
    for c in found:
        values = (
            c.agent, c.odometry, str(c.trials), _percent(c.rate), _interval(c.score),
            _number(c.cpu_ms, ".1f"), _number(c.map_bytes / 1e3, ".0f"),
        )  # fmt: skip
        lines.append("".join(f"<td>{html.escape(value)}</td>" for value in values))
    rows = "\n".join(f"<tr>{line}</tr>" for line in lines)
    note = "In brackets: Wilson intervals of rates, stratified bootstrap of interquartile means."
    return f"<h2>{html.escape(task)}</h2>\n<table>\n{rows}\n</table>\n<p>{note}</p>"


def _percent(value: tuple[float, float, float]) -> str:
    rate, low, high = (100.0 * x for x in value)
    return f"{rate:.0f} % ({low:.0f}-{high:.0f})"


def _interval(value: tuple[float, float, float]) -> str:
    return f"{value[0]:.2f} ({value[1]:.2f}-{value[2]:.2f})" if np.isfinite(value[0]) else "-"


def _number(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else "-"
