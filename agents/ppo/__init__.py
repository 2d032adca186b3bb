"""Robots that learned by PPO, with a memory of their network's own or without.

Weights and their cards stand in ``agents/ppo/weights``; ``scripts/train_ppo.py`` makes them.
"""
