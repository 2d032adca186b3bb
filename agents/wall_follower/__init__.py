"""A robot that keeps a wall at one hand."""

from agents.wall_follower.agent import WallFollowerAgent

__all__ = ["WallFollowerAgent"]
