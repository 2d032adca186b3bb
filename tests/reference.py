"""Slow, obvious twins of the fast code: what the kernels are measured against."""

from __future__ import annotations

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from cogmap_gym.geometry import Array, Pose, Segments, cross
from cogmap_gym.observation import LaserSpec


def laser_ranges(segments: Segments, pose: Pose, laser: LaserSpec, slack: float = 0.0) -> Array:
    """Every beam against every segment.

    Args:
        segments: (N, 2, 2), metres.
        pose: of the laser, in the frame of the segments.
        laser: the fan of beams.
        slack: a beam within this distance of the end of a segment meets it [m]; a negative
            one asks beams to pass that far inside both ends.

    Returns:
        (beams,), metres; ``range_max`` where nothing is met.
    """
    angles = pose.theta + laser.angles
    beam = np.stack((np.cos(angles), np.sin(angles)), axis=-1)[:, None]
    p, q = (segments[None, :, end] - pose.position for end in (0, 1))
    side_p, side_q = cross(beam, p), cross(beam, q)
    between = (np.minimum(side_p, side_q) <= slack) & (np.maximum(side_p, side_q) >= -slack)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = cross(p, q - p) / cross(beam, q - p)
    along_p, along_q = (beam * p).sum(-1), (beam * q).sum(-1)
    nearer = np.where(along_p * along_q <= 0.0, 0.0, np.minimum(along_p, along_q))
    distance = np.where(np.isfinite(distance), distance, nearer)
    distance = np.where(between & (distance >= 0.0), distance, laser.range_max)
    return np.minimum(distance.min(axis=1, initial=laser.range_max), laser.range_max)


def clearance(votes: NDArray[np.int8], cap: int) -> Array:
    """Distance of each cell (H, W) to the nearest with votes above 0, up to ``cap`` [cells]."""
    if not (votes > 0).any():
        return np.full(votes.shape, float(cap))
    return np.minimum(distance_transform_edt(votes <= 0), cap)


def cheapest(price: NDArray[np.int16], start: tuple[int, int]) -> dict[tuple[int, int], int]:
    """Costs of the cells that can be reached, in tenths of a cell's side, over eight neighbours.

    Args:
        price: (H, W) of entering a cell, in tenths of that of a free one; 0 is no way.
        start: row and column; its own price does not count.
    """
    graph = nx.DiGraph()
    graph.add_node(start)
    cells = [(int(i), int(j)) for i, j in np.argwhere(price > 0)]
    for i, j in {*cells, start}:
        for a, b in cells:
            if max(abs(a - i), abs(b - j)) == 1:
                length = 14 if a != i and b != j else 10
                graph.add_edge((i, j), (a, b), weight=int(price[a, b]) * length // 10)
    return dict(nx.single_source_dijkstra_path_length(graph, start))
