"""Draw a robot at work in several environments: the truth beside what the robot believes.

For example: ``gallery.py --view thesis_office:off --view office:1001:busy --out out/gallery.png``.
Each row is one view, ``MAP:DYNAMICS``, after the same number of moves.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import gymnasium as gym
import imageio.v3 as imageio
import numpy as np
import typer
from rich.progress import track

from agents.cogmap import CogMapAgent
from cogmap_gym import ENV_IDS
from cogmap_gym.render import Frame, draw, draw_legend
from cogmap_gym.saving import write_whole

SIZE = (700, 1400)
"""Height and width of a row [pixels]."""
LEGEND_SIZE = (70, SIZE[1])
"""Height and width of the legend below [pixels]."""
VIEWS = ["thesis_office:off", "office:1001:busy"]


def view(env_id: str, place: str, moves: int, seed: int) -> Frame:
    """A frame of an episode after some moves of the thesis's robot."""
    map_, _, dynamics = place.rpartition(":")
    env, agent = gym.make(env_id, map=map_, dynamics=dynamics), CogMapAgent()
    observation, _ = env.reset(seed=seed)
    agent.reset(env.unwrapped.robot, env.unwrapped.laser)
    for _ in track(range(moves), description=place):
        observation, _, terminated, truncated, _ = env.step(agent.act(observation))
        if terminated or truncated:
            break
    env.unwrapped.set_sketch(agent.sketch())
    return draw(env.unwrapped.scene(), SIZE)


def main(
    out: Annotated[Path, typer.Option(dir_okay=False)] = Path("out/gallery.png"),
    views: Annotated[list[str], typer.Option("--view", help="MAP:DYNAMICS, a row each")] = VIEWS,
    env: Annotated[str, typer.Option(help=f"one of {', '.join(ENV_IDS)}")] = "CogMap/Explore-v0",
    moves: Annotated[int, typer.Option(min=0)] = 60,
    seed: Annotated[int, typer.Option(min=0, help="of the episodes")] = 1000,
) -> None:
    """Draw a robot at work, a row an environment."""
    try:
        rows = [view(env, place, moves, seed) for place in views]
    except (ValueError, gym.error.Error) as error:
        raise typer.BadParameter(str(error)) from error
    picture = np.concatenate((*rows, draw_legend(LEGEND_SIZE)))
    out.parent.mkdir(parents=True, exist_ok=True)
    print(write_whole(out, imageio.imwrite("<bytes>", picture, extension=".png")))


if __name__ == "__main__":
    typer.run(main)
