"""The robot of the thesis: it finds its way with an inexact map and a network of places."""

from agents.cogmap.agent import CogMapAgent
from agents.cogmap.params import Params

__all__ = ["CogMapAgent", "Params"]
