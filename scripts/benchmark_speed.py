"""Measure what a scan and a step cost, beside the naive way and beside others', in one run.

The naive laser asks pymunk for the nearest segment beam by beam and adds NumPy noise; a naive
environment is ours with that laser. Rounds of the rivals alternate, so that a slow spell of the
machine meets all; medians are reported. The robot takes steps of experiment 1 with its own map
and with a larger one. With ``--peers``, IR-SIM and navground run on the same plan (extra
``peers``).
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import gymnasium as gym
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from agents.step_cost import step_costs
from cogmap_gym import FloorPlan
from cogmap_gym.laser_speed import batch_costs, laser_costs, memory_peak, toggle_seconds
from cogmap_gym.observation import LaserSpec
from cogmap_gym.peer_speed import missing_peers, peer_costs
from cogmap_gym.saving import write_whole
from cogmap_gym.vector_speed import seconds_to_start, vector_costs

CONSOLE = Console()
BATCH = 64
"""Robots that scan in one call."""


def show(title: str, rows: list[dict[str, object]]) -> None:
    """Print a table."""
    table = Table(*(heading.replace("_", " ") for heading in rows[0]), title=title)
    for row in rows:
        told = (f"{v:.2f}" if isinstance(v, float) else str(v or "") for v in row.values())
        table.add_row(*told)
    CONSOLE.print(table)


def main(
    plan: Annotated[str, typer.Option("--map", help="plan of the first row")] = "thesis_office",
    rounds: Annotated[int, typer.Option(min=1, help="alternations of the rivals")] = 15,
    seed: Annotated[int, typer.Option(help="of offices, poses, noise and walks")] = 0,
    task: Annotated[str, typer.Option(help="of the robots")] = "explore",
    control: Annotated[str, typer.Option(help="of the robots")] = "velocity",
    largest: Annotated[int, typer.Option(min=0, help="segments of a campus, e.g. 1000000")] = 0,
    offices: Annotated[int, typer.Option(help="make an environment of so many offices, too")] = 0,
    peers: Annotated[bool, typer.Option(help="run IR-SIM and navground, too")] = False,
    out: Annotated[Path | None, typer.Option(help="JSON file for the figures")] = None,
) -> None:
    """Print the cost of a scan and of a step, beside the naive ones and others'."""

    def turns(name: str) -> Iterable[int]:
        return track(range(rounds), name, transient=True, disable=not CONSOLE.is_terminal)

    building = FloorPlan.load(plan)
    lasers = laser_costs(building, largest, turns("lasers"), seed)
    lasers.append(batch_costs(building, BATCH, turns("batch"), seed))
    show(f"a noisy scan of {LaserSpec().beams} beams, a Python call each but in the batch", lasers)
    told = {"toggle_us": 1e6 * toggle_seconds(building, turns("doors")), "peak_gib": memory_peak()}
    CONSOLE.print(f"a door toggled: {told['toggle_us']:.2f} us; memory: {told['peak_gib']:.2f} GiB")
    robots = vector_costs(plan, task, control, turns("robots"), seed)
    show(f"a step of a robot: {task}, control {control}", robots)
    others = peer_costs(building, turns("peers"), seed) if peers else []
    if peers:
        show("a step of one robot, beside others' environments", others)
        CONSOLE.print(f"not installed: {', '.join(missing_peers()) or 'none'}")
    steps = step_costs(gym.make("CogMap/Thesis-v0", experiment=1), rounds, seed)
    show("a step of the robot: CogMapAgent.act in experiment 1", steps)
    start = seconds_to_start(range(1000, 1000 + offices)) if offices else None
    if start is not None:
        CONSOLE.print(f"{offices} generated offices: started in {start:.1f} s")
    if out is not None:
        figures = {"seed": seed, "laser": lasers, **told, "robots": robots, "peers": others}
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(
            out, json.dumps({**figures, "step": steps, "start_s": start}, indent=2).encode()
        )
        CONSOLE.print(out)


if __name__ == "__main__":
    typer.run(main)
