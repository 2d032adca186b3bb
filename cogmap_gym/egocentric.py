"""A wrapper that draws scans into a grid about the robot, laid together by odometry."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from cogmap_gym.geometry import Array, Points, Pose
from cogmap_gym.observation import LaserSpec, Observation
from cogmap_gym.raycast_kernel import compiled
from cogmap_gym.sensor_wrappers import Env, box_of, reckoned, with_key

WALL, UNKNOWN, FREE = 0, 127, 255
"""What a cell holds, in the colours of ROS's map_server."""
MEMORY = 4
"""How many times as wide as the window the remembered square is. Ours."""
HALF_DIAGONAL = 0.75
"""Half the diagonal of the window as a part of its side, rounded up [1]."""

Cells = NDArray[np.uint8]


class EgocentricGrid(gym.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Adds a picture of what is about the robot, from its scans and its odometry alone.

    The robot stands in the middle and looks up. The newest evidence for a cell wins; walls
    drift as the odometry does. What lies within four windows' width is remembered.

    | key | before | after |
    |---|---|---|
    | ``grid`` | none | Box uint8 (1, cells, cells), 0 wall, 127 unknown, 255 free; row 0 ahead |

    Args:
        env: a CogMap environment whose scan has all its beams: put ``ScanSectors`` and
            ``StackedScans`` above this wrapper.
        cells: side of the picture; Stable-Baselines3's default network needs 36.
        cell_size: side of a cell [m].

    Raises:
        ValueError: fewer than 2 cells, a size not above 0, or a scan that was changed.
    """

    def __init__(self, env: Env, cells: int = 64, cell_size: float = 0.2) -> None:
        """Know nothing yet."""
        RecordConstructorArgs.__init__(self, cells=cells, cell_size=cell_size)
        gym.ObservationWrapper.__init__(self, env)
        if isinstance(cells, bool) or not isinstance(cells, int) or cells < 2:
            raise ValueError(f"EgocentricGrid: cells: expected an int above 1, got {cells!r}")
        if not (math.isfinite(cell_size) and cell_size > 0.0):
            raise ValueError(f"EgocentricGrid: cell_size: expected above 0 m, got {cell_size!r}")
        self._laser: LaserSpec = env.get_wrapper_attr("laser")
        if (shape := box_of(env, "scan").shape) != (self._laser.beams,):
            raise ValueError(
                f"EgocentricGrid: expected a scan of {self._laser.beams} beams, got shape {shape}"
            )
        self.observation_space = with_key(
            env, "grid", spaces.Box(0, 255, (1, cells, cells), np.uint8)
        )
        self._size = cell_size
        self._window_in_robot = _window(cells, cell_size)
        self._forget()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, knowing nothing."""
        self._forget()
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Observation) -> Observation:
        """The observation with the picture."""
        self._memory_from_robot @= reckoned(observation)
        self._keep_inside()
        self._enter(observation["scan"].astype(np.float64))
        at = self._memory_from_robot.apply(self._window_in_robot) / self._size
        columns, rows = np.floor(at).astype(np.intp).transpose(2, 0, 1)
        return {**observation, "grid": self._memory[rows, columns][None]}

    def _forget(self) -> None:
        side = MEMORY * len(self._window_in_robot)
        self._memory: Cells = np.full((side, side), UNKNOWN, dtype=np.uint8)
        middle = 0.5 * side * self._size
        self._memory_from_robot = Pose(middle, middle, 0.0)

    def _keep_inside(self) -> None:
        """Move what is remembered so that the window lies within it."""
        side, size, pose = len(self._memory), self._size, self._memory_from_robot
        off = np.array((pose.x, pose.y)) / size - 0.5 * side
        if np.abs(off).max() < 0.5 * side - HALF_DIAGONAL * side / MEMORY:
            return
        columns, rows = np.rint(off).astype(int).tolist()
        self._memory = _shifted(self._memory, rows, columns)
        self._memory_from_robot = Pose(pose.x - columns * size, pose.y - rows * size, pose.theta)

    def _enter(self, ranges: Array) -> None:
        """Draw a scan (beams,) [m] into what is remembered."""
        eye = self._memory_from_robot @ self._laser.robot_from_laser
        x, y = eye.x / self._size, eye.y / self._size
        reach = np.where(np.isfinite(ranges), ranges, 0.0) / self._size
        far = self._laser.range_max / self._size
        _draw(self._memory, x, y, self._laser.angles + eye.theta, reach, far * (1.0 - 1e-6))


def _window(cells: int, size: float) -> Points:
    """Centres of the picture's cells in the robot's frame, (cells, cells, 2) [m]."""
    ahead = (0.5 * cells - np.arange(cells) - 0.5) * size
    xs, ys = np.meshgrid(ahead, ahead, indexing="ij")
    return np.stack((xs, ys), axis=-1)


def _shifted(memory: Cells, rows: int, columns: int) -> Cells:
    """The same cells about a middle that lies ``rows`` and ``columns`` further on."""
    side, out = len(memory), np.full_like(memory, UNKNOWN)
    if max(abs(rows), abs(columns)) < side:
        source = [slice(max(n, 0), side + min(n, 0)) for n in (rows, columns)]
        target = [slice(max(-n, 0), side + min(-n, 0)) for n in (rows, columns)]
        out[tuple(target)] = memory[tuple(source)]
    return out


@compiled
def _draw(cells: Cells, x: float, y: float, directions: Array, ranges: Array, far: float) -> None:
    """Mark what beams pass through as free, then where they end as wall; lengths in cells.

    Args:
        cells: (rows, columns), changed in place.
        x: where the beams start, in columns.
        y: the same, in rows.
        directions: (B,) [rad].
        ranges: (B,), how far each goes.
        far: a range of at least this ends at nothing.
    """
    rows, columns = cells.shape
    for b in range(directions.shape[0]):
        step_x, step_y = 0.5 * math.cos(directions[b]), 0.5 * math.sin(directions[b])
        for n in range(int(2.0 * ranges[b])):
            row, column = math.floor(y + n * step_y), math.floor(x + n * step_x)
            if row < 0 or column < 0 or row >= rows or column >= columns:
                break
            cells[row, column] = FREE
    for b in range(directions.shape[0]):
        if 0.0 < ranges[b] < far:
            row = math.floor(y + ranges[b] * math.sin(directions[b]))
            column = math.floor(x + ranges[b] * math.cos(directions[b]))
            if 0 <= row < rows and 0 <= column < columns:
                cells[row, column] = WALL
