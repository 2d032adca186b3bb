"""Courses: what the episodes of a task consist of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.phases import Course, Itinerary, Phase
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


@dataclass(frozen=True, slots=True)
class Explore:
    """See all of the free space that can be reached; over once 95 % of it has been seen."""

    def check(self, plan: FloorPlan) -> None:
        """Any plan will do."""

    def most_moves(self, plan: FloorPlan) -> int:
        """200 and one for each square metre of free space."""
        return EXPLORE_MOVES + round(plan.area)

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


def home_moves(plan: FloorPlan) -> int:
    """The budget of a way home: 100 moves and one for each two square metres."""
    return HOME_MOVES + round(plan.area / 2.0)


def course_of(task: str, experiment: int | None) -> Course:
    """The course that the keywords of an environment ask for.

    Raises:
        ValueError: no such task or experiment, or an experiment for another task.
    """
    if task == "thesis":
        return Thesis(1 if experiment is None else experiment)
    if experiment is not None:
        raise ValueError(f"experiment: only the thesis task has one, got {experiment!r}")
    courses: dict[str, Course] = {"explore": Explore(), "home": GoHome()}
    if task not in courses:
        raise ValueError(f"task: expected one of {[*courses, 'thesis']}, got {task!r}")
    return courses[task]
