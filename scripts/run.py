"""Run one episode of an agent and show how it went.

Usage: python scripts/run.py --env CogMap/GoHome-v0 --map thesis_office --agent cogmap
           [--control move] [--odometry medium] [--seed 0] [--out DIR] [--video FILE.gif]

Writes DIR/final.png, the truth beside what the agent believes, and with --video a film.
With --show it opens a window to watch in.
"""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import imageio.v2 as imageio
import numpy as np
import typer
from rich.progress import Progress

import cogmap_gym
from agents.registry import AGENTS, make_agent, wrap
from agents.rollout import run_episode
from cogmap_gym.experiment_figures import overview_figure
from cogmap_gym.saving import save_png
from cogmap_gym.wrappers import MoveControl

FRAME_MS = 100
"""How long a film shows each move [ms]."""


class Film:
    """Frames of an episode, written as they come; whole only once closed.

    Args:
        path: ends in .gif, or in another ending that imageio has a writer for.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.part = path, path.with_name(f".part.{path.name}")
        speed = {"duration": FRAME_MS} if path.suffix == ".gif" else {"fps": 1000 / FRAME_MS}
        path.parent.mkdir(parents=True, exist_ok=True)
        self.writer: Any = imageio.get_writer(self.part, mode="I", **speed)

    def close(self) -> Path:
        """Finish the film and give it its name."""
        self.writer.close()
        return self.part.replace(self.path)


class Watch:
    """Follows an episode: keeps the paths, shows the progress, films."""

    def __init__(self, env: gym.Env[Any, Any], film: Film | None) -> None:
        self.env, self.film, self.progress, self.interrupted = env, film, Progress(), False
        self.bar = self.progress.add_task("setting up", total=env.unwrapped.max_moves)
        self.true_path: list[Any] = []
        self.path: list[Any] = []

    def on_step(self, step: int, seen: Any, _: Any, info: dict[str, Any], agent: Any) -> None:
        """Called by ``run_episode`` after each decision of the agent."""
        if self.interrupted:
            raise KeyboardInterrupt
        sketch = agent.sketch()
        self.true_path.append(info["pose"][:2])
        if sketch is not None:
            self.path.append(sketch["pose"][:2])
        task = f"going to mark {seen['goal']}" if seen["goal"] else "exploring"
        what = f"phase {info['phase'] + 1}, {task}, step {step}"
        self.progress.update(self.bar, completed=step, description=what)
        self.env.unwrapped.set_sketch(sketch)
        if self.film is not None:
            self.film.writer.append_data(self.env.render())

    def interrupt(self, *_: Any) -> None:
        """Ctrl-C ends the run after this step; a second one ends all at once."""
        if self.interrupted:
            raise KeyboardInterrupt
        self.interrupted = True


def show_outcome(env: Any, *, interrupted: bool) -> None:
    """Print how each phase came out, and the whole."""
    for number, result in enumerate(env.task.results, start=1):
        print(
            f"phase {number}, {result.task}: {'done' if result.success else 'failed'} in "
            f"{result.moves} moves, {result.path_length:.1f} m"
            + (f" (shortest {result.oracle_length:.1f} m)" if result.oracle_length >= 0 else "")
        )
    print("interrupted" if interrupted else f"success: {env.task.succeeded}")


def main(
    env: Annotated[str, typer.Option(help="id of the environment")] = "CogMap/GoHome-v0",
    map_: Annotated[str, typer.Option("--map", help="plan, by name or path")] = "thesis_office",
    agent: Annotated[
        str, typer.Option(help=f"module:Class, or one of {', '.join(AGENTS)}")
    ] = "cogmap",
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high or severe")] = "medium",
    control: Annotated[
        str, typer.Option(help="move, or velocity: moves by steps of 0.1 s")
    ] = "move",
    seed: Annotated[int, typer.Option(min=0, help="of the episode")] = 0,
    out: Annotated[Path, typer.Option(file_okay=False, help="folder to write to")] = Path(
        "out/run"
    ),
    show: Annotated[bool, typer.Option("--show", help="open a window to watch in")] = False,
    video: Annotated[Path | None, typer.Option(dir_okay=False, help="film to write")] = None,
) -> None:
    """Run one episode of an agent; Ctrl-C leaves what was done so far."""
    if env not in cogmap_gym.ENV_IDS:
        raise typer.BadParameter(f"expected an env of {list(cogmap_gym.ENV_IDS)}, got {env!r}")
    try:
        robot = make_agent(agent, seed)
        mode = "rgb_array" if video is not None else "human" if show else None
        made = gym.make(env, map=map_, control=control, odometry=odometry, render_mode=mode)
        made = made if control == "move" else MoveControl(made)
        watch = Watch(made, None if video is None else Film(video))
    except (ValueError, OSError, ModuleNotFoundError) as error:
        raise typer.BadParameter(str(error)) from error
    world = made.unwrapped
    signal.signal(signal.SIGINT, watch.interrupt)
    with watch.progress:
        try:
            run_episode(wrap(agent, made), robot, seed, watch.on_step)
        except KeyboardInterrupt:
            watch.progress.print("interrupted: what was done so far is kept")
    out.mkdir(parents=True, exist_ok=True)
    true_path, path = (np.reshape(way, (-1, 2)) for way in (watch.true_path, watch.path))
    show_outcome(world, interrupted=watch.interrupted)
    title = f"{agent} in {env}, {map_}, odometry {odometry}, seed {seed}"
    picture = overview_figure(
        world.plan, true_path, robot.sketch(), path, world.task.marks[1], title,
        world.world.shut_doors,
    )  # fmt: skip
    print(save_png(picture, out / "final.png"))
    made.close()
    if watch.film is not None:
        print(watch.film.close())
    if watch.interrupted:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
