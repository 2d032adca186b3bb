"""The line of one wall, and what the beams of a scan say along it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from agents.cogmap.params import Gaps
from agents.cogmap.view import View
from cogmap_gym.geometry import Array, Points, cross

Ints = NDArray[np.int64]

NONE, FRONT, ON, PASS = 0, 1, 2, 3
"""What a beam says of a wall's line: nothing, ends before it, on it, or beyond it."""


@dataclass(frozen=True, slots=True, eq=False)
class WallLine:
    """All beams in the frame of one wall: ``along`` it in the sense of travel, ``height`` above.

    ``step`` is the sense in which the beams are walked: 1 counter-clockwise, where ``along``
    grows to the wall's end; -1 clockwise, where it grows to the wall's start.
    """

    wall: int
    """Row of the wall among the surfaces of the view."""
    step: int
    origin: Points
    """Where ``along`` is 0, shape (2,)."""
    direction: Points
    """Unit vector of travel, shape (2,)."""
    along: Array
    """Where each beam ended along the line, shape (B,) [m]."""
    height: Array
    """Where each beam ended above it, on the robot's side, shape (B,) [m]."""
    crossing: Array
    """Where each beam crosses the line, in ``along`` [m]; of use where it passes."""
    code: Ints
    """NONE, FRONT, ON or PASS for each beam, shape (B,)."""
    robot_along: float
    robot_height: float

    def reversed(self) -> WallLine:
        """The same line travelled the other way."""
        return replace(
            self,
            step=-self.step,
            direction=-self.direction,
            along=-self.along,
            crossing=-self.crossing,
            robot_along=-self.robot_along,
        )

    def passing_beams(self, view: View, wall: int) -> tuple[Ints, int, int]:
        """The beams beyond a wall's last one, with evidence, and which of them pass first.

        Returns:
            The beams in the sense of travel; where the first run of passing beams begins
            among them, once they have left the line; and where it ends. An empty run means
            that something stops the beams before the line, or that there are no more.
        """
        if self.step == 1:
            beams = np.arange(view.beams[wall, 1] + 1, len(self.code))
        else:
            beams = np.arange(view.beams[wall, 0] - 1, -1, -1)
        beams = beams[self.code[beams] != NONE]
        code = self.code[beams]
        begin = _first(code != ON)
        return beams, begin, begin + _first(code[begin:] != PASS)


def wall_line(view: View, wall: int, step: int, params: Gaps, origin: Points) -> WallLine:
    """Lay the line of a surface and sort the beams by it.

    Args:
        view: in the robot's frame.
        wall: row of the surface.
        step: 1 to travel counter-clockwise, -1 clockwise.
        params: how near to the line counts as on it.
        origin: (2,), where the laser sits in that frame.
    """
    start, end = view.surfaces[wall] if step == 1 else view.surfaces[wall, ::-1]
    span = math.hypot(end[0] - start[0], end[1] - start[1])
    direction = (end - start) / span
    to_points, to_robot = view.points - start, origin - start
    # Free space is on the left of the surface, on the right when it is travelled backwards.
    along, height = to_points @ direction, step * cross(direction, to_points)
    robot_along = float(to_robot @ direction)
    robot_height = step * float(cross(direction, to_robot))
    off = np.maximum(np.maximum(-along, along - span), 0.0)
    tolerance = params.line_distance + params.line_spread * off
    code = np.full(len(along), NONE)
    code[height > tolerance] = FRONT
    code[np.abs(height) <= tolerance] = ON
    code[height < -tolerance] = PASS
    with np.errstate(divide="ignore", invalid="ignore"):
        share = robot_height / (robot_height - height)
    crossing = robot_along + share * (along - robot_along)
    return WallLine(
        wall, step, start, direction, along, height, crossing, code, robot_along, robot_height
    )


def _first(mask: NDArray[np.bool_]) -> int:
    """Index of the first true value, or the length when there is none."""
    return int(mask.argmax()) if mask.any() else len(mask)
