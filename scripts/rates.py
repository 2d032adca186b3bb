"""How often the robot does what issue 2 asks: runs many episodes, and makes the tables.

Usage: python scripts/rates.py --experiment 1 --odometry medium --seeds 0:50 --out DIR

Writes DIR/runs.jsonl, a row a run, and DIR/rates.md. Runs that stand there are not done again.
Choose parameters on seeds >= 1000; seeds 0:50 are for the report.
"""

from __future__ import annotations

import json
import multiprocessing
import signal
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import numpy as np
import typer
from numpy.typing import NDArray
from rich.progress import track

import cogmap_gym  # noqa: F401 - registers the environments
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.params import Params
from agents.cogmap.places import links
from agents.rollout import run_episode
from cogmap_gym.metrics import score
from cogmap_gym.observation import Observation
from cogmap_gym.run_record import Record, Step
from cogmap_gym.score_table import rates_table
from cogmap_gym.thesis_tasks import RING

Job = tuple[int, str, int, bool]
"""Experiment, odometry, seed, literal."""
KEYS = ("experiment", "odometry", "seed", "literal")


class Recorder:
    """Keeps what was true and what was believed at each step."""

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        """Of an episode in this environment."""
        self.world = env.unwrapped.world  # type: ignore[attr-defined]
        self.steps: list[Step] = []

    def __call__(
        self,
        _step: int,
        observation: Observation,
        _action: NDArray[np.float32],
        info: dict[str, Any],
        agent: CogMapAgent,
    ) -> None:
        """Add a step; the values of the robot's memory are frozen, so none is copied."""
        memory = agent.memory
        mapping, stay, pose = memory.mapping, memory.stay, memory.pose
        self.steps.append(
            Step(
                phase=info["phase"],
                pose=info["pose"],
                shut=self.world.shut_doors,
                odometry=np.array(observation["odometry"], dtype=np.float64),
                mapped=memory.path[-1],
                believed=np.array((pose.x, pose.y, pose.theta)),
                seen=mapping.view.surfaces,
                names=mapping.ids,
                surfaces=mapping.mfis.surfaces,
                entered=mapping.mfis.entered,
                tags=mapping.mfis.asr,
                place=stay.place,
                entry=stay.entry,
                began=stay.began,
                boundaries={asr.id: asr.boundary for asr in memory.network.asrs},
                links=tuple(links(memory.book)),
            )
        )


def run(job: Job) -> dict[str, Any]:
    """One episode, scored; an episode that breaks down is a row too."""
    experiment, odometry, seed, literal = job
    env = gym.make("CogMap/Thesis-v0", experiment=experiment, odometry=odometry)
    agent = CogMapAgent(Params.literal() if literal else Params())
    recorder = Recorder(env)
    row: dict[str, Any] = dict(zip(KEYS, job, strict=True))
    try:
        episode = run_episode(env, agent, seed, recorder)  # type: ignore[arg-type]
    except Exception as error:  # noqa: BLE001 - a rate counts every run
        why = dict.fromkeys(("a_why", "b_why", "c_why", "d_why"), f"raised {error!r}")
        return row | dict.fromkeys("abcd", False) | why | {"raised": repr(error)}
    record = Record(
        plan=env.unwrapped.plan,  # type: ignore[attr-defined]
        rooms=RING,
        steps=recorder.steps,
        edits=agent.edit_log,
        tasks=[phase["task"] for phase in episode.phases],
        successes=[phase["success"] for phase in episode.phases],
        final_distance=float(episode.info["final_distance"][1]),
    )
    return row | score(record)


def read_rows(path: Path) -> list[dict[str, Any]]:
    """The rows written so far; a last line that was cut short does not count."""
    text = path.read_text() if path.exists() else ""
    return [json.loads(line) for line in text.splitlines() if line.endswith("}")]


def run_all(jobs: list[Job], workers: int, path: Path) -> bool:
    """Run the jobs and append a row of each as it comes in; False if Ctrl-C ended it."""
    ignore = (signal.SIGINT, signal.SIG_IGN)  # this process takes Ctrl-C and stops the workers
    with multiprocessing.get_context("spawn").Pool(workers, signal.signal, ignore) as pool:
        try:
            for row in track(pool.imap_unordered(run, jobs), "episodes", total=len(jobs)):
                with path.open("a") as file:
                    file.write(f"\n{json.dumps(row)}")
        except KeyboardInterrupt:
            return False
    return True


def main(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for rows and table")],
    experiment: Annotated[int, typer.Option(min=1, max=2)] = 1,
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high, severe")] = "medium",
    seeds: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "1000:1010",
    literal: Annotated[bool, typer.Option(help="the text of the thesis as written")] = False,
    workers: Annotated[int, typer.Option(min=1)] = 2,
) -> None:
    """Run the experiment on these seeds, and write the table of all rows in the folder."""
    if literal and not hasattr(Params, "literal"):
        raise typer.BadParameter("this robot has no Params.literal()")
    first, _, last = seeds.partition(":")
    if not (first.isdigit() and last.isdigit()):
        raise typer.BadParameter(f"seeds: expected FIRST:LAST, got {seeds!r}")
    out.mkdir(parents=True, exist_ok=True)
    path = out / "runs.jsonl"
    done = {tuple(row[key] for key in KEYS) for row in read_rows(path)}
    wanted = [(experiment, odometry, seed, literal) for seed in range(int(first), int(last))]
    complete = run_all([job for job in wanted if job not in done], workers, path)
    table = rates_table(read_rows(path))
    (out / "rates.md").write_text(table)
    print(f"{table}\n{path}\n{out / 'rates.md'}")
    if not complete:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
