"""A floor plan as it was understood: rooms in colours, walls, doors, home and a scale."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from cogmap_gym.colors import ASR_COLORS
from cogmap_gym.figures import finish, plot_home, plot_plan
from cogmap_gym.floor_plan import FloorPlan

SIDE_IN = 11.0
"""Longer side of the drawing [inch]."""
LEAST_IN = 3.5
"""Shorter side, at least [inch]."""
AROUND_IN = 1.6
"""What title, axes and legend need beside the drawing [inch]."""
FAINT = "55"
"""Alpha of a room's colour, in hexadecimal."""


def plan_figure(plan: FloorPlan) -> Figure:
    """A figure of the whole plan, with metres on both axes."""
    left, low, right, high = plan.bounds
    sides = np.array((right - left, high - low))
    size = np.maximum(sides * SIDE_IN / sides.max(), LEAST_IN) + AROUND_IN
    figure = Figure(figsize=(float(size[0]), float(size[1])), layout="constrained")
    ax = figure.subplots()
    plot_rooms(ax, plan)
    plot_plan(ax, plan, shut=plan.closed)
    plot_home(ax, plan.home)
    finish(ax, f"{plan.name}: {sides[0]:.1f} x {sides[1]:.1f} m, {plan.area:.0f} m² free")
    return figure


def plot_rooms(ax: Axes, plan: FloorPlan) -> None:
    """Fill the rooms, neighbours in the order of the file in different colours."""
    colors = [ASR_COLORS[n % len(ASR_COLORS)] + FAINT for n in range(len(plan.rooms))]
    rooms = list(plan.rooms.values())
    if rooms:
        ax.add_collection(PolyCollection(rooms, facecolors=colors, edgecolors="none", zorder=0))
