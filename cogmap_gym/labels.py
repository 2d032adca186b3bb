"""Names on a drawing, placed where they can be read.

A label is tried at a few places beside what it names and left out where each of them
would cover another label. The choice is made when the drawing is rendered, so it holds
at every size and after the axes have grown.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.text import Text
from numpy.typing import NDArray

from cogmap_gym.geometry import NO_SEGMENTS

Pixels = NDArray[np.float64]

GAP_PT = 1.5
"""Space left between a label and what it names, and between two labels [pt]."""
PLACES = (0.5, 0.3, 0.7, 0.12, 0.88)
"""Where along a line a label is tried, in this order."""
SIDES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Where a point's label is tried if it cannot sit upon the point."""
LINE_STEP_PT = 4.0
"""Lines are avoided as points at most this far apart [pt]."""
ZORDER = 20.0
"""Labels are drawn above everything else."""


@dataclass(frozen=True, eq=False)
class _Label:
    text: Text
    line: NDArray[np.float64]
    """(2, 2), metres; both ends alike for a label that sits upon its point."""
    clear: float
    """Extra space kept from the line [pt]."""
    fixed: bool
    """Only one place will do."""


@dataclass
class _Boxes:
    """Rectangles that are taken, rows (left, bottom, right, top) in pixels."""

    rows: list[Pixels] = field(default_factory=list)

    def overlap(self, box: Pixels) -> bool:
        if not self.rows:
            return False
        rows = np.array(self.rows)
        apart = (rows[:, :2] >= box[2:]).any(1) | (rows[:, 2:] <= box[:2]).any(1)
        return not apart.all()


class Labels(Artist):
    """All labels of one axes; earlier ones have the first choice of place."""

    def __init__(self) -> None:
        super().__init__()
        self.set_zorder(ZORDER)
        self.set_in_layout(False)
        self._labels: list[_Label] = []
        self._lines = [NO_SEGMENTS]

    def add(
        self,
        name: str,
        line: NDArray[np.float64],
        *,
        size: float,
        color: str,
        clear: float = 0.0,
        fixed: bool = False,
    ) -> None:
        """Name a line, or a point (a line whose ends are alike).

        Args:
            name: what to write.
            line: (2, 2), metres, in the frame of the axes.
            size: of the letters [pt].
            color: of the letters.
            clear: extra space kept between a line and its name [pt].
            fixed: a point's name stays upon the point, whatever it crosses.
        """
        on_point = bool(np.array_equal(line[0], line[1]))
        text = Text(0, 0, name, color=color, fontsize=size, ha="center", va="center_baseline")
        text.set_fontweight("bold" if on_point else "normal")
        self._labels.append(_Label(text, np.asarray(line, dtype=np.float64), clear, fixed))

    def avoid(self, lines: NDArray[np.float64]) -> None:
        """Rather not write across these lines (N, 2, 2), metres."""
        self._lines.append(np.asarray(lines, dtype=np.float64).reshape(-1, 2, 2))

    def draw(self, renderer: RendererBase) -> None:
        """Place and draw every label that finds room."""
        if self.axes is None or not self.get_visible():
            return
        taken = _Boxes()
        pixels_per_pt = float(np.asarray(renderer.points_to_pixels(1.0)))
        ink = self._ink(LINE_STEP_PT * pixels_per_pt)
        for label in self._labels:
            label.text.set_figure(self.axes.figure)
            label.text.set_position((0.0, 0.0))
            extent = label.text.get_window_extent(renderer)
            half = np.array((extent.width, extent.height)) / 2.0
            gap = (GAP_PT + label.clear) * pixels_per_pt
            place = self._place(label, half, gap, taken, ink)
            if place is not None:
                kept = half + GAP_PT * pixels_per_pt
                taken.rows.append(np.concatenate((place - kept, place + kept)))
                label.text.set_position((float(place[0]), float(place[1])))
                label.text.draw(renderer)

    def _place(
        self, label: _Label, half: Pixels, gap: float, taken: _Boxes, ink: Pixels
    ) -> Pixels | None:
        second = None
        window = np.reshape(self.axes.bbox.extents, (2, 2)) if self.axes is not None else None
        for place in self._candidates(label, half, gap):
            box = np.concatenate((place - half, place + half))
            outside = window is not None and bool(
                (box[:2] < window[0]).any() or (box[2:] > window[1]).any()
            )
            if outside or taken.overlap(box):
                continue
            if not ((ink > box[:2]) & (ink < box[2:])).all(1).any():
                return place
            second = place if second is None else second
        return second

    def _candidates(self, label: _Label, half: Pixels, gap: float) -> Iterator[Pixels]:
        start, end = self._pixels(label.line)
        length = float(np.hypot(*(end - start)))
        if length == 0.0:
            yield start
            for turn in () if label.fixed else SIDES:
                yield start + np.array(turn) * (2.0 * half + gap)
            return
        along = (end - start) / length
        left = np.array((-along[1], along[0]))
        aside, past = left * (np.abs(left) @ half + gap), along * (np.abs(along) @ half + gap)
        for part in PLACES:
            for side in (aside, -aside):
                yield start + part * (end - start) + side
        for place in (end + past, start - past):
            for side in (aside, -aside):
                yield place + side

    def _pixels(self, points: NDArray[np.float64]) -> Pixels:
        assert self.axes is not None, "labels are placed on axes"
        return np.asarray(self.axes.transData.transform(points.reshape(-1, 2)))

    def _ink(self, step: float) -> Pixels:
        """Points (P, 2) in pixels, at most a step apart, that stand for the lines to avoid."""
        lines = self._pixels(np.concatenate(self._lines)).reshape(-1, 2, 2)
        longest = np.hypot(*(lines[:, 1] - lines[:, 0]).T).max(initial=0.0)
        count = 2 + int(longest / step)
        parts = np.linspace(0.0, 1.0, count)[:, None]
        start, end = lines[:, None, 0], lines[:, None, 1]
        return np.asarray(start + parts * (end - start)).reshape(-1, 2)


def labels_of(ax: Axes) -> Labels:
    """The labels of these axes, made when first asked for."""
    for artist in ax.artists:
        if isinstance(artist, Labels):
            return artist
    labels = Labels()
    ax.add_artist(labels)
    return labels
