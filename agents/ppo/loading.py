"""Weights on disk: safetensors, which hold arrays and text and can run no code."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import safetensors
import torch
from stable_baselines3.common.policies import ActorCriticPolicy

from agents.ppo.network import build
from agents.ppo.params import Config

FOLDER = Path(__file__).parent / "weights"
"""Where those that come with the package stand."""
ROBOTS = ("ppo", "recurrent_ppo")
"""Their names, which are those of the robots, too."""
KEY = "config"
"""Of the text beside the arrays."""


def path_of(name: str) -> Path:
    """Where the weights of a robot of this package stand."""
    return FOLDER / f"{name}.safetensors"


def load(path: Path) -> tuple[ActorCriticPolicy, Config]:
    """The network of a file, ready to be asked, and its configuration.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is no file of weights, or not of such a network.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no weights: scripts/train_ppo.py makes them")
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            told: Any = (file.metadata() or {}).get(KEY)
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - no mapping
    except safetensors.SafetensorError as error:
        raise ValueError(f"{path}: no safetensors: {error}") from error
    if told is None:
        raise ValueError(f"{path}: {KEY}: expected it in the metadata, got none")
    config = Config.of(_parsed(told, path), str(path))
    network = build(config)
    _fill(network, arrays, path)
    network.set_training_mode(False)
    return network, config


def _fill(network: ActorCriticPolicy, arrays: Mapping[str, torch.Tensor], path: Path) -> None:
    """Give a network its weights, every one of them and no others."""
    own = dict(network.named_parameters())
    shapes = {name: tuple(value.shape) for name, value in own.items()}
    if {name: tuple(value.shape) for name, value in arrays.items()} != shapes:
        raise ValueError(f"{path}: weights do not fit their config: expected {shapes}")
    with torch.no_grad():
        for name, value in arrays.items():
            own[name].copy_(value)


def _parsed(text: str, path: Path) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}: {KEY}: expected JSON, got {text[:40]!r}") from error
