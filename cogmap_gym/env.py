"""The Gymnasium environment: it sequences world, sensors and task, and has no rules itself."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from cogmap_gym.body import Motion
from cogmap_gym.courses import course_of
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import Pose
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec, observation_space
from cogmap_gym.sensors import (
    Laser,
    Odometer,
    OdometrySpec,
    laser_spec,
    odometry_bound,
    odometry_reading,
)
from cogmap_gym.tasks import Task
from cogmap_gym.world import World

if TYPE_CHECKING:
    from cogmap_gym.render import Scene

DECLARED = 0.5
"""An action whose third number is above this says "I am there". DESIGN 3."""
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
        render_mode: None or ``"rgb_array"``.
        experiment: which experiment ``"thesis"`` runs, 1 to 3; None for any other task.
        unreachable: share of the goals of ``"shortcut"`` to which no route is left.

    Specs and plans may be given as objects; ``spec`` then holds their mappings, so that it
    survives JSON. ``reset(options={"home": [x, y, degrees]})`` moves home for one episode.

    Raises:
        ValueError: on any keyword that is out of bounds, naming it.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 - Gymnasium's type

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
        self.world = World(self.plan, self.robot)
        self._start = self.world.state()
        course = course_of(task, experiment, unreachable)
        steps_a_move = 1 if control == "move" else STEPS_A_MOVE
        self.task = Task(course, self.world, self.laser, steps_a_move)
        self.max_moves = limit_of(max_moves, steps_a_move * course.most_moves(self.plan))
        self._scanner = Laser(self.world.caster, self.laser)
        self._bound = odometry_bound(self.robot, self.odometry)
        self.observation_space = observation_space(self.laser, self._bound)
        self.action_space = self.robot.action_space
        self._sketch: dict[str, Any] | None = None

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
        _layout, goals, self._noise = self.np_random.spawn(3)
        home = home_of(options, self.plan.home)
        self.world.set_state(self._start)
        self.world.place(home)
        self.task.reset(goals)
        self._odometer = Odometer(self.odometry, self._noise)
        self._moves = 0
        self._path = [home.position]
        self._sketch = None
        return self._observe(STILL, bump=False), self.task.info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Make one move, or declare.

        Raises:
            ValueError: an action of another shape than (3,), or with NaN in it.
        """
        first, second, third = _checked(action)
        declared = third > DECLARED
        motion = NO_MOTION if declared else self._move(first, second)
        measured = STILL if declared else self._measure(motion)
        reward, terminated = self.task.step(None if declared else motion, declared=declared)
        self._moves += 1
        self._path.extend(motion.path[1:])
        observation = self._observe(measured, bump=motion.bump)
        truncated = not terminated and self._moves >= self.max_moves
        return observation, float(reward), terminated, truncated, self.task.info()

    def set_sketch(self, sketch: dict[str, Any] | None) -> None:
        """Let ``render`` show what an agent believes beside the truth."""
        self._sketch = sketch

    def render(self) -> NDArray[np.uint8] | None:
        """A picture uint8 (H, W, 3) of the world, and of the sketch if one was set."""
        if self.render_mode is None:
            return None
        from cogmap_gym.render import draw

        return draw(self.scene())

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

    def _move(self, first: float, second: float) -> Motion:
        robot = self.robot
        if robot.control == "move":
            return self.world.move(first * robot.max_turn, robot.max_forward * (second + 1.0) / 2.0)
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


def limit_of(asked: int | None, default: int) -> int:
    """The limit of an episode that was asked for, or the default [steps]."""
    if asked is None:
        return default
    if isinstance(asked, bool) or not isinstance(asked, int) or asked < 1:
        raise ValueError(f"max_moves: expected an int of at least 1, got {asked!r}")
    return asked


def home_of(options: Mapping[str, Any] | None, default: Pose) -> Pose:
    """Where the options put home."""
    unknown = set(options or ()) - {"home"}
    if unknown:
        raise ValueError(f"options: expected only 'home', got {sorted(unknown)}")
    if not options:
        return default
    numbers = np.asarray(options["home"], dtype=np.float64)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"options: home: expected [x, y, degrees], got {options['home']!r}")
    x, y, degrees = map(float, numbers)
    return STILL @ Pose(x, y, math.radians(degrees))


def _checked(action: Any) -> tuple[float, ...]:
    """The three numbers of an action, clipped to [-1, 1]."""
    values = np.asarray(action, dtype=np.float64)
    if values.shape != (3,) or np.isnan(values).any():
        raise ValueError(f"action: expected 3 numbers, none NaN, got {action!r}")
    return tuple(np.clip(values, -1.0, 1.0).tolist())


def jsonable(value: Any) -> Any:
    """A keyword as JSON can hold it: specs and plans as mappings, paths as strings."""
    if isinstance(value, FloorPlan):
        return value.to_mapping()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    return str(value) if isinstance(value, Path) else value
