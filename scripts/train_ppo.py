"""Train a learned robot by PPO on generated offices, and write its weights and their card.

Usage: python scripts/train_ppo.py --out DIR [--robot recurrent_ppo] [--preset large] [--resume]

Writes DIR/checkpoint.pt and TensorBoard's files while it learns; at the end NAME.safetensors and
their card, NAME.json and NAME.md, into --weights. --resume goes on after Ctrl-C or a kill. The
preset small takes under an hour on two cores; large is for many. Needs the extra `rl`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import torch
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn, track
from stable_baselines3.common.logger import configure

from agents.ppo import checkpoint, loading
from agents.ppo.card import OFFICES, compare, write_card
from agents.ppo.export import export
from agents.ppo.params import Config, Network
from agents.ppo.training import Watch, make_env, make_model
from cogmap_gym.generator import DEVELOPMENT_SEEDS


def arg(default: Any, told: str) -> Any:
    """A field of ``Args`` with what --help says of it."""
    return field(default=default, metadata={"help": f"{told} (default {default!r})"})


@dataclass(frozen=True)
class Args:
    """What can be given on the command line."""

    out: str = arg("out/ppo", "folder for checkpoint, curves and TensorBoard")
    robot: str = arg("ppo", "what to train")
    preset: str = arg("small", "defaults of what follows")
    resume: bool = arg(False, "go on from the checkpoint in --out")
    weights: str = arg(str(loading.FOLDER), "folder for the weights and their card")
    trials: int = arg(3, "seeds a test office of the comparison at the end; 0 leaves it out")
    checkpoint_seconds: float = arg(60.0, "between two checkpoints: what a kill can cost")
    seed: int = arg(0, "of weights, draws and episodes")
    steps: int = arg(2_000_000, "moves of all robots together; with --resume 0: just export")
    explorers: int = arg(48, "robots that explore, each in an office of its own")
    homers: int = arg(16, "robots that explore and come home, each in an office of its own")
    first_office: int = arg(1000, "offices are numbered from here")
    odometry: str = arg("medium", "level of the odometry")
    most_moves: int = arg(400, "of an episode")
    explore_weight: float = arg(20.0, "of what is newly seen, beside the rewards of going home")
    rollout: int = arg(64, "moves of each robot between two updates")
    batch: int = arg(512, "moves a gradient step")
    epochs: int = arg(6, "passes over what was rolled out")
    learning_rate: float = arg(5e-4, "at the beginning; it falls to 0")
    gamma: float = arg(0.99, "discount a move")
    entropy: float = arg(0.005, "weight of the entropy")
    shared: int = arg(192, "units of the layer that actor and critic share")
    heads: int = arg(96, "units of a layer of their own")
    lstm: int = arg(96, "units of the memory of recurrent_ppo")
    threads: int = arg(1, "of torch and of the world")


LARGE = {"steps": 200_000_000, "explorers": 384, "homers": 128, "batch": 8192, "threads": 16,
         "shared": 512, "heads": 256, "lstm": 256, "learning_rate": 3e-4}  # fmt: skip
"""The preset for a machine with many cores."""
CHOICES = {"robot": loading.ROBOTS, "preset": ("small", "large")}
CHECKPOINT = "checkpoint.pt"
OF_RUN = ("out", "preset", "resume", "weights", "trials", "checkpoint_seconds", "threads", "steps")
"""Arguments that a resume may change."""


def parsed(words: list[str] | None = None) -> Args:
    """The arguments of the command line; the preset stands for what is not given."""
    parser = argparse.ArgumentParser(
        description=__doc__, argument_default=argparse.SUPPRESS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    for one in fields(Args):
        kind: dict[str, Any] = {"type": type(one.default), "choices": CHOICES.get(one.name)}
        if one.default is False:
            kind = {"action": "store_true"}
        parser.add_argument(f"--{one.name.replace('_', '-')}", help=one.metadata["help"], **kind)
    given = vars(parser.parse_args(words))
    args = Args(**((LARGE if given.get("preset") == "large" else {}) | given))
    if args.first_office not in DEVELOPMENT_SEEDS:
        parser.error(f"--first-office: those below 1000 are for tests, got {args.first_office}")
    if (found := Path(args.out, CHECKPOINT)).exists() != args.resume:
        parser.error(f"--out: {found}: {'missing' if args.resume else 'exists: --resume goes on'}")
    return args


def learn(args: Args, config: Config, path: Path, told: dict[str, Any]) -> None:
    """Train, from the start or a checkpoint, and keep it."""
    torch.set_num_threads(args.threads)
    env = make_env(
        {"explore": args.explorers, "home": args.homers}, args.first_office, config,
        args.most_moves, args.explore_weight, odometry=args.odometry, threads=args.threads,
    )  # fmt: skip
    model = make_model(
        env, config, seed=args.seed, n_steps=args.rollout, batch_size=args.batch,
        n_epochs=args.epochs, gamma=args.gamma, ent_coef=args.entropy,
        learning_rate=lambda left: args.learning_rate * left,
    )  # fmt: skip
    curve = checkpoint.load(path, model, told) if args.resume else []
    model.set_random_seed(args.seed + model.num_timesteps)
    model.set_logger(configure(args.out, ["tensorboard"]))
    with Progress(TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()) as progress:
        bar = progress.add_task("moves", total=args.steps)

        def tell(moves: int, point: dict[str, float]) -> None:
            scores = " ".join(f"{k} {v:.2f}" for k, v in point.items() if "/" in k)
            progress.update(bar, completed=moves, description=f"{moves:,} moves {scores}")

        watch = Watch(path, told, curve, args.checkpoint_seconds, tell)
        try:
            left = args.steps - model.num_timesteps
            model.learn(left, watch, reset_num_timesteps=not args.resume)
        except KeyboardInterrupt:
            print(f"interrupted: --resume goes on from {path}", file=sys.stderr)
            sys.exit(130)
        finally:
            watch.keep()


def main() -> None:
    """Train, export, compare, and write the card."""
    args = parsed()
    for folder in (Path(args.out), home := Path(args.weights)):
        folder.mkdir(parents=True, exist_ok=True)
    lstm = args.lstm if args.robot == "recurrent_ppo" else 0
    config = Config(network=Network(args.shared, args.heads, lstm))
    kept = Path(args.out, CHECKPOINT)
    told = {key: value for key, value in asdict(args).items() if key not in OF_RUN}
    try:
        if not (args.resume and checkpoint.network(kept, config)[2] >= args.steps):
            learn(args, config, kept, told)
        network, curve, told["steps"] = checkpoint.network(kept, config)
    except ValueError as error:
        sys.exit(f"{Path(__file__).name}: {error}")
    path = export(home / f"{args.robot}.safetensors", network, config)
    number = 2 * args.trials * len(OFFICES)
    rows = list(track(compare(args.robot, path, args.trials), "test offices", total=number))
    print(path, *write_card(path, told, config.to_dict(), curve, rows), sep="\n")


if __name__ == "__main__":
    main()
