"""A robot that drives straight on and turns at random where it cannot."""

from agents.random_walk.agent import RandomWalkAgent

__all__ = ["RandomWalkAgent"]
