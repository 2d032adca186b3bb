"""Weights written to disk, for ``loading`` to read."""

from __future__ import annotations

import json
from pathlib import Path

import safetensors.torch
from stable_baselines3.common.policies import ActorCriticPolicy

from agents.ppo.loading import KEY
from agents.ppo.params import Config
from cogmap_gym.saving import write_whole


def export(path: Path, network: ActorCriticPolicy, config: Config) -> Path:
    """Write the weights of a network with the configuration that they are for; the path."""
    told = {KEY: json.dumps(config.to_dict())}
    arrays = {name: value.detach().contiguous() for name, value in network.named_parameters()}
    return write_whole(path, safetensors.torch.save(arrays, told))
