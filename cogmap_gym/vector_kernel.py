"""One compiled step of many robots: motion, contact, rooms, odometry, laser, noise, coverage.

The rules are those of ``world``, ``sensors``, ``trail`` and ``coverage``, whose compiled twins
are put together here. Robots share nothing that a step changes, and each draws from a stream of
its own, keyed by its episode and step: so the bits do not depend on the number of threads, nor
on which robots stand beside one another.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from cogmap_gym import (
    body,
    coverage_kernel,
    disc_kernel,
    goal_kernel,
    grid,
    kernel_parts,
    noise,
    phases,
    raycast_kernel,
    sensors,
    shared_count,
    tile_kernel,
    trail,
    trail_kernel,
    vector_tables,
    visibility,
)
from cogmap_gym.coverage_kernel import look
from cogmap_gym.disc_kernel import (
    BUMP,
    DRIFT_M,
    DRIVEN,
    HEADING,
    POINTS,
    TURNED,
    X,
    Y,
    drive_disc,
    gap_to,
    gather,
    move_disc,
    wrapped,
)
from cogmap_gym.geometry import Array
from cogmap_gym.goal_kernel import distance_to_goal
from cogmap_gym.grid import CELL_M
from cogmap_gym.kernel_parts import fingerprint, part, whole
from cogmap_gym.noise import add_noise, key_at, normal
from cogmap_gym.phases import MARK_GAP_M
from cogmap_gym.raycast_kernel import cast_rays
from cogmap_gym.sensors import TYPICAL_DISTANCE, TYPICAL_TURN
from cogmap_gym.shared_count import finish, take
from cogmap_gym.trail_kernel import NOWHERE, door_gap, follow, room_at
from cogmap_gym.vector_tables import AGAIN, DECLARE, MOVE, REST
from cogmap_gym.visibility import TOLERANCE_M

ABSENT: Final = int(np.iinfo(np.int64).max)
"""Stamp of a door or barrier that is not there, as in ``raycast``."""
Tables = tuple[Any, ...]


@part
def _move(
    r: Any, spec: Any, first: float, second: float, near: Array, count: int,
    velocity: Array, path: Array, out: Array,
) -> None:  # fmt: skip
    """Move a robot by an action within bounds; see ``CogMapEnv._move``."""
    if spec["velocity"] == 1:
        v, omega = first * spec["speed"], second * spec["turn_rate"]
        drive_disc(
            v, omega, spec["seconds"], spec["speed"], spec["radius"], near, count, velocity, path,
            out,
        )  # fmt: skip
    else:
        turn, forward = first * spec["turn"], spec["forward"] * (second + 1.0) / 2.0
        move_disc(
            turn, forward, spec["speed"], spec["radius"], near, count, velocity, path, out
        )  # fmt: skip
    r["x"], r["y"], r["theta"], r["bump"] = out[X], out[Y], out[HEADING], np.int64(out[BUMP])


@part
def _set_doors(solid: Any, movable: int, seen: Any) -> None:
    """Have the rays of a robot meet those of its doors and barriers that are there."""
    for m in range(movable):
        seen[m] = 0 if solid[m] else ABSENT


@part
def _reach_of(spec: Any, mode: int, forward: float) -> float:
    """How far from where it stands a robot may come to touch something in this step [m]."""
    reach = spec["radius"] + DRIFT_M
    if mode == MOVE:
        reach += spec["speed"] * spec["seconds"]
        if spec["velocity"] == 0:
            reach += spec["forward"] * (forward + 1.0) / 2.0
    return reach  # type: ignore[no-any-return]


@part
def _follow(
    r: Any, p: Any, path: Array, points: int, rooms: Tables, segments: Array, entered: Any
) -> None:
    """Note how long a robot's way was, and which rooms it entered; see ``Trail``."""
    _, boxes, corners, edges = rooms
    r["length"] += follow(
        path, points, r["last"], boxes, corners, edges, p["rooms"], p["rooms_end"], segments,
        p["fixed"], p["fixed"] + p["doors"], entered,
    )  # fmt: skip
    if entered[0] > 0:
        r["last"] = entered[entered[0]]


@part
def _find_room(r: Any, p: Any, rooms: Tables, segments: Array, wanted: Any) -> None:
    """Note in which room a robot stands, and whether a mark may be given to it there."""
    _, boxes, corners, edges = rooms
    r["room"] = room_at(r["x"], r["y"], boxes, corners, edges, p["rooms"], p["rooms_end"])
    r["marked"] = 0
    if r["room"] != NOWHERE and wanted[r["room"]]:
        gap = door_gap(r["x"], r["y"], segments, p["fixed"], p["fixed"] + p["doors"])
        r["marked"] = 1 if gap >= MARK_GAP_M else 0


@part
def _measure(r: Any, spec: Any, turn: float, distance: float, reading: Any) -> None:
    """Write what the wheels report of a motion; see ``Odometer`` and ``odometry_reading``."""
    key = key_at(r["key"], 2 * r["count"])
    k = (abs(turn) / TYPICAL_TURN + abs(distance) / TYPICAL_DISTANCE) / 2.0
    turn_error = r["turn_sign"] * spec["turn_bias"] * k
    turn_error += spec["turn_sd"] * math.sqrt(k) * normal(key)
    sd = TYPICAL_DISTANCE * spec["distance_sd"] * math.sqrt(abs(distance) / TYPICAL_DISTANCE)
    measured = distance + r["distance_sign"] * spec["distance_bias"] * distance
    measured += sd * normal(key_at(key, 1))
    # Of a step along an arc the chord is measured, half the turn's error before it.
    ahead = turn + turn_error if spec["velocity"] == 0 else turn / 2.0 + turn_error / 2.0
    total = turn + turn_error
    bound_x, bound_y = np.float32(spec["bound_x"]), np.float32(spec["bound_y"])
    bound_theta = np.float32(spec["bound_theta"])
    reading[0] = min(max(np.float32(measured * math.cos(ahead)), -bound_x), bound_x)
    reading[1] = min(max(np.float32(measured * math.sin(ahead)), -bound_y), bound_y)
    reading[2] = min(max(np.float32(wrapped(total)), -bound_theta), bound_theta)


@part
def _sense(
    r: Any, p: Any, spec: Any, segments: Array, tables: Tables, seen: Any, stamp: int,
    tiles: Any, blocks: Any, looking: Tables, draws: Array, missed: Any, scan: Any,
    looks: bool,
) -> None:  # fmt: skip
    """Scan, with noise, and if it ``looks`` mark what is seen; see ``Laser`` and ``Coverage``."""
    grids, first, rows, fan = tables
    c, s = math.cos(r["theta"]), math.sin(r["theta"])
    x = r["x"] + c * spec["mount_x"] - s * spec["mount_y"]
    y = r["y"] + s * spec["mount_x"] + c * spec["mount_y"]
    heading, last = r["theta"] + spec["middle"], spec["beams"] - 1
    ranges = cast_rays(
        segments, first[p["cells"] :], rows, seen, stamp, grids[r["plan"]],
        p["columns"], p["lines"], fan, last, spec["step"], spec["range_max"], x, y, heading,
    )  # fmt: skip
    key = int(key_at(r["key"], 2 * r["count"] + 1) >> np.uint64(1))
    add_noise(ranges, spec["range_max"], spec["sd"], key, draws, missed, scan)
    if not looks:
        return
    high, wide = p["tile_rows"], p["tile_columns"]
    unseen = tiles[r["tiles"] : r["tiles"] + high * wide].reshape((high, wide))
    full = blocks[r["blocks"] : r["blocks"] + high * wide // 16].reshape((high // 4, wide // 4))
    r["new"] = look(
        unseen, full, (x - p["corner_x"]) / CELL_M, (y - p["corner_y"]) / CELL_M, heading,
        fan, last, spec["step"], ranges, looking,
    )  # fmt: skip


@part
def _approach(
    r: Any, p: Any, spec: Any, segments: Array, gap: float, solid: Any, nodes: Array,
    lengths: Array, values: Array,
) -> None:  # fmt: skip
    """Write how far the goal is by the shortest way."""
    reach, fixed = min(spec["radius"], gap) - TOLERANCE_M, p["fixed"]
    walls = segments[:fixed].reshape((fixed, 2, 2))
    leaves = segments[fixed : fixed + p["movable"]].reshape((p["movable"], 2, 2))
    r["to_goal"] = distance_to_goal(
        r["x"], r["y"], r["mark_x"], r["mark_y"], reach, r["mark_reach"],
        nodes[p["nodes"] : p["nodes_end"]], lengths, walls, leaves, solid, values,
    )  # fmt: skip


def _kernel(sources: int) -> Any:
    """The step of the robots that no other thread takes, with scratch memory of one's own."""

    def step_some(
        shared: Any, scratch: Tables, modes: Any, actions: Any, spec: Any, plans: Any,
        robots: Any, solid: Any, wanted: Any, tables: Tables, rooms: Tables, memory: Tables,
        goals: Tables, entered: Any, scan: Any, odometry: Any,
    ) -> int:  # fmt: skip
        all_segments = rooms[0]
        tiles, blocks = memory
        nodes, lengths = goals
        near, velocity, path, o, seen, stamps, looking, draws, missed, values = scratch
        taken = 0
        for taken in range(len(modes) + 1):  # noqa: B007 - counts the robots
            i = take(shared)
            if i >= len(modes):
                break
            if modes[i] == REST:
                continue
            r = robots[i]
            p = plans[r["plan"]]
            fixed, stamp = p["fixed"], stamps[0] + 2
            stamps[0] = stamp
            total = fixed + p["movable"]
            segments = all_segments[p["begin"] : p["begin"] + total]
            _set_doors(solid[i], p["movable"], seen[fixed:])
            if modes[i] == AGAIN:
                r["count"] -= 1
            count = 0
            if modes[i] == MOVE or (modes[i] == DECLARE and r["goal"] > 0):
                count = gather(
                    r["x"], r["y"], _reach_of(spec, modes[i], actions[i, 1]), segments,
                    tables[1][p["cells"] :], tables[2], seen, stamp - 1, tables[0][r["plan"]],
                    p["columns"], p["lines"], near,
                )  # fmt: skip
            if modes[i] != AGAIN:
                entered[i, 0], r["bump"] = 0, 0
                r["before_x"], r["before_y"], r["before_theta"] = r["x"], r["y"], r["theta"]
                r["before_to_goal"] = r["to_goal"]
                odometry[i, 0] = odometry[i, 1] = odometry[i, 2] = 0.0
            if modes[i] == MOVE:
                o[X], o[Y], o[HEADING] = r["x"], r["y"], r["theta"]
                _move(r, spec, actions[i, 0], actions[i, 1], near, count, velocity, path, o)
                _follow(r, p, path, int(o[POINTS]), rooms, segments, entered[i])
                _measure(r, spec, o[TURNED], o[DRIVEN], odometry[i])
            _find_room(r, p, rooms, segments, wanted[i])
            if r["goal"] > 0 and modes[i] in (MOVE, DECLARE):
                gap = gap_to(r["x"], r["y"], near, count)
                _approach(r, p, spec, segments, gap, solid[i], nodes, lengths[i], values)
            _sense(
                r, p, spec, segments, tables, seen, stamp, tiles, blocks, looking,
                draws, missed, scan[i], modes[i] != AGAIN,
            )  # fmt: skip
            r["count"] += 1
            seen[fixed:total] = 0
        finish(shared, taken)
        return sources

    return whole(step_some)


step_robots = _kernel(
    fingerprint(
        body,
        coverage_kernel,
        disc_kernel,
        goal_kernel,
        grid,
        kernel_parts,
        noise,
        phases,
        raycast_kernel,
        sensors,
        shared_count,
        tile_kernel,
        trail,
        trail_kernel,
        vector_tables,
        visibility,
    )
)
