"""A thread that helps with work that the calling thread could also do alone."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

Work = tuple[Callable[..., object], tuple[Any, ...]]


class Helper:
    """A thread that runs what it is given, as soon as it wakes up.

    It is told that there is work, not waited for: whoever needs the work done must see to it.
    """

    def __init__(self) -> None:
        """Start the thread; it ends when this object is dropped."""
        self._tasks: SimpleQueue[Work | None] = SimpleQueue()
        self._thread = threading.Thread(target=_serve, args=(self._tasks,), daemon=True)
        self._thread.start()
        weakref.finalize(self, self._tasks.put, None)

    def tell(self, function: Callable[..., object], *arguments: Any) -> None:
        """Have the function called."""
        self._tasks.put((function, arguments))

    @property
    def alive(self) -> bool:
        """Whether no work has failed."""
        return self._thread.is_alive()


def _serve(tasks: SimpleQueue[Work | None]) -> None:
    """Run what comes, until None."""
    while (work := tasks.get()) is not None:
        work[0](*work[1])
        del work
