"""Exits: remembered doorways, in the MFIS, and the moment one is crossed (thesis 3.3, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from agents.cogmap.params import Exits
from cogmap_gym.geometry import NO_SEGMENTS, Points, Pose, Segments, cross

NOWHERE = 0
"""The id of no ASR."""


@dataclass(frozen=True, slots=True, eq=False)
class Exit:
    """A doorway with an identity; a line from jamb to jamb in the MFIS."""

    id: int
    line: Segments
    """(2, 2) in the MFIS."""
    left: int
    """The ASR on the left of the line, or 0."""
    right: int
    """The ASR on the right of the line, or 0."""
    sightings: int
    """In how many views it was seen."""
    crossed: int
    """Step of the last crossing, or -1."""
    failures: int = 0
    """How often the robot gave up reaching it since it was last crossed."""
    given_up: int = -1
    """Step at which the robot last gave up reaching it, -1 once it is seen open or crossed."""
    seam: bool = False
    """Whether the parts of the MFIS on its two sides drifted apart on the way round."""
    seen: int = -1
    """Step at which it was last seen open, or -1."""
    false: bool = False
    """Whether it turned out to part nothing: one place lies on both of its sides."""

    @property
    def middle(self) -> Points:
        """(2,)."""
        return np.asarray(0.5 * (self.line[0] + self.line[1]))

    @property
    def normal(self) -> Points:
        """(2,): unit vector to the left."""
        d = self.line[1] - self.line[0]
        return np.asarray(np.array((-d[1], d[0])) / np.hypot(d[0], d[1]))

    def side_of(self, asr: int) -> int:
        """1 if the ASR lies on the left, -1 if on the right, 0 if neither is known."""
        return 1 if asr == self.left else -1 if asr == self.right else 0

    def beyond(self, asr: int) -> int:
        """The ASR on the other side, or 0."""
        return self.right if asr == self.left else self.left

    def trusted(self, params: Exits) -> bool:
        """Whether it counts: seen often enough or crossed, and between two places."""
        known = self.sightings >= params.min_sightings or self.crossed >= 0
        return known and self.left != self.right and not self.false


Book = tuple[Exit, ...]
"""All exits; the one with id i stands at i - 1."""


def remember_exits(
    book: Book, found: Segments, here: int, mfis_from_robot: Pose, step: int, params: Exits
) -> Book:
    """Note the exits of a view: known ones are seen again, others enter the book.

    Args:
        book: exits so far.
        found: (E, 2, 2) exits of the view in the MFIS, the robot's space on their left.
        here: the ASR the robot is in.
        mfis_from_robot: where the robot is.
        step: now.
        params: thresholds.
    """
    robot = mfis_from_robot.position
    for line in found:
        middle = 0.5 * (line[0] + line[1])
        if _through_another(book, robot, middle, params):
            continue
        known = match_exit(book, line, params)
        if known is None:
            book = (*book, Exit(len(book) + 1, line, here, NOWHERE, 1, -1, seen=step))
        else:
            again = _seen_again(known, line, here, robot, params)
            book = replace_exit(book, replace(again, seen=step))
    return book


def in_doorway(book: Book, robot: Points, params: Exits) -> bool:
    """Whether the robot (2,) stands in an exit, where it sees two places at once."""
    for e in book:
        d = e.line[1] - e.line[0]
        along = abs(float((robot - e.middle) @ d)) / float(d @ d)
        beside = abs(float((robot - e.middle) @ e.normal))
        if e.trusted(params) and along < 0.5 and beside < params.doorway:
            return True
    return False


def remember_passages(book: Book, lines: Segments, here: int, params: Exits) -> Book:
    """Make exits of doorways (K, 2, 2) in the MFIS that were gone through from ASR ``here``."""
    for line in lines:
        known = match_exit(book, line, params)
        if known is None:
            book = (*book, Exit(len(book) + 1, line, here, NOWHERE, params.min_sightings, -1))
        elif not known.trusted(params) and known.side_of(here) != 0:
            book = replace_exit(book, replace(known, sightings=params.min_sightings))
    return book


def match_exit(book: Book, line: Segments, params: Exits) -> Exit | None:
    """The known exit that this line (2, 2) in the MFIS shows again, if there is one."""
    d = line[1] - line[0]
    best, least = None, params.same_distance
    for known in _about(book, line, 2.0 * params.same_distance):
        e = known.line[1] - known.line[0]
        turn = abs(float(cross(d, e))) / float(np.hypot(*d) * np.hypot(*e))
        gap = float(np.hypot(*(known.middle - 0.5 * (line[0] + line[1]))))
        if gap < least and turn < params.same_turn:
            best, least = known, gap
    return best


def seen_exits(book: Book) -> Book:
    """The exits that were seen and did not turn out to part nothing."""
    return tuple(e for e in book if e.sightings and not e.false)


def exit_lines(book: Book) -> Segments:
    """The lines of the exits, (E, 2, 2)."""
    return np.array([e.line for e in book]) if book else NO_SEGMENTS


def _about(book: Book, points: Points, reach: float) -> list[Exit]:
    """The exits whose bounds come within ``reach`` of those of some points (P, 2).

    However many exits are known, only these are looked at closely.
    """
    lines = exit_lines(book)
    a, b = lines[:, 0], lines[:, 1]
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    near = (np.maximum(a, b) >= low).all(axis=1) & (np.minimum(a, b) <= high).all(axis=1)
    return [book[k] for k in np.flatnonzero(near)]


def replace_exit(book: Book, changed: Exit) -> Book:
    """The book with one exit changed."""
    return (*book[: changed.id - 1], changed, *book[changed.id :])


def give_up_exit(book: Book, exit_id: int, step: int, times: int) -> Book:
    """The book with this exit given up, as after so many failures."""
    known = book[exit_id - 1]
    return replace_exit(book, replace(known, failures=known.failures + times, given_up=step))


def try_again(book: Book, place: int) -> Book:
    """The book with no failures held against the exits of a place that were crossed before."""
    return tuple(
        replace(e, failures=0)
        if e.failures and e.crossed >= 0 and place in (e.left, e.right)
        else e
        for e in book
    )


def rename_place(book: Book, old: int, new: int) -> Book:
    """The book with one ASR known by another id."""
    return tuple(
        replace(e, left=new if e.left == old else e.left, right=new if e.right == old else e.right)
        for e in book
    )


def crossed_exit(book: Book, path: Points, params: Exits) -> Exit | None:
    """The exit that the path of this stay has gone through for good, if any.

    Crossing takes two phases: the path meets the line an odd number of times, and the robot is
    well beyond it (FINDINGS 2: 144 of 144 crossings noticed).

    Args:
        book: all exits.
        path: (P, 2) in the MFIS, from the entry to the present position.
        params: thresholds.
    """
    if len(path) < 2:
        return None
    last: tuple[float, Exit] | None = None
    for known in _about(book, path, 2.0 * params.slack):
        if known.sightings < 1 or known.left == known.right or known.false:
            continue
        distance = float((path[-1] - known.middle) @ known.normal)
        if abs(distance) < params.beyond:
            continue
        # One seen only once counts if the path goes through it between its ends.
        slack = params.slack if known.trusted(params) else 0.0
        meetings = _meetings(path, known, slack)
        if len(meetings) % 2 == 1 and (last is None or meetings[-1] > last[0]):
            last = (float(meetings[-1]), known)
    return last[1] if last else None


def _meetings(path: Points, known: Exit, slack: float) -> Points:
    """Where the path crosses the exit's line, in rows and parts of the piece that follows, (K,)."""
    side = (path - known.middle) @ known.normal
    d = known.line[1] - known.line[0]
    width = float(np.hypot(*d))
    along = (path - known.line[0]) @ d / width
    rows = np.flatnonzero((side[:-1] < 0.0) != (side[1:] < 0.0))
    t = side[rows] / (side[rows] - side[rows + 1])
    at = along[rows] + t * (along[rows + 1] - along[rows])
    return np.asarray((rows + t)[(at > -slack) & (at < width + slack)])


def _through_another(book: Book, robot: Points, middle: Points, params: Exits) -> bool:
    """Whether the sight from the robot to ``middle`` goes through a trusted exit."""
    sight = np.stack((robot, middle))
    return any(
        e.trusted(params)
        and float(np.hypot(*(e.middle - middle))) > params.same_distance
        and float(np.hypot(*(e.middle - robot))) > params.beyond
        and len(_meetings(sight, e, params.slack)) > 0
        for e in _about(book, sight, 2.0 * params.slack)
    )


def _seen_again(known: Exit, line: Segments, here: int, robot: Points, params: Exits) -> Exit:
    """A known exit with its line and sides brought up to date by a new sighting."""
    same = float((line[1] - line[0]) @ (known.line[1] - known.line[0])) > 0.0
    directed = line if same else line[::-1]
    near = float(np.hypot(*(0.5 * (line[0] + line[1]) - robot))) < params.near
    share = params.near_share if near else params.far_share
    blended = (1.0 - share) * known.line + share * directed
    left, right = known.left, known.right
    if known.crossed < 0 or NOWHERE in (left, right):
        left, right = (here, right) if same else (left, here)
        if known.crossed >= 0 and left == right:
            left, right = known.left, known.right
    return replace(known, line=blended, left=left, right=right, sightings=known.sightings + 1)
