"""Measure the speed of the laser against the naive way, and of the robot, in one run.

The naive laser asks pymunk for the nearest segment beam by beam and adds NumPy noise; ours
is ``Laser.scan``, called once a scan from the same poses. The vector environment is measured
against a single one with the naive laser (cogmap_gym/vector_speed.py). Rounds of the rivals
alternate, so that a slow spell of the machine meets both; medians are reported. The robot takes
steps of experiment 1 with its own map and with a larger one: agents/step_cost.py.
"""

from __future__ import annotations

import json
import math
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import gymnasium as gym
import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from agents.step_cost import step_costs
from cogmap_gym import FloorPlan
from cogmap_gym.geometry import Pose, Segments, point_segment_distances
from cogmap_gym.observation import LaserSpec
from cogmap_gym.raycast import RayCaster
from cogmap_gym.sensors import Laser
from cogmap_gym.vector_speed import NaiveLaser, seconds_to_start, vector_costs

Scan = Callable[[Pose], object]
CONSOLE = Console()
SIZES = (150, 1_000, 10_000)
"""Segments of the synthetic offices."""
CLEARANCE = 0.3
"""Distance of a pose from all walls [m]: where a robot can stand."""
ROOM = 5.0
"""Side of a room of the synthetic offices [m]."""


def synthetic_office(segments: int, rng: np.random.Generator) -> Segments:
    """Square rooms with doorways of 1 m and a desk each; about as many segments as asked."""
    side = max(round(math.sqrt(segments / 7.0)), 1)
    rows: list[list[tuple[float, float]]] = []
    for i, j in np.ndindex(side, side):
        x, y = ROOM * i, ROOM * j
        dx, dy = x + rng.uniform(0.8, 3.0), y + rng.uniform(0.8, 3.0)
        rows += [[(x, y), (x + 2.0, y)], [(x + 3.0, y), (x + ROOM, y)]]
        rows += [[(x, y), (x, y + 2.0)], [(x, y + 3.0), (x, y + ROOM)]]
        a, b, c = (dx, dy), (dx + 1.2, dy), (dx + 1.2, dy + 0.6)
        rows += [[a, b], [b, c], [c, a]]
    end = ROOM * side
    rows += [[(end, 0.0), (end, end)], [(0.0, end), (end, end)]]
    return np.array(rows)


def standing_poses(walls: Segments, count: int, rng: np.random.Generator) -> list[Pose]:
    """Random poses within the bounds of ``walls``, clear of all of them."""
    low, high = walls.min(axis=(0, 1)), walls.max(axis=(0, 1))
    poses: list[Pose] = []
    while len(poses) < count:
        place = rng.uniform(low, high)
        if point_segment_distances(place[None], walls).min() > CLEARANCE:
            poses.append(Pose(place[0], place[1], rng.uniform(-math.pi, math.pi)))
    return poses


def seconds_a_scan(scan: Scan, poses: list[Pose]) -> float:
    """Mean time of one scan over ``poses``."""
    start = time.perf_counter()
    for pose in poses:
        scan(pose)
    return (time.perf_counter() - start) / len(poses)


def compare(name: str, walls: Segments, rounds: int, seed: int) -> dict[str, object]:
    """Median microseconds a scan of both lasers, and the median of the rounds' ratios."""
    rng, spec = np.random.default_rng(seed), LaserSpec()
    poses = standing_poses(walls, 400, rng)
    slow, fast = NaiveLaser(walls, spec), Laser(RayCaster(walls), spec)
    naive: Scan = lambda pose: slow.scan(pose, rng)  # noqa: E731
    ours: Scan = lambda pose: fast.scan(pose, rng)  # noqa: E731
    ours(poses[0])
    times = [
        (seconds_a_scan(naive, poses[:20]), seconds_a_scan(ours, poses))
        for _ in track(range(rounds), name, transient=True, disable=not CONSOLE.is_terminal)
    ]
    return {
        "world": name,
        "segments": len(walls),
        "naive_us": 1e6 * statistics.median(a for a, _ in times),
        "ours_us": 1e6 * statistics.median(b for _, b in times),
        "ratio": statistics.median(a / b for a, b in times),
    }


def show(title: str, rows: list[dict[str, object]]) -> None:
    """Print a table."""
    table = Table(*(heading.replace("_", ", ") for heading in rows[0]), title=title)
    for row in rows:
        table.add_row(*(f"{v:.2f}" if isinstance(v, float) else str(v or "") for v in row.values()))
    CONSOLE.print(table)


def main(
    plan: Annotated[str, typer.Option("--map", help="plan of the first row")] = "thesis_office",
    rounds: Annotated[int, typer.Option(min=1, help="alternations of the rivals")] = 15,
    seed: Annotated[int, typer.Option(help="of offices, poses, noise and walks")] = 0,
    task: Annotated[str, typer.Option(help="of the many robots")] = "explore",
    control: Annotated[str, typer.Option(help="of the many robots")] = "velocity",
    offices: Annotated[int, typer.Option(help="make an environment of so many offices, too")] = 0,
    out: Annotated[Path | None, typer.Option(help="JSON file for the figures")] = None,
) -> None:
    """Print the cost of a scan beside the naive loop's, and of a step of the robot."""
    rng = np.random.default_rng(seed)
    worlds = {plan: FloorPlan.load(plan).walls_and_furniture()}
    worlds |= {f"synthetic office {size}": synthetic_office(size, rng) for size in SIZES}
    lasers = [compare(name, walls, rounds, seed) for name, walls in worlds.items()]
    show(f"a noisy scan of {LaserSpec().beams} beams, a Python call each", lasers)
    steps = step_costs(gym.make("CogMap/Thesis-v0", experiment=1), rounds, seed)
    show("a step of the robot: CogMapAgent.act in experiment 1", steps)
    turns = track(range(rounds), "robots", transient=True, disable=not CONSOLE.is_terminal)
    robots = vector_costs(plan, task, control, turns, seed)
    show(f"a step of a robot among many: {task}, control {control}", robots)
    start = seconds_to_start(range(1000, 1000 + offices)) if offices else None
    if start is not None:
        CONSOLE.print(f"{offices} generated offices: started in {start:.1f} s")
    CONSOLE.print("asked: 64 robots 250x naive, 1.4x more on two threads; 1,024 offices < 60 s")
    CONSOLE.print("asked: first scan 100x; a step's median < 10 ms, with 1,000 surfaces <= 1.5x")
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        figures = {"seed": seed, "laser": lasers, "step": steps, "robots": robots}
        out.write_text(json.dumps({**figures, "start_s": start}, indent=2))
        CONSOLE.print(out)


if __name__ == "__main__":
    typer.run(main)
