"""Training that outlives a kill: all that goes on from one rollout to the next, in one file.

The file holds tensors, numbers and text alone and is read with ``weights_only``, so that reading
it runs no code. Episodes under way are not kept: after a resume all robots begin new ones.
"""

from __future__ import annotations

import io
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import torch
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecNormalize

from agents.ppo.network import build
from agents.ppo.params import Config
from cogmap_gym.saving import write_whole

KEPT = ("args", "steps", "updates", "policy", "optimizer", "returns", "curve")
"""What a checkpoint holds."""
Curve = list[dict[str, float]]
"""What was seen of training, a row a rollout."""


def save(path: Path, model: OnPolicyAlgorithm, curve: Curve, args: dict[str, Any]) -> None:
    """Write a checkpoint; whoever reads it sees the last one or this."""
    rewards = _normalizer(model).ret_rms
    kept = {
        "args": args,
        "steps": model.num_timesteps,
        "updates": model._n_updates,
        "policy": model.policy.state_dict(),
        "optimizer": model.policy.optimizer.state_dict(),
        "returns": [float(rewards.mean), float(rewards.var), float(rewards.count)],
        "curve": curve,
    }
    torch.save(kept, buffer := io.BytesIO())
    write_whole(path, buffer.getvalue())


def network(path: Path, config: Config) -> tuple[ActorCriticPolicy, Curve, int]:
    """The network of a checkpoint, the curve until then, and the moves made.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: no checkpoint, or one of another network.
    """
    kept, made = _read(path), build(config)
    try:
        made.load_state_dict(kept["policy"])
    except RuntimeError as error:
        raise ValueError(f"{path}: the network is another: {error}") from error
    return made, kept["curve"], kept["steps"]


def load(path: Path, model: OnPolicyAlgorithm, args: dict[str, Any]) -> Curve:
    """Bring a model to where it was; answers the curve until then.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: no checkpoint, or one of a training with other arguments.
    """
    kept = _read(path)
    was = kept["args"]
    if other := sorted(key for key in args if args[key] != was.get(key)):
        pairs = ", ".join(f"{key}={was.get(key)!r}, not {args[key]!r}" for key in other)
        raise ValueError(f"{path}: begun with {pairs}")
    model.policy.load_state_dict(kept["policy"])
    model.policy.optimizer.load_state_dict(kept["optimizer"])
    model.num_timesteps, model._n_updates = kept["steps"], kept["updates"]
    rewards = _normalizer(model).ret_rms
    rewards.mean, rewards.var, rewards.count = kept["returns"]
    curve: Curve = kept["curve"]
    return curve


def _read(path: Path) -> dict[str, Any]:
    """What a checkpoint holds."""
    try:
        kept: dict[str, Any] = torch.load(path, weights_only=True)
    except (RuntimeError, EOFError, UnpicklingError) as error:
        raise ValueError(f"{path}: no checkpoint: {error}") from error
    if not isinstance(kept, dict) or set(kept) != set(KEPT):
        raise ValueError(f"{path}: no checkpoint: expected {KEPT}")
    return kept


def _normalizer(model: OnPolicyAlgorithm) -> VecNormalize:
    normalizer = model.get_vec_normalize_env()
    assert normalizer is not None, "training scales its rewards"
    return normalizer
