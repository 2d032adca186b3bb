"""A new place that hangs together with a known one by free space is that one (thesis 4.2.2).

A corridor seen in part, and entered again at its other end, shows nothing of what was seen before
at first. But exits bound a place: where the space seen free from a new place goes on into a known
place, as wide as no exit is, the two are one.
"""

from __future__ import annotations

import numpy as np
import shapely

from agents.cogmap.asr import ASR
from agents.cogmap.association import Beams, Hypothesis, best_hypothesis
from agents.cogmap.exits import exit_lines, seen_exits
from agents.cogmap.free_space import Cells, cells_of, middles_of
from agents.cogmap.memory import Memory
from agents.cogmap.mfis import UNTAGGED
from agents.cogmap.navigator import plan_path, sample_surfaces
from agents.cogmap.params import Params
from agents.cogmap.places import within
from cogmap_gym.geometry import Points
from cogmap_gym.observation import RobotSpec


def hangs_together(memory: Memory, asr: ASR, beams: Beams, params: Params) -> Hypothesis | None:
    """Whether the present, unknown place is a part of a known one, and how the robot has drifted.

    Args:
        memory: in a place not known.
        asr: the known place, closed.
        beams: what was seen last in the present place.
        params: all thresholds.
    """
    p, seen, path = params.union, memory.stay.leads.seen, _off_doors(memory, params)
    spots = middles_of(seen, params.curiosity)
    spots = spots[within(asr, spots, p.depth)]
    if not len(path) or len(spots) * params.curiosity.cell**2 < p.min_area:
        return None
    gaps = np.hypot(*(spots[:, None] - path[None]).transpose(2, 0, 1))
    goal, start = np.unravel_index(int(gaps.argmin()), gaps.shape)
    if not _one_space(memory, path[start], spots[goal], asr, seen, params):
        return None
    return _agreeing(memory, asr, beams, params)


def _agreeing(memory: Memory, asr: ASR, beams: Beams, params: Params) -> Hypothesis | None:
    """How beams that end in or at the known place end on its surfaces, if they do."""
    p = params.union
    near = shapely.Polygon(asr.boundary).buffer(p.depth)
    shapely.prepare(near)
    into = shapely.contains_xy(near, beams.ends[:, 0], beams.ends[:, 1])
    if np.count_nonzero(into) < p.min_beams:
        return None
    mfis = memory.mapping.mfis
    walls, since = mfis.surfaces[mfis.asr == asr.id], memory.since_left(asr.id)
    entering = Beams(beams.origins[into], beams.ends[into])
    found = best_hypothesis(asr.id, walls, entering, since, params.association)
    agrees = found.coverage >= p.min_agreeing and found.contradiction <= p.max_through
    return found if agrees else None


def _off_doors(memory: Memory, params: Params) -> Points:
    """The spots of this stay that are clear of all exits, (P, 2)."""
    path = memory.stay.path[:-1]  # the last one may lie beyond an exit
    doors = exit_lines(seen_exits(memory.book)).mean(axis=1)
    gaps = np.hypot(*(path[:, None] - doors[None]).transpose(2, 0, 1))
    return np.asarray(path[gaps.min(axis=1, initial=np.inf) >= params.union.off_door])


def _one_space(
    memory: Memory, start: Points, goal: Points, asr: ASR, seen: Cells, params: Params
) -> bool:
    """Whether a body wider than any exit gets from one spot (2,) to the other, over seen space."""
    p, mfis = params.union, memory.mapping.mfis
    walls = mfis.surfaces[np.isin(mfis.asr, (UNTAGGED, asr.id))]
    walls = np.concatenate((walls, exit_lines(seen_exits(memory.book))))
    solid = sample_surfaces(walls, params.navigation.cell)
    obstacles = np.concatenate((memory.obstacles, solid))
    way = plan_path(obstacles, start, goal, params.navigation, RobotSpec(radius=p.passage / 2.0))
    if way is None or not within(asr, way[-1:], 0.0)[0]:
        return False
    pieces = np.stack((way[:-1], way[1:]), axis=1)
    spots = sample_surfaces(pieces, params.curiosity.cell)
    return bool(np.isin(cells_of(spots, params.curiosity), seen).mean() >= p.seen_share)
