"""A window to watch an episode in, drawn by pygame: truth at the left, belief at the right.

It shows the same ``Scene`` as ``render.draw`` does, in a few milliseconds a frame. Pygame is
imported when the first frame is painted, so that training without a window never loads it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cogmap_gym.render import Scene

if TYPE_CHECKING:
    import pygame

    from cogmap_gym.screen_painter import Painter

SIZE = (1280, 720)
"""Width and height of a window [pixels]."""


class Window:
    """Shows scenes on the screen; opened by the first one.

    A person may close it: nothing is shown from then on, and the episode goes on. Pygame has
    one display a process, which all windows share.

    Args:
        title: of the window.
        frames_per_second: the pace that ``show`` keeps to.
        size: width and height [pixels].
    """

    def __init__(
        self,
        title: str = "cogmap_gym",
        frames_per_second: float = 10.0,
        size: tuple[int, int] = SIZE,
    ) -> None:
        self.title, self.frames_per_second, self.size = title, frames_per_second, size
        self.surface: pygame.Surface | None = None
        """What is on the screen; None while no window is open."""
        self._painter: Painter | None = None
        self._clock: pygame.time.Clock | None = None
        self._closed_by_person = False

    def show(self, scene: Scene, notes: Sequence[str] = (), *, wait: bool = True) -> None:
        """Show a scene, with some lines of text below it, and keep to the pace.

        Args:
            scene: what to show.
            notes: lines of text under the picture.
            wait: whether to keep to the pace.
        """
        if self._closed_by_person:
            return
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        import pygame

        if self.surface is None or pygame.display.get_surface() is not self.surface:
            self._open()  # also where another window, which shares the display, was closed
        assert self.surface is not None, "a window was opened"
        assert self._painter is not None, "a painter comes with the window"
        self._painter.paint(self.surface, scene, notes)
        pygame.display.flip()
        pygame.event.pump()
        if wait and self._clock is not None:
            self._clock.tick(self.frames_per_second)
        if pygame.event.peek(pygame.QUIT):
            self.close()
            self._closed_by_person = True

    def close(self) -> None:
        """Close the window; closing twice is fine."""
        if self.surface is not None:
            import pygame

            pygame.display.quit()
            self.surface = self._painter = self._clock = None

    def _open(self) -> None:
        import pygame

        from cogmap_gym.screen_painter import Painter

        pygame.display.init()
        pygame.display.set_caption(self.title)
        self.surface = pygame.display.set_mode(self.size)
        self._painter, self._clock = Painter(), pygame.time.Clock()

    def __getstate__(self) -> dict[str, Any]:
        """A copy of a window is one that is not open yet."""
        return {**self.__dict__, "surface": None, "_painter": None, "_clock": None}
