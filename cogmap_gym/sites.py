"""Floor plans made ready for many robots: what the compiled step needs of each, loaded once."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cogmap_gym.coverage import reachable
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.generator import is_office
from cogmap_gym.geometry import Array, Points, Segments
from cogmap_gym.grid import Grid
from cogmap_gym.raycast_kernel import Ints
from cogmap_gym.tile_kernel import Tiles, blocks_of, tiles_of
from cogmap_gym.wall_cells import file_in_cells, lay_out_cells

Map = str | Path | Mapping[str, Any] | FloorPlan
FEWEST_OFFICES = 8
"""Fewer generated offices are made in this process: a worker takes a second to start."""
MOST_WORKERS = 8
"""Processes that make offices at once, at most; never more than there are processors."""


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """A plan and what follows from it."""

    plan: FloorPlan
    """The building."""
    fixed: Segments
    """Walls and furniture, (N, 2, 2) [m]."""
    movable: Segments
    """Doors, then barriers, (M, 2, 2) [m]."""
    grid: Array
    """Of the laser: x least, y least, side of a cell [m]."""
    size: tuple[int, int]
    """Of the laser's grid: columns, lines."""
    first: Ints
    """Where the rows of each cell of the laser's grid begin."""
    rows: Ints
    """The segments in each cell."""
    corner: tuple[float, float]
    """Of the grid of coverage: x, y [m]."""
    tiles: Tiles
    """Of the grid of coverage: the cells that count."""
    cells: int
    """How many those are, 1 at least."""

    @classmethod
    def of(cls, source: Map) -> Site:
        """Load a plan and work out the rest.

        Raises:
            ValueError: no such plan, or one that breaks the format.
        """
        plan = FloorPlan.load(source)
        fixed = plan.walls_and_furniture()
        movable = np.concatenate((plan.door_segments(), plan.barrier_segments()))
        segments = np.concatenate((fixed, movable)).reshape(-1, 4)
        grid, columns, lines = lay_out_cells(segments)
        first, rows = file_in_cells(segments, grid, columns, lines)
        cover = Grid.over(fixed)
        shut = [plan.doors[name] for name in plan.closed]
        solid = np.concatenate((fixed, np.array(shut).reshape(-1, 2, 2)))
        counts = reachable(cover, plan, solid)
        corner, cells = (cover.x0, cover.y0), max(int(counts.sum()), 1)
        size = columns, lines
        tiles = tiles_of(counts)
        return cls(plan, fixed, movable, grid, size, first, rows, corner, tiles, cells)

    @property
    def segments(self) -> Array:
        """All that can be in the way, (N + M, 4) [m]."""
        return np.concatenate((self.fixed, self.movable)).reshape(-1, 4)

    @property
    def blocks(self) -> NDArray[np.uint8]:
        """How many tiles of each block have cells that count."""
        return blocks_of(self.tiles)

    @property
    def polygons(self) -> tuple[Points, ...]:
        """The rooms' corners, each (K, 2) [m]."""
        return tuple(self.plan.rooms.values())


def load_sites(maps: Sequence[Map]) -> tuple[list[Site], Ints]:
    """The sites of some maps, each loaded once, and which site each map is.

    Generated offices take long: where there are many, processes make them side by side.

    Raises:
        ValueError: no such plan, or one that breaks the format.
    """
    keys = [str(one) if isinstance(one, str | Path) else id(one) for one in maps]
    distinct = dict(zip(keys, maps, strict=True))
    offices = sorted({str(one) for one in distinct.values() if is_office(one)})
    made = _made_offices(offices) if len(offices) >= FEWEST_OFFICES else {}
    sites = [made.get(str(key)) or Site.of(one) for key, one in distinct.items()]
    rows = {key: row for row, key in enumerate(distinct)}
    return sites, np.array([rows[key] for key in keys], dtype=np.int64)


def _made_offices(names: Sequence[str]) -> dict[str, Site]:
    """The sites of generated offices, made by other processes."""
    workers = min(_processors(), MOST_WORKERS)
    if workers < 2:
        return {}
    parts = [names[k::workers] for k in range(workers)]
    with ThreadPoolExecutor(workers) as pool:
        made = list(pool.map(_made_by_worker, parts))
    return {name: site for part in made for name, site in part.items()}


def _processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _made_by_worker(names: Sequence[str]) -> dict[str, Site]:
    """The sites of some offices, made by a process of its own.

    A plain command: a pool of multiprocessing runs the caller's script again, or forks a
    process that has threads.
    """
    path = os.pathsep.join(part for part in sys.path if part)
    command = [sys.executable, "-m", "cogmap_gym.sites", *names]
    run = subprocess.run(  # noqa: S603 - names are checked when the offices are made
        command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, check=False
    )
    if run.returncode:
        return {}  # The caller makes them itself, and meets the error.
    made: dict[str, Site] = pickle.loads(run.stdout)  # noqa: S301 - of our own process
    return made


if __name__ == "__main__":
    from cogmap_gym import sites

    sys.stdout.buffer.write(pickle.dumps({name: sites.Site.of(name) for name in sys.argv[1:]}))
