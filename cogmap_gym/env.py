"""The Gymnasium environment: it sequences world, sensors and task, and has no rules itself."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from cogmap_gym.actions import DECLARED, checked, turn_and_forward
from cogmap_gym.body import Motion
from cogmap_gym.courses import course_of
from cogmap_gym.dynamics import dynamics_level
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.keywords import home_of, jsonable, most_moves
from cogmap_gym.living_world import LivingWorld, living_or_still
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec, observation_space
from cogmap_gym.screen import Window
from cogmap_gym.sensors import (
    Laser,
    Odometer,
    OdometrySpec,
    laser_spec,
    odometry_bound,
    odometry_reading,
)
from cogmap_gym.tasks import Task

if TYPE_CHECKING:
    from cogmap_gym.render import Scene

STEPS_A_MOVE = 25
"""Steps of velocity control for which the budgets grant one move: 1.75 m at top speed."""
STILL = Pose()
"""The odometry of a robot that did not move."""
NO_MOTION = Motion(0.0, 0.0, False, np.zeros((1, 2)))


class CogMapEnv(gym.Env[Observation, Any]):
    """A robot with a laser and drifting odometry in a building; see DESIGN 3 for the contract.

    Args:
        task: ``"explore"``, ``"home"``, ``"goto"``, ``"shortcut"`` or ``"thesis"``; the
            registered ids set it.
        map: a name under ``maps/``, ``"office:SEED"``, the path or mapping of a plan, or a plan.
        control: ``"move"`` (turn, then drive) or ``"velocity"`` (0.1 s of v and omega).
        laser: a spec, its mapping, or None for the SICK LMS-200.
        odometry: a spec, its mapping, or the name of a level.
        max_moves: steps after which an episode is truncated. By default ``Explore`` gets 200
            and one a square metre of free space, ``GoHome`` 120 and three quarters a square
            metre, the others the sum of their budgets; 25 times as many in velocity control.
        render_mode: None, ``"rgb_array"`` or ``"human"``, a window that every step draws in.
        experiment: which experiment ``"thesis"`` runs, 1 to 3; None for any other task.
        unreachable: share of the goals of ``"shortcut"`` to which no route is left.
        dynamics: what moves but the robot: ``"off"``, ``"furniture"`` that it can push,
            ``"doors"`` on a schedule, ``"people"`` who walk about, or all, ``"busy"``.

    Specs and plans may be given as objects; ``spec`` then holds their mappings, so that it
    survives JSON. ``reset(options={"home": [x, y, degrees]})`` moves home for one episode.

    Raises:
        ValueError: on any keyword that is out of bounds, naming it.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 10}  # noqa: RUF012 - Gymnasium's type

    def __init__(
        self,
        task: str = "explore",
        map: str | Path | Mapping[str, Any] | FloorPlan = "thesis_office",  # noqa: A002
        control: str = "move",
        laser: LaserSpec | Mapping[str, Any] | None = None,
        odometry: OdometrySpec | Mapping[str, Any] | str = "medium",
        max_moves: int | None = None,
        render_mode: str | None = None,
        experiment: int | None = None,
        unreachable: float = 0.0,
        dynamics: str = "off",
    ) -> None:
        """Load the plan and build world, sensors and task; ``reset`` begins an episode."""
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            modes = [None, *self.metadata["render_modes"]]
            raise ValueError(f"render_mode: expected one of {modes}, got {render_mode!r}")
        self.render_mode = render_mode
        self.robot = RobotSpec(control=control)
        self.laser = laser_spec(laser)
        self.odometry = OdometrySpec.of(odometry)
        self.plan = FloorPlan.load(map)
        self.world = living_or_still(self.plan, self.robot, dynamics_level(dynamics, task))
        self._start = self.world.state()
        course = course_of(task, experiment, unreachable)
        steps_a_move = 1 if control == "move" else STEPS_A_MOVE
        routes = self.world.routes if isinstance(self.world, LivingWorld) else None
        self.task = Task(course, self.world, self.laser, steps_a_move, routes=routes)
        self.max_moves = most_moves(max_moves, steps_a_move * course.most_moves(self.plan))
        self._scanner = Laser(self.world.caster, self.laser)
        self._bound = odometry_bound(self.robot, self.odometry)
        self.observation_space = observation_space(self.laser, self._bound)
        self.action_space = self.robot.action_space
        self._sketch: dict[str, Any] | None = None
        self._window = Window(frames_per_second=self.metadata["render_fps"])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode at home, with the doors as the plan has them.

        Args:
            seed: fixes all that follows; layout, goals and noise have streams of their own.
            options: ``{"home": [x, y, degrees]}`` puts home elsewhere.

        Raises:
            ValueError: an unknown option, or a home that is no place for the robot.
        """
        super().reset(seed=seed)
        layout, goals, self._noise = self.np_random.spawn(3)
        home = home_of(options, self.plan.home)
        self.world.set_state(self._start)
        self.world.place(home)
        if isinstance(self.world, LivingWorld):
            self.world.begin(layout)
        self.task.reset(goals)
        self._odometer = Odometer(self.odometry, self._noise)
        self._moves = 0
        self._path = [home.position]
        self._sketch = None
        observation = self._observe(STILL, bump=False)
        self._show(wait=True)
        return observation, self.task.info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Make one move, or declare.

        Raises:
            ValueError: an action of another shape than (3,), or with NaN in it.
        """
        first, second, third = checked(action)
        declared = third > DECLARED
        motion = NO_MOTION if declared else self._move(first, second)
        measured = STILL if declared else self._measure(motion)
        reward, terminated = self.task.step(None if declared else motion, declared=declared)
        self._moves += 1
        self._path.extend(motion.path[1:])
        observation = self._observe(measured, bump=motion.bump)
        truncated = not terminated and self._moves >= self.max_moves
        self._show(wait=True)
        return observation, float(reward), terminated, truncated, self.task.info()

    def set_sketch(self, sketch: dict[str, Any] | None) -> None:
        """Let ``render`` show what an agent believes beside the truth."""
        self._sketch = sketch

    def render(self) -> NDArray[np.uint8] | None:
        """A picture uint8 (H, W, 3) of the world, and of the sketch if one was set.

        In mode ``"human"`` the window is drawn anew, and there is no picture.
        """
        if self.render_mode != "rgb_array":
            self._show(wait=False)
            return None
        from cogmap_gym.render import draw

        return draw(self.scene())

    def close(self) -> None:
        """Close the window, if there is one; closing twice is fine."""
        self._window.close()

    def scene(self) -> Scene:
        """All that a picture of this moment shows, the sketch that was set included."""
        from cogmap_gym.render import Scene, scan_ends

        world, task, phase = self.world, self.task, self.task.phase
        doing = "all phases over" if phase is None else phase.task
        return Scene(
            self.plan,
            world.pose,
            shut=tuple(sorted(world.shut_doors)),
            barriers=tuple(sorted(world.present_barriers)),
            boxes=world.box_outlines,
            people=world.people_outlines,
            scan=scan_ends(self._scan, self.laser, world.pose),
            path=np.array(self._path),
            sketch=self._sketch,
            plan_from_sketch=task.marks[1],
            goal=task.goal,
            goal_pose=task.marks.get(task.goal),
            caption=f"{self.plan.name}, phase {len(task.results) + 1}: {doing}",
        )

    @property
    def spec(self) -> EnvSpec | None:
        """How the environment was made; its kwargs survive JSON."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        if spec is not None:
            spec.kwargs = {key: jsonable(value) for key, value in spec.kwargs.items()}
        self._spec = spec

    _spec: EnvSpec | None = None

    def _show(self, *, wait: bool) -> None:
        if self.render_mode == "human":
            self._window.show(self.scene(), wait=wait)

    def _move(self, first: float, second: float) -> Motion:
        robot = self.robot
        if robot.control == "move":
            return self.world.move(*turn_and_forward(robot, first, second))
        return self.world.drive(first * robot.max_speed, second * robot.max_turn_rate)

    def _measure(self, motion: Motion) -> Pose:
        if self.robot.control == "move":
            return self._odometer.measure(motion.turned, motion.driven)
        chord = Pose(0.0, 0.0, motion.turned / 2.0) @ Pose(motion.driven, 0.0, 0.0)
        return self._odometer.measure_velocity(chord.x, chord.y, motion.turned)

    def _observe(self, measured: Pose, *, bump: bool) -> Observation:
        self._scan = self._scanner.scan(self.world.pose, self._noise)
        return {
            "scan": np.array(self._scan, dtype=np.float32),
            "odometry": odometry_reading(measured, self._bound),
            "bump": np.int64(bump),
            "mark": np.int64(self.task.mark),
            "goal": np.int64(self.task.goal),
        }
