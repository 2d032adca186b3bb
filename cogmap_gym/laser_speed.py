"""The cost of a noisy scan: beside the naive one, in larger and larger worlds, and in a batch.

Rounds of the rivals alternate, so that a slow spell of the machine meets all of them.
"""

from __future__ import annotations

import math
import resource
import statistics
import time
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from cogmap_gym.fleet import Fleet
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose, Segments, point_segment_distances
from cogmap_gym.naive import NaiveLaser
from cogmap_gym.observation import LaserSpec, RobotSpec
from cogmap_gym.raycast import RayCaster
from cogmap_gym.sensors import Laser, OdometrySpec
from cogmap_gym.sites import Site
from cogmap_gym.vector_tables import AGAIN, APPEAR

Row = dict[str, object]
SIZES = (150, 1_000, 10_000)
"""Segments of the synthetic offices."""
CLEARANCE = 0.3
"""Distance of a pose from all walls [m]: where a robot can stand."""
ROOM = 5.0
"""Side of a room of the synthetic offices [m]."""
KINDS = 16
"""Generated offices of a campus, each built again and again."""
STREET = 4.0
"""Free space between the offices of a campus [m]."""
POSES, NAIVE_SCANS = 400, 20
"""Scans a round, of ours and of the naive laser."""
TOGGLES = 2_000
"""Times a round that a door is opened or shut."""


def synthetic_office(segments: int, rng: np.random.Generator) -> Segments:
    """Square rooms with doorways of 1 m and a desk each; about as many segments as asked."""
    side = max(round(math.sqrt(segments / 7.0)), 1)
    rows: list[list[tuple[float, float]]] = []
    for i, j in np.ndindex(side, side):
        x, y = ROOM * i, ROOM * j
        dx, dy = x + rng.uniform(0.8, 3.0), y + rng.uniform(0.8, 3.0)
        rows += [[(x, y), (x + 2.0, y)], [(x + 3.0, y), (x + ROOM, y)]]
        rows += [[(x, y), (x, y + 2.0)], [(x, y + 3.0), (x, y + ROOM)]]
        a, b, c = (dx, dy), (dx + 1.2, dy), (dx + 1.2, dy + 0.6)
        rows += [[a, b], [b, c], [c, a]]
    end = ROOM * side
    rows += [[(end, 0.0), (end, end)], [(0.0, end), (end, end)]]
    return np.array(rows)


def standing_poses(walls: Segments, count: int, rng: np.random.Generator) -> list[Pose]:
    """Random poses within the bounds of ``walls``, clear of all of them."""
    low, high = walls.min(axis=(0, 1)), walls.max(axis=(0, 1))
    poses: list[Pose] = []
    while len(poses) < count:
        place = rng.uniform(low, high)
        if point_segment_distances(place[None], walls).min() > CLEARANCE:
            poses.append(Pose(place[0], place[1], rng.uniform(-math.pi, math.pi)))
    return poses


def campus(segments: int, rng: np.random.Generator) -> tuple[Segments, list[Pose]]:
    """Generated offices side by side, with at least so many segments, and poses in them."""
    kinds = [FloorPlan.load(f"office:{1000 + k}").walls_and_furniture() for k in range(KINDS)]
    kinds = [walls - walls.min(axis=(0, 1)) for walls in kinds]
    poses = [standing_poses(walls, POSES // KINDS, rng) for walls in kinds]
    plot = np.max([walls.max(axis=(0, 1)) for walls in kinds], axis=0) + STREET
    blocks = math.ceil(segments / sum(len(walls) for walls in kinds))
    side = math.ceil(math.sqrt(blocks * KINDS))
    spots = plot * np.array(list(np.ndindex(side, side))[: blocks * KINDS])
    built = [kinds[k % KINDS] + spot for k, spot in enumerate(spots)]
    stood = [
        Pose(pose.x + shift[0], pose.y + shift[1], pose.theta)
        for k, kind in enumerate(poses)
        for pose in kind
        for shift in (spots[k + KINDS * rng.integers(blocks)],)
    ]
    return np.concatenate(built), stood


def laser_costs(plan: FloorPlan, largest: int, rounds: Iterable[int], seed: int) -> list[Row]:
    """Microseconds of a noisy scan in worlds of more and more segments.

    Args:
        plan: the first world.
        largest: segments of a campus, without a naive rival; 0 for none.
        rounds: in each, all worlds and rivals take their turn.
        seed: of worlds, poses and noise.

    Returns:
        A row for each world: medians, and the medians of the rounds' ratios to the naive laser
        and to the smallest synthetic office.
    """
    rng, spec = np.random.default_rng(seed), LaserSpec()
    worlds = {plan.name: plan.walls_and_furniture()}
    worlds |= {f"synthetic {size}": synthetic_office(size, rng) for size in SIZES}
    poses = {name: standing_poses(walls, POSES, rng) for name, walls in worlds.items()}
    naive = {name: NaiveLaser(walls, spec) for name, walls in worlds.items()}
    if largest:
        worlds["campus"], poses["campus"] = campus(largest, rng)
    ours = {name: Laser(RayCaster(walls), spec) for name, walls in worlds.items()}
    first = f"synthetic {SIZES[0]}"
    times = [
        {
            name: (
                _seconds(naive.get(name), poses[name][:NAIVE_SCANS], rng),
                _seconds(ours[name], poses[name], rng),
            )
            for name in worlds
        }
        for _ in rounds
    ]
    return [
        {
            "world": name,
            "segments": len(walls),
            "naive_us": 1e6 * statistics.median(t[name][0] for t in times) or None,
            "ours_us": 1e6 * statistics.median(t[name][1] for t in times),
            "times_naive": statistics.median(t[name][0] / t[name][1] for t in times) or None,
            "against_150": statistics.median(t[name][1] / t[first][1] for t in times),
        }
        for name, walls in worlds.items()
    ]


def batch_costs(plan: FloorPlan, robots: int, rounds: Iterable[int], seed: int) -> Row:
    """Microseconds of a noisy scan of many robots in one compiled call, beside the naive one's."""
    rng, spec = np.random.default_rng(seed), LaserSpec()
    walls = plan.walls_and_furniture()
    poses, naive = standing_poses(walls, robots, rng), NaiveLaser(walls, spec)
    where = np.zeros(robots, dtype=np.int64)
    fleet = Fleet([Site.of(plan)], where, RobotSpec(), spec, OdometrySpec.of("perfect"), 1)
    for row, pose in enumerate(poses):
        fleet.place(row, pose.x, pose.y, pose.theta)
    still = np.zeros((robots, 3))
    scan, _ = fleet.step(np.full(robots, APPEAR), still)
    times = [
        (
            _seconds(naive, poses[:NAIVE_SCANS], rng),
            _batch_seconds(fleet, still, scan),
        )
        for _ in rounds
    ]
    return {
        "world": f"{plan.name}, {robots} robots a call",
        "segments": len(walls),
        "naive_us": 1e6 * statistics.median(a for a, _ in times),
        "ours_us": 1e6 * statistics.median(b for _, b in times),
        "times_naive": statistics.median(a / b for a, b in times),
        "against_150": None,
    }


def toggle_seconds(plan: FloorPlan, rounds: Iterable[int]) -> float:
    """Median time to open or shut a door for the laser [s]."""
    doors = plan.door_segments()
    caster, times = RayCaster(plan.walls_and_furniture(), doors), []
    for _ in rounds:
        begin = time.perf_counter()
        for k in range(TOGGLES):
            caster.set_solid(k % len(doors), solid=k // len(doors) % 2 == 0)
        times.append((time.perf_counter() - begin) / TOGGLES)
    return statistics.median(times)


def memory_peak() -> float:
    """The most memory that this process has held so far [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def _seconds(
    laser: NaiveLaser | Laser | None, poses: Sequence[Pose], rng: np.random.Generator
) -> float:
    """Mean time of one scan over ``poses``, 0 without a laser; the first call is not counted."""
    if laser is None:
        return 0.0
    laser.scan(poses[0], rng)
    begin = time.perf_counter()
    for pose in poses:
        laser.scan(pose, rng)
    return (time.perf_counter() - begin) / len(poses)


def _batch_seconds(fleet: Fleet, still: Any, scan: Any) -> float:
    """Mean time of one robot's scan where all scan in one call."""
    modes, count = np.full(fleet.count, AGAIN), max(4 * POSES // fleet.count, 4)
    fleet.step(modes, still, scan)
    begin = time.perf_counter()
    for _ in range(count):
        fleet.step(modes, still, scan)
    return (time.perf_counter() - begin) / (count * fleet.count)
