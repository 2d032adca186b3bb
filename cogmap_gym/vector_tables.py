"""The arrays that the compiled step of many robots works on: numbers of plans, robots, specs."""

from __future__ import annotations

from typing import Final

import numpy as np

MOVE, DECLARE, APPEAR, REST, AGAIN = range(5)
"""What a robot does in a step: moves; stands and declares; stands on its first step; nothing;
scans again, since a door has changed after the step."""

_INT, _FLOAT = np.int64, np.float64
PLAN: Final = np.dtype(
    [
        *((name, _INT) for name in ("begin", "fixed", "doors", "movable")),
        *((name, _INT) for name in ("cells", "columns", "lines", "rooms", "rooms_end")),
        *((name, _INT) for name in ("tile_rows", "tile_columns", "nodes", "nodes_end")),
        *((name, _FLOAT) for name in ("corner_x", "corner_y")),
    ]
)
"""Where a plan's own part of each joint table lies.

``begin``, ``fixed``, ``doors``, ``movable``: its first segment, and how many of them stand still,
are doors (the first that do not), are doors or barriers. ``cells``, ``columns``, ``lines``: its
first cell and the size of the laser's grid. ``rooms``, ``nodes``: first and one past the last.
``corner_x``, ``corner_y``: of the grid of coverage [m], which has ``tile_rows`` times
``tile_columns`` tiles.
"""
ROBOT: Final = np.dtype(
    [
        ("plan", _INT),
        *((name, _FLOAT) for name in ("x", "y", "theta")),
        *(("key", np.uint64), ("count", _INT), ("tiles", _INT), ("blocks", _INT)),
        *((name, _FLOAT) for name in ("turn_sign", "distance_sign")),
        *((name, _INT) for name in ("room", "last", "bump", "new", "marked", "goal")),
        *((name, _FLOAT) for name in ("length", "mark_x", "mark_y", "mark_reach")),
        ("to_goal", _FLOAT),
        *((f"before_{name}", _FLOAT) for name in ("x", "y", "theta", "to_goal")),
    ]
)
"""What a step reads and writes of each robot.

``x``, ``y``, ``theta``: the true pose. ``key``, ``count``: of its noise, and steps of the
episode. ``tiles``, ``blocks``: where its coverage begins. ``room``, ``last``: the room it is in,
and that it entered last. ``bump``, ``new``, ``marked``: contact, cells newly seen, whether it
stands where a mark may be given. ``length``: way of this episode [m]. ``goal``: the mark it
shall go to, which is at ``mark_x``, ``mark_y`` [m] and ``to_goal`` away by the shortest way [m].
``before_...``: before the step.
"""
POSE: Final = np.dtype(
    {
        "names": ["pose"],
        "formats": [(_FLOAT, (3,))],
        "offsets": [_INT().itemsize],
        "itemsize": ROBOT.itemsize,
    }
)
"""Of the same memory: ``x``, ``y`` and ``theta`` as one."""
SPEC: Final = np.dtype(
    [
        ("velocity", _INT),
        *((n, _FLOAT) for n in ("radius", "forward", "turn", "speed", "turn_rate", "seconds")),
        *((n, _FLOAT) for n in ("distance_sd", "turn_sd", "distance_bias", "turn_bias")),
        *((n, _FLOAT) for n in ("bound_x", "bound_y", "bound_theta")),
        *((n, _FLOAT) for n in ("range_max", "sd", "step", "middle", "mount_x", "mount_y")),
        ("beams", _INT),
    ]
)
"""The numbers of robot, odometry and laser, in the units of their specs."""
