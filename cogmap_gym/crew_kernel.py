"""The compiled judgement of a step of many robots, in which nearly always nothing happens."""

from __future__ import annotations

import math
from typing import Any

from cogmap_gym import tasks, vector_tables
from cogmap_gym.kernel_parts import fingerprint, whole
from cogmap_gym.tasks import STEP_REWARD
from cogmap_gym.vector_tables import DECLARE, MOVE


def _kernel(sources: int) -> Any:
    """The judgement of one step."""

    def judge_steps(
        modes: Any, robots: Any, entered: Any, watched: Any, rewards: Any, asked: Any
    ) -> int:
        """Reward the robots, count what they saw, and find those whose task must be asked.

        Args:
            modes: (N,), what each robot did.
            robots: (N,), as the step left them.
            entered: (N, most + 1), how many rooms each entered, and which.
            watched: by robot, see ``Crew``; steps and cells seen are counted on.
            rewards: (N,), written; 0 for robots that neither moved nor declared.
            asked: (N,), written: first the rows of the robots whose task must be asked.

        Returns:
            How many rows were written to ``asked``.
        """
        seen, cells, goal, steps, most_steps, share, rooms, always = watched
        count = 0 * sources
        for i in range(len(modes)):
            rewards[i] = 0.0
            if modes[i] != MOVE and modes[i] != DECLARE:
                continue
            r = robots[i]
            seen[i] += r["new"]
            steps[i] += 1
            gain = r["new"] / cells[i]
            if goal[i] > 0:
                nearer = r["before_to_goal"] - r["to_goal"]
                gain = nearer if math.isfinite(nearer) else 0.0
            rewards[i] = STEP_REWARD + gain
            ask = always[i] or (rooms[i] and entered[i, 0] > 0) or r["marked"] > 0
            ask = ask or (goal[i] > 0 and modes[i] == DECLARE)
            if ask or steps[i] >= most_steps[i] or seen[i] / cells[i] >= share[i]:
                asked[count] = i
                count += 1
        return count

    return whole(judge_steps)


judge_steps = _kernel(fingerprint(tasks, vector_tables))
