"""Exits that part nothing: between a table and a wall the room goes on round the table.

Ours: the thesis knows exits by their width alone (3.3). An exit must part two spaces, so what
was seen to be free on both of its sides may not hang together by another way close by.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from agents.cogmap.exits import Exit, exit_lines, rename_place, replace_exit, seen_exits
from agents.cogmap.free_space import Cells, cells_of
from agents.cogmap.memory import Leads, Mark, Memory
from agents.cogmap.mfis import FORGOTTEN
from agents.cogmap.navigator import plan_path, sample_surfaces
from agents.cogmap.params import Params
from agents.cogmap.places import within
from cogmap_gym.geometry import Points, lengths, segments_cross
from cogmap_gym.observation import RobotSpec


def doubt_exit(memory: Memory, exit_id: int, params: Params) -> Memory:
    """The memory with an exit noted as false, if it is one of the present place and parts nothing.

    Args:
        memory: with the robot near the exit.
        exit_id: an exit never crossed.
        params: all thresholds.
    """
    target = memory.exit(exit_id)
    if parts(memory, target, memory.stay.leads.seen, params):
        return memory
    return replace(memory, book=replace_exit(memory.book, replace(target, false=True)))


def rejoin(memory: Memory, params: Params) -> Memory:
    """Be again in the place just left, if the exit crossed turns out to part nothing.

    Args:
        memory: in a place not known.
        params: all thresholds.
    """
    stay, back = memory.stay, memory.stay.came_from
    entry, left = memory.exit(stay.entry), memory.leads_of(back)
    seen = np.union1d(stay.leads.seen, left.seen)
    if parts(memory, entry, seen, params) and not _walked_round(memory, left.seen, params):
        return memory
    book = replace_exit(memory.book, replace(entry, false=True))
    returned = memory.with_stay(
        place=back,
        known=True,
        settled=True,
        entry=0,
        came_from=0,
        leads=replace(together(left, stay.leads), seen=seen),
        looked=True,
    )
    return replace(
        returned,
        book=rename_place(book, stay.place, back),
        marks=tuple(_renamed(m, stay.place, back) for m in memory.marks),
        intent=None,
        status=f"still in {back}",
    )


def _walked_round(memory: Memory, seen: Cells, params: Params) -> bool:
    """Whether the robot has come back into the place just left, and through no exit.

    Args:
        memory: in a place not known.
        seen: cells seen to be free from the place just left.
        params: all thresholds.
    """
    stay, p = memory.stay, params.union
    back = memory.network.asr(stay.came_from)
    if back is None:
        return False
    door = memory.exit(stay.entry).middle
    path = stay.path[:-1]  # the last one may lie beyond an exit
    path, looks = (q[np.hypot(*(q - door).T) >= p.off_door] for q in (path, back.looks))
    inside = np.isin(cells_of(path, params.curiosity), seen)
    if back.closed and np.count_nonzero(inside & within(back, path, p.depth)) >= p.spots_back:
        return True
    return _beside(memory, path, looks, p.near_look)


def _beside(memory: Memory, path: Points, looks: Points, near: float) -> bool:
    """Whether some spot (P, 2) is near one (L, 2) where the robot once stood, nothing between."""
    gaps = np.hypot(*(path[:, None] - looks[None]).transpose(2, 0, 1))
    rows, columns = np.nonzero(gaps <= near)
    between = np.stack((path[rows], looks[columns]), axis=1)
    mfis = memory.mapping.mfis
    doors = exit_lines(seen_exits(memory.book))
    walls = np.concatenate((mfis.surfaces[mfis.asr != FORGOTTEN], doors))
    return bool((~segments_cross(between, walls).any(axis=1)).any())


def together(one: Leads, other: Leads) -> Leads:
    """The leads of two parts of one place; what was seen to be free is that of the first."""
    return replace(
        one,
        gaps=np.concatenate((one.gaps, other.gaps)),
        dim=np.concatenate((one.dim, other.dim)),
        lit=np.concatenate((one.lit, other.lit)),
        done=np.concatenate((one.done, other.done)),
    )


def _renamed(mark: Mark, old: int, new: int) -> Mark:
    return replace(mark, place=new) if mark.place == old else mark


def parts(memory: Memory, target: Exit, seen: Cells, params: Params) -> bool:
    """Whether no way seen to be free leads from one side of an exit to the other close by.

    Args:
        memory: for what stands about, and the other exits, by which no way round may lead.
        target: the exit.
        seen: cells seen to be free.
        params: all thresholds.
    """
    p = params.exits
    shut = [e.line for e in seen_exits(memory.book) if e.id != target.id]
    along = (target.line[1] - target.line[0]) / lengths(target.line[None])[0]
    wide = target.line + p.flank * np.stack((-along, along))
    doors = sample_surfaces(np.array([*shut, wide]), params.navigation.cell)
    left, right = target.middle + p.aside * target.normal, target.middle - p.aside * target.normal
    obstacles, body = np.concatenate((memory.obstacles, doors)), RobotSpec(radius=p.wide)
    way = plan_path(obstacles, left, right, params.navigation, body)
    if way is None:
        return True
    known = np.isin(cells_of(_spots(way, params), params.curiosity), seen).mean()
    length = float(np.hypot(*np.diff(way, axis=0).T).sum())
    if length > p.way_round or known < p.seen_share:
        return True
    return not _round_a_thing(way, target, memory.obstacles, seen, params)


def _round_a_thing(
    way: Points, target: Exit, obstacles: Points, seen: Cells, params: Params
) -> bool:
    """Whether a way (K, 2) from one side of an exit to the other leads round a thing, not walls.

    What stands inside the round is deep, where a piece of wall between two doors is thin; and
    nobody sees through it, where between walls there is free space.
    """
    p, ring = params.exits, shapely.make_valid(shapely.Polygon(way))
    inside = obstacles[shapely.contains_xy(ring, *obstacles.T)]
    if len(inside) < 3:
        return False
    depth = float(np.ptp((inside - target.middle) @ target.normal))
    hull = shapely.MultiPoint(inside).convex_hull
    low, high = inside.min(axis=0), inside.max(axis=0)
    axes = [np.arange(a, b, params.curiosity.cell / 2.0) for a, b in zip(low, high, strict=True)]
    spots = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    spots = spots[shapely.contains_xy(hull, *spots.T)]
    free = np.isin(cells_of(spots, params.curiosity), seen)
    return p.thing <= depth <= p.largest_thing and bool(free.mean() <= p.thing_free)


def _spots(way: Points, params: Params) -> Points:
    """Points along a way (K, 2), (P, 2)."""
    return sample_surfaces(np.stack((way[:-1], way[1:]), axis=1), params.curiosity.cell)
