"""A robot that drives to the nearest frontier of its own grid, and plans its ways on it."""

from agents.frontier.agent import FrontierAgent
from agents.frontier.params import Params

__all__ = ["FrontierAgent", "Params"]
