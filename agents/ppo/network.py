"""The networks, as Stable-Baselines3 builds them: one shared layer, an LSTM or none, two heads."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

from agents.ppo.params import Config, Network


class SharedLayer(BaseFeaturesExtractor):  # type: ignore[misc]
    """The layer on the percepts.

    Args:
        observation_space: of the percepts.
        width: of the layer.
    """

    def __init__(self, observation_space: spaces.Box, width: int) -> None:
        """Make the layer."""
        super().__init__(observation_space, width)
        self.layer = torch.nn.Sequential(
            torch.nn.Linear(observation_space.shape[0], width), torch.nn.ReLU()
        )

    def forward(self, percepts: torch.Tensor) -> torch.Tensor:
        """(N, size) to (N, width)."""
        out: torch.Tensor = self.layer(percepts)
        return out


def spaces_of(config: Config) -> tuple[spaces.Box, spaces.MultiDiscrete[Any]]:
    """What the network is shown, and what it chooses: a turn and a drive."""
    shown = spaces.Box(-np.inf, np.inf, (config.percepts.size,), np.float32)
    return shown, spaces.MultiDiscrete(list(config.moves.counts))


def policy_kwargs(network: Network) -> dict[str, Any]:
    """What Stable-Baselines3 needs to be told of the network."""
    plain = {
        "features_extractor_class": SharedLayer,
        "features_extractor_kwargs": {"width": network.shared},
        "net_arch": {"pi": [network.heads], "vf": [network.heads]},
        "activation_fn": torch.nn.ReLU,
    }
    memory = {
        "lstm_hidden_size": network.lstm,
        "enable_critic_lstm": False,
        "shared_lstm": False,
    }
    return plain | memory if network.lstm else plain


def build(config: Config) -> ActorCriticPolicy:
    """A network with weights drawn by torch."""
    kind = RecurrentActorCriticPolicy if config.network.lstm else ActorCriticPolicy
    return kind(*spaces_of(config), lambda _: 0.0, **policy_kwargs(config.network))
