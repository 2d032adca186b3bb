"""Many episodes of the thesis's experiments, each scored, each a row of a file that can be resumed.

A row is written as soon as its episode is over; a trial that has a row is not run again.
"""

from __future__ import annotations

import json
import multiprocessing
import signal
import textwrap
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from agents.base import Agent
from agents.cogmap.agent import CogMapAgent
from agents.cogmap.mfis import FORGOTTEN, MFIS
from agents.cogmap.params import Params
from agents.cogmap.places import links
from agents.rollout import Episode, run_episode
from cogmap_gym import OdometrySpec
from cogmap_gym.experiment_figures import overview_figure
from cogmap_gym.journey_scores import STAGES, score_journeys
from cogmap_gym.metrics import score
from cogmap_gym.observation import Observation
from cogmap_gym.run_record import Record, Step
from cogmap_gym.saving import save_png
from cogmap_gym.score_table import broken, reasons
from cogmap_gym.thesis_tasks import RING

Row = dict[str, Any]
"""What ``run`` returns, JSON-able."""
Watch = Callable[[Iterable[Row], int], Iterable[Row]]
"""Passes on rows as they come, such as to show the progress."""
TITLE_CHARS = 130
"""Longest line of a picture's title [characters]."""
TITLE_LINES = 5
"""Most reasons in it, a line each."""


@dataclass(frozen=True)
class Trial:
    """One episode to be run."""

    experiment: int
    odometry: str
    seed: int
    params: Params
    label: Mapping[str, Any] = field(default_factory=dict)
    """What else its row is known by."""
    pictures: Path | None = None
    """Folder for a picture of the run if it fails."""
    most_pictures: int = 0
    """No picture is added to a folder that holds as many."""

    def __post_init__(self) -> None:
        """Check the odometry.

        Raises:
            ValueError: there is no such level.
        """
        OdometrySpec.of(self.odometry)

    @property
    def key(self) -> Row:
        """What its row is known by."""
        head = {"experiment": self.experiment, "odometry": self.odometry, "seed": self.seed}
        return {**head, **self.label}


class Recorder:
    """Keeps what was true and what was believed at each step."""

    def __init__(self, env: gym.Env[Any, Any], agent: CogMapAgent) -> None:
        """Of an episode of this agent in this environment."""
        self.world = env.unwrapped.world  # type: ignore[attr-defined]
        self.agent = agent
        self.steps: list[Step] = []

    def __call__(
        self,
        _step: int,
        observation: Observation,
        _action: NDArray[np.float32],
        info: dict[str, Any],
        _agent: Agent,
    ) -> None:
        """Add a step; the values of the robot's memory are frozen, so none is copied."""
        memory = self.agent.memory
        mapping, stay, pose = memory.mapping, memory.stay, memory.pose
        self.steps.append(
            Step(
                phase=info["phase"],
                pose=info["pose"],
                shut=self.world.shut_doors,
                odometry=np.array(observation["odometry"], dtype=np.float64),
                mapped=memory.path[-1],
                believed=np.array((pose.x, pose.y, pose.theta)),
                seen=mapping.view.surfaces,
                names=mapping.ids,
                surfaces=_by_name(mapping.mfis, mapping.mfis.surfaces, np.nan),
                entered=_by_name(mapping.mfis, mapping.mfis.entered, False),
                tags=_by_name(mapping.mfis, mapping.mfis.asr, FORGOTTEN),
                place=stay.place,
                entry=stay.entry,
                began=stay.began,
                boundaries={asr.id: asr.boundary for asr in memory.network.asrs},
                links=tuple(links(memory.book)),
            )
        )


def _by_name(mfis: MFIS, values: NDArray[Any], missing: Any) -> NDArray[Any]:
    """A column of the MFIS in which the surface of name n stands in row n - 1."""
    if len(mfis) == mfis.last_id:
        return values
    out = np.full((mfis.last_id, *values.shape[1:]), missing, dtype=values.dtype)
    out[mfis.ids - 1] = values
    return out


def run(trial: Trial) -> Row:
    """One episode, scored; an episode that breaks down is a row too."""
    number, odometry = trial.experiment, trial.odometry
    env = gym.make("CogMap/Thesis-v0", experiment=number, odometry=odometry)
    agent = CogMapAgent(trial.params)
    recorder = Recorder(env, agent)
    try:
        episode = run_episode(env, agent, trial.seed, recorder)
    except Exception as error:  # noqa: BLE001 - a rate counts every run
        phase = recorder.steps[-1].phase if recorder.steps else 0
        stage = STAGES[phase] if number == 3 else ""
        failed = broken(number, f"raised {error!r}", stage)
        return {**trial.key, **failed, "raised": repr(error)}
    record = _record(env, agent, recorder, episode)
    row = {**trial.key, **score(record), **(score_journeys(record) if number == 3 else {})}
    if trial.pictures is not None and reasons(row):
        _draw(trial, row, env, agent, record)
    return row


def _record(
    env: gym.Env[Any, Any], agent: CogMapAgent, recorder: Recorder, episode: Episode
) -> Record:
    return Record(
        plan=env.unwrapped.plan,  # type: ignore[attr-defined]
        rooms=RING,
        steps=recorder.steps,
        edits=agent.edit_log,
        tasks=[phase["task"] for phase in episode.phases],
        successes=[phase["success"] for phase in episode.phases],
        final_distance=float(episode.info["final_distance"][1]),
    )


def _draw(
    trial: Trial, row: Row, env: gym.Env[Any, Any], agent: CogMapAgent, record: Record
) -> None:
    """Write the picture of a failed run, the truth beside the belief."""
    assert trial.pictures is not None, "a trial without a folder has no picture"
    trial.pictures.mkdir(parents=True, exist_ok=True)
    if len(list(trial.pictures.glob("*.png"))) >= trial.most_pictures:
        return
    why = [textwrap.shorten(reason, TITLE_CHARS) for reason in reasons(row)]
    why[TITLE_LINES:] = [f"and {len(why) - TITLE_LINES} more"] if len(why) > TITLE_LINES else []
    head = f"Experiment {trial.experiment}, {trial.odometry} odometry, seed {trial.seed}"
    home, shut = env.unwrapped.task.marks[1], record.steps[-1].shut  # type: ignore[attr-defined]
    belief = agent.sketch(), agent.memory.path[:, :2], home, "\n".join((head, *why))
    figure = overview_figure(record.plan, record.poses[:, :2], *belief, shut)
    name = f"exp{trial.experiment}_{trial.odometry}_{trial.seed}.png"
    save_png(figure, trial.pictures / name)


def read_rows(path: Path) -> list[Row]:
    """The rows written so far; a last line that was cut short does not count."""
    text = path.read_text() if path.exists() else ""
    return [json.loads(line) for line in text.splitlines() if line.endswith("}")]


def run_missing(trials: Iterable[Trial], workers: int, path: Path, watch: Watch) -> bool:
    """Run the trials that have no row in a file yet, and append a row of each as it comes in.

    Args:
        trials: all that are wanted.
        workers: how many processes of their own they run in.
        path: of the file.
        watch: passes on the rows, of which it is told the number, and may show how many came.

    Returns:
        False if Ctrl-C ended it; the rows so far are kept.
    """
    known = read_rows(path)
    left = [t for t in trials if not any(t.key.items() <= row.items() for row in known)]
    with closing(_run_all(left, workers, path)) as rows:
        try:
            for _ in watch(rows, len(left)):
                pass
        except KeyboardInterrupt:
            return False
    return True


def _run_all(trials: Sequence[Trial], workers: int, path: Path) -> Generator[Row, None, None]:
    """The workers do not take Ctrl-C; whoever stops asking for rows stops them."""
    if not trials:
        return
    ignore = (signal.SIGINT, signal.SIG_IGN)
    with multiprocessing.get_context("spawn").Pool(workers, signal.signal, ignore) as pool:
        for row in pool.imap_unordered(run, trials):
            with path.open("a") as file:
                file.write(f"\n{json.dumps(row)}")
            yield row


def seeds_of(text: str) -> range:
    """The seeds that ``FIRST:LAST`` names, without the last.

    Raises:
        ValueError: it is written otherwise, or names none.
    """
    first, _, last = text.partition(":")
    if not (first.isdigit() and last.isdigit() and int(first) < int(last)):
        raise ValueError(f"seeds: expected FIRST:LAST with FIRST < LAST, got {text!r}")
    return range(int(first), int(last))
