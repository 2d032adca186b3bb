"""Whether the robot's memory and its step stop growing once it knows an office.

Usage: python scripts/endurance.py --map office:1003 --moves 20000 --out DIR

Lets the robot explore for so many moves, long after it has seen all, and writes
DIR/endurance.jsonl, a row from time to time: how many surfaces, places and exits it remembers,
the bytes of its saved memory, and the median CPU time of a step. Ctrl-C leaves the rows so far.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import numpy as np
import typer
from rich.progress import track

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent


def figures(agent: CogMapAgent, out: Path, seconds: list[float]) -> dict[str, Any]:
    """What the robot remembers now, and what its last steps cost."""
    memory = agent.memory
    kept = out / "memory.npz"
    agent.save(kept)
    return {
        "surfaces": len(memory.mapping.mfis),
        "edits": len(agent.edits),
        "places": len(memory.network.asrs),
        "exits": len(memory.book),
        "bytes": kept.stat().st_size,
        "median_ms": round(1e3 * float(np.median(seconds)), 3),
    }


def live(env: Any, agent: CogMapAgent, moves: int, every: int, seed: int, out: Path) -> None:
    """Explore for so many moves, and append a row from time to time."""
    observation, _ = env.reset(seed=seed)
    agent.reset(env.robot, env.laser)
    seconds: list[float] = []
    for move in track(range(1, moves + 1), "moves"):
        begun = time.process_time()
        action = agent.act(observation)
        seconds.append(time.process_time() - begun)
        # The task is over once all was seen; the robot is not told.
        observation, _, _, _, info = env.step(action)
        if move % every == 0:
            row = {"moves": move, "coverage": info["coverage"], **figures(agent, out, seconds)}
            with (out / "endurance.jsonl").open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(json.dumps(row))
            seconds = []


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for the rows")],
    map: Annotated[str, typer.Option(help="a plan, as in gym.make")] = "office:1003",  # noqa: A002
    moves: Annotated[int, typer.Option(min=1)] = 20_000,
    every: Annotated[int, typer.Option(min=1, help="moves from row to row")] = 1_000,
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    seed: Annotated[int, typer.Option(min=0)] = 0,
) -> None:
    """Let the robot live long in one office, and tell what it costs."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "endurance.jsonl").unlink(missing_ok=True)
    made = gym.make("CogMap/Explore-v0", map=map, odometry=odometry, max_moves=moves + 1)
    live(made.unwrapped, CogMapAgent(), moves, every, seed, out)


if __name__ == "__main__":
    typer.run(main)
