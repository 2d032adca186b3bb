"""Drive the robot yourself, in any task, and see the score at the end.

Usage: python scripts/play.py --env CogMap/GoTo-v0 [--map thesis_office] [--experiment 1]
           [--control velocity] [--odometry medium] [--seed 0] [--keys wwaa] [--picture FILE.png]

The world moves only while a key is held, so take your time. --keys presses keys for you, one a
step (w a s d, . for "I am there"), then ends; --picture saves the last picture of the window.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import numpy as np
import typer

import cogmap_gym
from cogmap_gym.screen import Window

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame

HELP = (
    "W / Up: forward    S / Down: back    A, D / Left, Right: turn    Space: I am there    "
    "R: a new episode    Q: quit"
)
KEYS = {
    "w": (pygame.K_w, pygame.K_UP), "s": (pygame.K_s, pygame.K_DOWN),
    "a": (pygame.K_a, pygame.K_LEFT), "d": (pygame.K_d, pygame.K_RIGHT),
}  # fmt: skip
MOVE_M, MOVE_RAD = 0.5, math.radians(15.0)
"""A drive and a turn by one key press in control "move" [m, rad]."""


def action_of(robot: Any, pressed: set[str]) -> np.ndarray | None:
    """The action that the keys mean; None for none."""
    if "." in pressed:
        return robot.declare()
    ahead, left = (int(x in pressed) - int(y in pressed) for x, y in ("ws", "ad"))
    if robot.control == "velocity":
        action = robot.velocity(ahead * robot.max_speed, left * robot.max_turn_rate / 2.0)
    else:
        action = robot.move(left * MOVE_RAD, max(ahead, 0) * MOVE_M)
    return action if ahead or left else None


class Game:
    """One person, one environment, one window."""

    def __init__(self, env: Any, seed: int) -> None:
        self.env, self.seed, self.window = env, seed, Window("cogmap_gym: play")
        self.begin()

    def begin(self) -> None:
        """Begin an episode."""
        self.observation, self.info = self.env.reset(seed=self.seed)
        self.steps, self.reward, self.over, self.told = 0, 0.0, False, "You stand on mark 1: home."

    def step(self, action: np.ndarray) -> None:
        """Make a step, and note what there is to tell."""
        self.observation, reward, terminated, truncated, self.info = self.env.step(action)
        self.steps, self.reward = self.steps + 1, self.reward + float(reward)
        self.over = terminated or truncated
        if mark := int(self.observation["mark"]):
            self.told = f"You stood on mark {mark} at step {self.steps}: remember that spot."

    def task(self) -> str:
        """What the robot shall do, or how it went."""
        if not self.over:
            goal = int(self.observation["goal"])
            what = f"Go to mark {goal} and press Space there." if goal else "Explore."
            return f"{what}    {self.told}{'    Contact.' * int(self.observation['bump'])}"
        found = [f"{k}: {'done' if ok else 'failed'}" for k, ok in self.marks().items()]
        whole = "Success" if self.info["is_success"] else "Not a success"
        return f"{whole}. By mark, 0 the exploration: {', '.join(found)}.    R: a new episode"

    def marks(self) -> dict[int, bool]:
        """How each goal that is over came out."""
        return {k: ok > 0.0 for k, ok in enumerate(self.info["success"]) if ok >= 0.0}

    def score(self) -> str:
        """The numbers so far."""
        spl = [self.info["spl"][k] for k in self.marks() if k]
        return (
            f"step {self.steps} of {self.env.unwrapped.max_moves}    "
            f"seen {self.info['coverage']:.0%}    driven {self.info['path_length']:.1f} m    "
            f"reward {self.reward:.2f}" + (f"    SPL {np.mean(spl):.2f}" if spl else "")
        )

    def show(self, wait: bool) -> None:
        """Draw the window."""
        notes = self.task(), self.score(), HELP
        self.window.show(self.env.unwrapped.scene(), notes, wait=wait)

    def listen(self) -> tuple[set[str], bool]:
        """The keys held down, and whether to go on."""
        pressed: set[str] = set()
        for event in pygame.event.get(pygame.KEYDOWN):
            if event.key in (pygame.K_q, pygame.K_ESCAPE):
                return pressed, False
            if event.key == pygame.K_r:
                self.seed += 1
                self.begin()
            pressed |= {"."} if event.key == pygame.K_SPACE else set()
        held = pygame.key.get_pressed()
        return pressed | {name for name, keys in KEYS.items() if any(held[k] for k in keys)}, True


def main(
    env: Annotated[str, typer.Option(help="id of the environment")] = "CogMap/GoHome-v0",
    map_: Annotated[str, typer.Option("--map", help="plan, by name or path")] = "thesis_office",
    experiment: Annotated[int | None, typer.Option(help="of CogMap/Thesis-v0, 1 to 3")] = None,
    control: Annotated[str, typer.Option(help="velocity or move")] = "velocity",
    odometry: Annotated[str, typer.Option(help="perfect, low, medium, high or severe")] = "medium",
    seed: Annotated[int, typer.Option(min=0, help="of the episode")] = 0,
    keys: Annotated[str, typer.Option(help="keys to press, one a step")] = "",
    picture: Annotated[Path | None, typer.Option(dir_okay=False, help="file to write")] = None,
) -> None:
    """Drive the robot with the keyboard."""
    if env not in cogmap_gym.ENV_IDS or set(keys) - {*KEYS, "."}:
        ids = list(cogmap_gym.ENV_IDS)
        raise typer.BadParameter(f"expected an env of {ids}, keys of wasd., got {env!r}, {keys!r}")
    extra = {} if experiment is None else {"experiment": experiment}
    try:
        made = gym.make(env, map=map_, control=control, odometry=odometry, **extra)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    game, script, going = Game(made, seed), list(keys), True
    game.show(not keys)
    while going and (script or not keys):
        pressed, going = ({script.pop(0)}, True) if keys else game.listen()
        action = action_of(made.unwrapped.robot, pressed)
        if action is not None and not game.over:
            game.step(action)
        game.show(not keys)
        going = going and game.window.surface is not None
    print(f"{game.task()}\n{game.score()}")
    if picture is not None and game.window.surface is not None:
        picture.parent.mkdir(parents=True, exist_ok=True)
        pygame.image.save(game.window.surface, picture)
        print(picture)
    game.window.close()


if __name__ == "__main__":
    typer.run(main)
