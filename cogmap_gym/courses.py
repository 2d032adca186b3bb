"""Courses: what the episodes of a task consist of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogmap_gym.blocks import drawn_block
from cogmap_gym.chords import rooms_to_visit
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.observation import RobotSpec
from cogmap_gym.phases import MARK_GAP_M, Course, Itinerary, Phase
from cogmap_gym.thesis_tasks import Thesis

EXPLORED = 0.95
"""Share of the reachable free area that counts as all of it. DESIGN 3."""
EXPLORE_MOVES = 200
"""Moves granted for exploring any plan; one more for each square metre of free space."""
HOME_MOVES = 100
"""Moves granted for a way home on any plan; one more for each two square metres."""
SURVEY_SHARES = (0.3, 0.8)
"""Least and most share seen before the robot is called home, drawn uniformly. Ours."""
SURVEY_MOVES = 20
"""Fewest moves before the robot is called home; the most is this and a quarter of the area
in square metres, drawn uniformly. Ours."""

GOALS = (3, 5)
"""Fewest and most marks to go to, drawn uniformly; fewer where the plan has fewer rooms."""
DEARER = 0.25
"""Share of blocks whose chord is, where possible, no shorter than going back. Ours."""


@dataclass(frozen=True, slots=True)
class Explore:
    """See all of the free space that can be reached; over once 95 % of it has been seen."""

    def check(self, plan: FloorPlan) -> None:
        """Any plan will do."""

    def most_moves(self, plan: FloorPlan) -> int:
        """200 and one for each square metre of free space."""
        return _explore_moves(plan)

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:  # noqa: ARG002
        """One phase; nothing is drawn."""
        return Itinerary((Phase("explore", 0, coverage=EXPLORED),))


@dataclass(frozen=True, slots=True)
class GoHome:
    """Explore for a while that the robot cannot foresee, then come home.

    The call comes when a drawn share of the free space has been seen or a drawn number of
    moves is over, whichever is first.
    """

    def check(self, plan: FloorPlan) -> None:
        """Any plan will do."""

    def most_moves(self, plan: FloorPlan) -> int:
        """All that the two phases can take."""
        return SURVEY_MOVES + round(plan.area / 4.0) + home_moves(plan)

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:
        """Draw when the robot is called home."""
        share = float(rng.uniform(*SURVEY_SHARES))
        moves = int(rng.integers(SURVEY_MOVES, SURVEY_MOVES + round(plan.area / 4.0) + 1))
        survey = Phase("explore", 0, moves, budget_is_success=True, coverage=share)
        return Itinerary((survey, Phase("home", 1, home_moves(plan))))


@dataclass(frozen=True, slots=True)
class GoTo:
    """Explore, then go to marks in three to five rooms, in a drawn order.

    Exploring ends once 95 % has been seen and every drawn room has given its mark, or with
    its budget; neither is a failure. A room never visited gives no mark: its goal fails.
    """

    def check(self, plan: FloorPlan) -> None:
        """Check that there is a room to go to.

        Raises:
            ValueError: no room but that of home can be visited.
        """
        if not _rooms(plan):
            raise ValueError(
                f"GoTo: expected a plan with another room than that of home to visit, "
                f"1 m or more from its doors; {plan.name!r} has rooms {plan.room_names}"
            )

    def most_moves(self, plan: FloorPlan) -> int:
        """All that the phases can take."""
        return _explore_moves(plan) + GOALS[1] * home_moves(plan)

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:
        """Draw the rooms of the marks and the order of the goals."""
        mark_rooms, order = _drawn_marks(plan, rng)
        goals = (Phase(f"goto:{mark}", mark, home_moves(plan)) for mark in order)
        return Itinerary((_exploring(plan), *goals), mark_rooms)


@dataclass(frozen=True, slots=True)
class Shortcut:
    """Explore with the chords shut, then go to marks, a known door shut and a chord opened.

    A chord stays open once opened; a shut door opens again after its goal. See ``Block``.
    """

    unreachable: float = 0.0
    """Share of goals whose room is shut off altogether: "no route" is the right answer."""

    def __post_init__(self) -> None:
        """Check the share.

        Raises:
            ValueError: not between 0 and 1.
        """
        if not 0.0 <= self.unreachable <= 1.0:
            raise ValueError(f"unreachable: expected 0 to 1, got {self.unreachable!r}")

    def check(self, plan: FloorPlan) -> None:
        """Check that there are chords and a room to go to.

        Raises:
            ValueError: no door is shut at first, or no room can be visited.
        """
        GoTo().check(plan)
        if not plan.closed:
            raise ValueError(
                f"Shortcut: expected a plan with chords, doors named under 'closed'; "
                f"{plan.name!r} has none"
            )

    def most_moves(self, plan: FloorPlan) -> int:
        """All that the phases can take."""
        return GoTo().most_moves(plan)

    def itinerary(self, plan: FloorPlan, rng: np.random.Generator) -> Itinerary:
        """Draw the rooms of the marks, the order of the goals and the blocks."""
        mark_rooms, order = _drawn_marks(plan, rng)
        goals = (
            Phase(
                f"goto:{mark}",
                mark,
                home_moves(plan),
                hindrance=drawn_block(rng, DEARER, self.unreachable),
            )
            for mark in order
        )
        return Itinerary((_exploring(plan), *goals), mark_rooms)


def _rooms(plan: FloorPlan) -> tuple[str, ...]:
    """The rooms that can give a mark."""
    return rooms_to_visit(plan, RobotSpec().radius, MARK_GAP_M)


def _drawn_marks(plan: FloorPlan, rng: np.random.Generator) -> tuple[dict[int, str], list[int]]:
    """The rooms in which marks are given, and the order in which they are asked for."""
    rooms = rng.permutation(np.array(_rooms(plan))).tolist()
    rooms = rooms[: int(rng.integers(GOALS[0], GOALS[1] + 1))]
    marks = range(2, 2 + len(rooms))
    return dict(zip(marks, rooms, strict=True)), rng.permutation(np.array(marks)).tolist()


def _explore_moves(plan: FloorPlan) -> int:
    """200 moves and one for each square metre of free space."""
    return EXPLORE_MOVES + round(plan.area)


def _exploring(plan: FloorPlan) -> Phase:
    """Explore all, and every room in which a mark is to be given."""
    budget = _explore_moves(plan)
    return Phase("explore", 0, budget, budget_is_success=True, coverage=EXPLORED, all_marks=True)


def home_moves(plan: FloorPlan) -> int:
    """The budget of a way home: 100 moves and one for each two square metres."""
    return HOME_MOVES + round(plan.area / 2.0)


def course_of(task: str, experiment: int | None, unreachable: float = 0.0) -> Course:
    """The course that the keywords of an environment ask for.

    Raises:
        ValueError: no such task or experiment, or a keyword of another task.
    """
    if unreachable and task != "shortcut":
        raise ValueError(f"unreachable: only the shortcut task has it, got {unreachable!r}")
    if task == "thesis":
        return Thesis(1 if experiment is None else experiment)
    if experiment is not None:
        raise ValueError(f"experiment: only the thesis task has one, got {experiment!r}")
    courses: dict[str, Course] = {
        "explore": Explore(),
        "home": GoHome(),
        "goto": GoTo(),
        "shortcut": Shortcut(unreachable),
    }
    if task not in courses:
        raise ValueError(f"task: expected one of {[*courses, 'thesis']}, got {task!r}")
    return courses[task]
