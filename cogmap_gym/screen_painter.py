"""Paints a scene on a pygame surface. Imported by ``screen`` when a window opens."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pygame
from shapely.geometry import Polygon

from cogmap_gym import colors
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Points, Pose
from cogmap_gym.render import MARGIN, ROBOT_RADIUS_M, Scene

PAPER = "white"
LINE_PX, NOTE_PX = 22, 20
"""Height of a line of text, and size of its letters [pixels]."""
NAME_PX = 18
"""Size of the letters of names on a plan [pixels]."""
PAD_PX = 10
"""Room about text [pixels]."""
MIN_ROBOT_PX = 4.0
"""The robot is never drawn smaller than this radius [pixels]."""
MIN_NAMED_PX = 40.0
"""Rooms narrower than this are not named: the name would cover them [pixels]."""


@dataclass(frozen=True, slots=True)
class View:
    """Where the plan's metres lie in a panel of the window."""

    panel: tuple[int, int, int, int]
    """Left, top, width, height [pixels]."""
    centre: tuple[float, float]
    """What lies in the middle of the panel [m]."""
    scale: float
    """Pixels a metre."""

    @classmethod
    def of(cls, plan: FloorPlan, panel: tuple[int, int, int, int]) -> View:
        """The view that shows the whole plan in a panel, below a line of text."""
        left, top, width, height = panel
        panel = left, top + LINE_PX, width, height - LINE_PX
        x0, y0, x1, y1 = plan.bounds
        room = 1.0 + 2.0 * MARGIN
        scale = min(width / (room * (x1 - x0)), panel[3] / (room * (y1 - y0)))
        return cls(panel, ((x0 + x1) / 2.0, (y0 + y1) / 2.0), scale)

    def pixels(self, points: Any) -> Points:
        """Where points (..., 2) [m] lie on the surface [pixels]."""
        left, top, width, height = self.panel
        offset = (np.asarray(points, dtype=np.float64) - self.centre) * (self.scale, -self.scale)
        return np.asarray(offset + np.array((left + width / 2.0, top + height / 2.0)))


class Painter:
    """Paints scenes; keeps the walls of the last plan, which do not change."""

    def __init__(self) -> None:
        """Load the letters that come with pygame."""
        pygame.font.init()
        self._font = pygame.font.Font(None, NOTE_PX)
        self._small = pygame.font.Font(None, NAME_PX)
        self._plan: FloorPlan | None = None
        self._grounds: dict[tuple[View, bool], pygame.Surface] = {}

    def paint(self, surface: pygame.Surface, scene: Scene, notes: Sequence[str] = ()) -> None:
        """Paint a scene with lines of text below; without a sketch the truth fills the width."""
        width, height = surface.get_size()
        if scene.plan is not self._plan:
            self._plan, self._grounds = scene.plan, {}
        below = LINE_PX * len(notes) + (2 * PAD_PX if notes else 0)
        panels = 1 if scene.sketch is None else 2
        surface.fill(PAPER)
        for panel in range(panels):
            part = (panel * width // panels, 0, width // panels, height - below)
            view = View.of(scene.plan, part)
            self._ground(surface, view, light=panel == 1)
            (self._truth, self._belief)[panel](surface, view, scene)
        for row, note in enumerate(notes):
            at = (PAD_PX, height - below + PAD_PX + row * LINE_PX)
            surface.blit(self._font.render(note, True, colors.BLACK), at)
        if notes:
            pygame.draw.line(
                surface, colors.LIGHT_WALL, (0, height - below), (width, height - below)
            )

    def _ground(self, surface: pygame.Surface, view: View, *, light: bool) -> None:
        """The walls and furniture of the plan, pale under a belief."""
        ground = self._grounds.get((view, light))
        if ground is None:
            ground = pygame.Surface(surface.get_size())
            ground.fill(PAPER)
            self._draw_plan(ground, view, light=light)
            self._grounds[view, light] = ground
        surface.blit(ground, view.panel[:2], view.panel)

    def _draw_plan(self, ground: pygame.Surface, view: View, *, light: bool) -> None:
        plan = self._plan
        assert plan is not None, "a plan was given"
        fill = colors.LIGHT_FURNITURE if light else colors.FURNITURE
        edge = colors.LIGHT_WALL if light else colors.WALL
        for piece in plan.furniture:
            pygame.draw.polygon(ground, fill, view.pixels(piece).tolist())
            pygame.draw.aalines(ground, edge, True, view.pixels(piece).tolist())
        for wall in plan.walls:
            pygame.draw.lines(ground, edge, False, view.pixels(wall).tolist(), 1 if light else 2)
        for name, room in plan.rooms.items() if not light else ():
            point = Polygon(room).representative_point()
            narrow = view.scale * math.sqrt(Polygon(room).area) < MIN_NAMED_PX
            self._write(ground, "" if narrow else name, view.pixels((point.x, point.y)))

    def _truth(self, surface: pygame.Surface, view: View, scene: Scene) -> None:
        plan, solid = scene.plan, {*scene.shut, *scene.barriers}
        for name, leaf in {**plan.doors, **plan.barriers}.items():
            if name in solid:
                line = view.pixels(leaf)
                _line(surface, line, colors.VERMILLION, 4)
                self._write(surface, name, _beside(line), colors.VERMILLION)
        for shapes, color in ((scene.boxes, colors.GREEN), (scene.people, colors.PURPLE)):
            for outline in shapes:
                pygame.draw.polygon(surface, color, view.pixels(outline).tolist())
        _way(surface, view, scene.path, colors.BLUE)
        for x, y in view.pixels(scene.scan).tolist():
            surface.fill(colors.ORANGE, (round(x) - 1, round(y) - 1, 3, 3))
        home = scene.plan_from_sketch if scene.sketch is not None else plan.home
        _star(surface, view.pixels(home.position))
        if scene.goal_pose is not None:
            _diamond(surface, view.pixels(scene.goal_pose.position))
        _robot(surface, view, scene.pose)
        self._scale_bar(surface, view)
        self._caption(surface, view, scene.caption or plan.name)

    def _belief(self, surface: pygame.Surface, view: View, scene: Scene) -> None:
        sketch: Mapping[str, Any] = scene.sketch or {}
        place = scene.plan_from_sketch.apply
        for number, asr in enumerate(sketch.get("asrs", ())):
            boundary = np.array(asr["boundary"], dtype=np.float64).reshape(-1, 2)
            if len(boundary) >= 3:
                color = colors.ASR_COLORS[number % len(colors.ASR_COLORS)]
                here = asr["id"] == sketch.get("here")
                self._area(surface, view.pixels(place(boundary)), color, str(asr["id"]), here=here)
        for line in _lines(sketch.get("surfaces", ())):
            _line(surface, view.pixels(place(line)), colors.BLACK, 2)
        for line in _lines(sketch.get("exits", ())):
            _line(surface, view.pixels(place(line)), colors.GREEN, 5)
        if sketch.get("home") is not None:
            _star(surface, view.pixels(place(np.array(sketch["home"][:2], dtype=np.float64))))
        for mark in sketch.get("marks") or ():
            if scene.goal and mark["id"] == scene.goal:
                _diamond(surface, view.pixels(place(np.array(mark["point"], dtype=np.float64))))
        if sketch.get("pose") is not None:
            _robot(surface, view, scene.plan_from_sketch @ Pose(*map(float, sketch["pose"])))
        self._caption(surface, view, f"believed: {sketch.get('status') or 'nothing said'}")

    def _area(
        self, surface: pygame.Surface, corners: Points, color: str, name: str, *, here: bool
    ) -> None:
        """A place: half transparent, its boundary broader where the robot believes to be."""
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0)) + 1.0
        veil = pygame.Surface((high - low).tolist(), pygame.SRCALPHA)
        inner = (corners - low).tolist()
        pygame.draw.polygon(veil, pygame.Color(color).lerp(PAPER, 0.5), inner)
        pygame.draw.lines(veil, color, True, inner, 4 if here else 2)
        veil.set_alpha(160)
        surface.blit(veil, low.tolist())
        point = Polygon(corners).buffer(0).representative_point()
        self._write(surface, name, np.array((point.x, point.y)), colors.BLACK)

    def _scale_bar(self, surface: pygame.Surface, view: View) -> None:
        left, top, width, height = view.panel
        longest = width / 4.0 / view.scale
        decade = 10.0 ** math.floor(math.log10(longest))
        length = decade * max(n for n in (1.0, 2.0, 5.0) if n * decade <= longest)
        y, x = top + height - PAD_PX, left + PAD_PX
        end = x + length * view.scale
        pygame.draw.line(surface, colors.BLACK, (x, y), (end, y), 3)
        self._write(surface, f"{length:g} m", np.array((end + 3 * PAD_PX, y - 2)), colors.BLACK)

    def _caption(self, surface: pygame.Surface, view: View, text: str) -> None:
        left, top, _, _ = view.panel
        surface.blit(
            self._font.render(text, True, colors.BLACK), (left + PAD_PX, top - LINE_PX + 6)
        )

    def _write(
        self, surface: pygame.Surface, text: str, at: Points, color: str = colors.ROOM_NAME
    ) -> None:
        """A short text with its middle at a point [pixels]."""
        letters = self._small.render(text, True, color)
        surface.blit(letters, letters.get_rect(center=at.round().tolist()))


def _lines(rows: Iterable[Mapping[str, Any]]) -> Points:
    return np.array([(row["p"], row["q"]) for row in rows], dtype=np.float64).reshape(-1, 2, 2)


def _line(surface: pygame.Surface, ends: Points, color: str, width: int) -> None:
    start, end = ends.tolist()
    pygame.draw.line(surface, color, start, end, width)


def _beside(ends: Points) -> Points:
    """Where a name stands beside a line: a letter's height away from its middle [pixels]."""
    along = ends[1] - ends[0]
    normal = np.array((-along[1], along[0])) / max(float(np.hypot(*along)), 1.0)
    return np.asarray(ends.mean(axis=0) + NAME_PX * normal)


def _way(surface: pygame.Surface, view: View, path: Points, color: str) -> None:
    if len(path) > 1:
        pygame.draw.lines(surface, color, False, view.pixels(path).tolist(), 2)


def _robot(surface: pygame.Surface, view: View, pose: Pose) -> None:
    """The body to scale, never too small to be seen, with a line ahead."""
    at = view.pixels(pose.position)
    radius = max(MIN_ROBOT_PX, ROBOT_RADIUS_M * view.scale)
    nose = at + 2.2 * radius * np.array((math.cos(pose.theta), -math.sin(pose.theta)))
    pygame.draw.circle(surface, colors.BLUE, at.tolist(), radius)
    pygame.draw.line(surface, colors.BLUE, at.tolist(), nose.tolist(), 3)


def _star(surface: pygame.Surface, at: Points) -> None:
    """Home."""
    angles = -math.pi / 2.0 + math.pi / 5.0 * np.arange(10)
    reach = np.where(np.arange(10) % 2 == 0, 10.0, 4.0)
    corners = at + reach[:, None] * np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    pygame.draw.polygon(surface, colors.VERMILLION, corners.tolist())


def _diamond(surface: pygame.Surface, at: Points) -> None:
    """The goal."""
    corners = at + 9.0 * np.array(((0, -1), (1, 0), (0, 1), (-1, 0)))
    pygame.draw.polygon(surface, PAPER, corners.tolist())
    pygame.draw.polygon(surface, colors.PURPLE, corners.tolist(), 3)
