"""Films of an episode: some of its phases, by Gymnasium's ``RecordVideo``.

``RecordVideo`` needs MoviePy: the ``film`` extra.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
from gymnasium.error import DependencyNotInstalled
from gymnasium.wrappers import RecordVideo

from cogmap_gym.observation import Observation
from cogmap_gym.render import Frame, Scene, draw

SIZE = (720, 1440)
"""Height and width of a frame [pixels]; a film in common formats needs even numbers."""
FRAMES_PER_SECOND = 4
"""A frame shows one move: slow enough to follow."""
NAME = "film"


class Moments(gym.Wrapper[Observation, Any, Observation, Any]):
    """Renders the moment of the last decision, when truth and belief were of one time.

    ``RecordVideo`` asks for a frame once the world has moved; what the agent told by
    ``set_sketch`` is then one observation old. The path shown is that of the phase.

    Args:
        env: a CogMap environment.
        phases: which to draw, from 1; nothing is drawn in others.
        size: height and width of a frame [pixels].
    """

    def __init__(
        self,
        env: gym.Env[Observation, Any],
        phases: Collection[int],
        size: tuple[int, int] = SIZE,
    ) -> None:
        """No phase has begun yet."""
        super().__init__(env)
        self.phases, self.size = frozenset(phases), size
        self.phase, self._begun = 1, 0
        self._frame: Frame | None = None

    @property
    def wanted(self) -> bool:
        """Whether the present phase is drawn."""
        return self.phase in self.phases

    def reset(self, **keywords: Any) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode."""
        self.phase, self._begun, self._frame = 1, 0, None
        return super().reset(**keywords)

    def step(self, action: Any) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Draw the moment if wanted, then move."""
        self._frame = self._draw() if self.wanted else None
        result = super().step(action)
        phase = result[-1]["phase"] + 1
        if phase != self.phase:
            self.phase, self._begun = phase, len(self._scene().path) - 1
        return result

    def render(self) -> Any:
        """The moment of the last decision; before the first one, the present."""
        return self._draw() if self._frame is None else self._frame

    def _scene(self) -> Scene:
        scene: Scene = self.get_wrapper_attr("scene")()
        return scene

    def _draw(self) -> Frame:
        scene = self._scene()
        return draw(replace(scene, path=scene.path[self._begun :]), self.size)


class Film(RecordVideo[Observation, Any]):
    """Records some phases of one episode into a film ``folder/film.mp4``, written by ``close``.

    Args:
        env: a CogMap environment with ``render_mode="rgb_array"``.
        folder: where the film goes; it is written whole.
        phases: which to record, from 1.

    Raises:
        ValueError: MoviePy is absent.
    """

    def __init__(
        self, env: gym.Env[Observation, Any], folder: Path, phases: Collection[int]
    ) -> None:
        """Record nothing yet."""
        self.moments, self.path = Moments(env, phases), folder / f"{NAME}.mp4"
        part = folder / f".{NAME}"
        shutil.rmtree(part, ignore_errors=True)
        try:
            super().__init__(
                self.moments, str(part), step_trigger=lambda _: False, fps=FRAMES_PER_SECOND
            )
        except DependencyNotInstalled as error:
            part.rmdir()
            raise ValueError("film: expected MoviePy: pip install 'cogmap-gym[film]'") from error

    def step(self, action: Any) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Move, and record the moment before if its phase is to be recorded."""
        self.recording = self.moments.wanted
        return super().step(action)

    def close(self) -> None:
        """Write the film if there is anything on it; closing twice is fine."""
        self.recording, self._video_name = bool(self.recorded_frames), NAME
        super().close()  # type: ignore[no-untyped-call]
        part = Path(self.video_folder)
        if (part / self.path.name).exists():
            (part / self.path.name).replace(self.path)
        shutil.rmtree(part, ignore_errors=True)
