"""Every number of the frontier robot, with its unit and its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Grid:
    """The occupancy grid."""

    cell: float = 0.05
    """Side of a cell [m]: a doorway of 0.8 m leaves the centre of the robot 6 cells."""
    reach: float = 16.0
    """Beams are entered up to here [m]; they are too far apart beyond."""
    margin: float = 0.05
    """A cell is free if all beams through it end at least this far behind it [m]: 4 sds."""
    body: float = 0.2
    """What is under the robot is free up to here from its centre [m]."""
    near: float = 1.0
    """What is seen from nearer than this has been visited [m]."""
    grow: float = 10.0
    """By how much the grid grows at a side where it is too small [m]."""
    occupied: int = 2
    """What a hit makes of a cell; each view through it takes one off [votes]. So a shut door is
    noticed at once, and an open one after two views."""
    free: int = 3
    """Most votes for being free [votes]."""


@dataclass(frozen=True, slots=True)
class Planner:
    """Ways over the grid."""

    wall: float = 0.10
    """Nearer to an occupied cell than this is no way at all [m]."""
    body: float = 0.28
    """Nearer than this the body may not fit [m]: its radius and half a cell. The laser decides
    on the spot; until then such a cell costs ``tight``."""
    comfort: float = 0.60
    """Nearer than this a way costs more, so that it keeps to the middle of doorways [m]."""
    crowded: float = 4.0
    """Cost of a cell at ``body``, as a multiple of one in the open [1]."""
    tight: float = 20.0
    """Cost of a cell in which the body may not fit [1]."""
    unknown: float = 4.0
    """Cost of a cell never seen, where ways may lead through such [1]."""
    off_wall: float = 0.15
    """An unknown cell nearer to an occupied one belongs to the wall and is no frontier [m]."""
    fewest: int = 8
    """Unknown cells off walls among the 25 about a frontier; fewer are a speckle [cells]."""
    ignored: float = 0.3
    """A frontier looked at in vain is ignored with all about it up to here [m]."""
    bar: float = 0.15
    """Where a way proved to be none, this much of it is barred [m]."""
    barred: int = 60
    """For so long [steps]."""
    beside: float = 0.15
    """A wall is seen from the free cells up to here from it [m]."""
    behind: float = 0.5
    """A door may open in a wall with known free space up to here behind it [m]."""
    unvisited: tuple[float, ...] = (1.0, 0.5, 0.0)
    """Once all is known, spots farther than this from all visited ones come first [m]."""
    fresh: int = 40
    """A map that drifts away is good for so long: when it leaves nothing to do, older parts of
    it are forgotten [steps]."""
    patience: int = 140
    """A way to a mark is searched for so long, then there is none [steps]."""
    replan: int = 4
    """Steps after which a way is looked for anew even if nothing is in it [steps]."""


@dataclass(frozen=True, slots=True)
class Driver:
    """From a way to moves."""

    clearance: float = 0.02
    """Kept between the body and what the laser sees [m]."""
    stop: float = 0.05
    """A drive shorter than this is none: the way is blocked [m]."""
    stride: float = 1.5
    """Longest drive towards the unknown: often less is enough to see it [m]."""
    reached: float = 0.12
    """A spot as near as this is reached [m]."""
    nearly: float = 0.7
    """A mark as near as this is declared if the way is blocked [m]."""
    arrived: float = 0.2
    """A mark as near as this is declared [m]."""


@dataclass(frozen=True, slots=True)
class Matching:
    """Point-to-line ICP with odometry as a prior."""

    support: float = 0.25
    """Length of wall over which the normal of a point is fitted [m]."""
    flat: float = 0.03
    """Largest deviation from a line of what has a normal [m]: over two sds."""
    gap: float = 0.6
    """Neighbouring points farther apart are on different surfaces [m]."""
    spacing: float = 0.05
    """Points nearer to one another than this count once [m]."""
    gates: tuple[float, ...] = (1.0, 1.0, 0.7, 0.5, 0.35, 0.25, 0.25, 0.25, 0.25, 0.25)
    """How far apart matching points may be, iteration by iteration [m]."""
    alike: float = math.cos(math.radians(35.0))
    """Least cosine between the normals of matching points [1]."""
    scale: float = 0.05
    """Distances to the line beyond this weigh less and less (Cauchy) [m]."""
    sd: float = 0.05
    """What a match is worth [m]: ten times the laser's variance, since errors go together."""
    still: float = 1e-4
    """A correction smaller than this ends the iterations [m, rad]."""
    good: float = 0.6
    """Share of the points that must match; with fewer other headings are tried, too [1]."""
    near: float = 0.1
    """A point matches if it ends as near to the line as this [m]."""
    headings: tuple[float, ...] = tuple(math.radians(a) for a in (-12, -8, -4, 4, 8, 12))
    """Headings tried beside the one that odometry tells [rad]."""
    position_sd: tuple[float, float] = (0.01, 0.05)
    """Odometry's standard deviation: constant, and a part of the drive [m, 1]."""
    heading_sd: tuple[float, float, float] = (math.radians(0.2), 0.08, math.radians(1.0))
    """The same for the heading: constant, a part of the turn, and for each metre [rad, 1, rad]."""


@dataclass(frozen=True, slots=True)
class Keys:
    """Key scans, the map of scan matching."""

    distance: float = 0.8
    """A new key scan is kept this far from all of the window [m]."""
    turn: float = math.radians(40.0)
    """Or turned by this much [rad]."""
    window: int = 14
    """How many key scans a scan is matched with, those used last [1]."""


@dataclass(frozen=True, slots=True)
class Loops:
    """Loop closing."""

    near: float = 3.0
    """Old key scans up to here are looked at [m]."""
    drift: float = 0.02
    """And farther by this for each metre driven since [1]."""
    most: float = 6.0
    """But never beyond here [m]."""
    scans: int = 10
    """How many old key scans a scan is matched with [1]."""
    good: float = 0.7
    """Share of the points that must match [1]."""
    shift: tuple[float, float] = (0.3, 0.03)
    """Largest correction: constant, and for each metre driven since [m, 1]."""
    turn: tuple[float, float] = (math.radians(3.0), math.radians(0.2))
    """The same for the heading [rad, rad]."""
    floor: tuple[float, float] = (0.01, math.radians(0.1))
    """Least standard deviation of a measured edge of the graph [m, rad]."""
    rebuild: tuple[float, float] = (0.05, math.radians(0.5))
    """The grid is made anew once a pose has moved by this much [m, rad]."""


@dataclass(frozen=True, slots=True)
class Params:
    """All of them."""

    grid: Grid = field(default_factory=Grid)
    planner: Planner = field(default_factory=Planner)
    driver: Driver = field(default_factory=Driver)
    matching: Matching = field(default_factory=Matching)
    keys: Keys = field(default_factory=Keys)
    loops: Loops = field(default_factory=Loops)
