"""How well ASRs are cut out of random MFIS's: ``python -m tests.mfis_figures``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.asr import ASR, compute_asr
from agents.cogmap.params import Boundary
from tests.mfis_rooms import Scene, make_scene, overlap

WELL_SEEN = 0.8
"""A room of which this share came into view can be judged against the whole of it [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Figures:
    """One row a scene."""

    closed: NDArray[np.bool_]
    overlap: NDArray[np.float64]
    seen: NDArray[np.float64]


@cache
def scene_of(seed: int) -> Scene:
    """The random scene of a seed."""
    return make_scene(np.random.default_rng(seed))


def cut(scene: Scene, params: Boundary) -> ASR:
    """The ASR of a scene; the ids are the rows."""
    ids = np.arange(len(scene.surfaces))
    exits = (scene.exit_crossed, scene.other_exits)
    return compute_asr(1, scene.surfaces, ids, *exits, scene.path, params)


def measure(seeds: range, params: Boundary) -> Figures:
    """Cut the ASR of one random scene a seed."""
    scenes = [scene_of(seed) for seed in seeds]
    asrs = [cut(scene, params) for scene in scenes]
    return Figures(
        np.array([asr.closed for asr in asrs]),
        np.array([overlap(asr.boundary, s) for asr, s in zip(asrs, scenes, strict=True)]),
        np.array([s.seen for s in scenes]),
    )


if __name__ == "__main__":
    for name, params in (("default", Boundary()), ("literal", Boundary.literal())):
        figures = measure(range(200), params)
        for label, rows in (("all", figures.seen >= 0.0), ("seen", figures.seen > WELL_SEEN)):
            closed, iou = figures.closed[rows], figures.overlap[rows]
            print(  # noqa: T201
                f"{name} {label}: {len(iou)} rooms, closed {closed.mean():.3f}, median IoU "
                f"{np.median(iou[closed]):.3f}, below 0.85 {np.mean(iou < 0.85):.3f}"
            )
