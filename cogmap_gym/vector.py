"""The vector environment: many robots a call, with motion, laser and noise in one compiled step.

It gives what ``env.CogMapEnv`` gives, robot by robot: the same spaces, rewards, goals and
``info``, by the same rules; the world of ``world`` is the reference of its motion. Its noise is
as strong, but drawn from streams of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from cogmap_gym.actions import DECLARED
from cogmap_gym.courses import course_of
from cogmap_gym.crew import Crew
from cogmap_gym.env import STEPS_A_MOVE
from cogmap_gym.fleet import Fleet
from cogmap_gym.geometry import Array
from cogmap_gym.keywords import home_of, most_moves
from cogmap_gym.observation import LaserSpec, Observation, RobotSpec, observation_space
from cogmap_gym.scores import SCORES
from cogmap_gym.sensors import OdometrySpec, laser_spec, odometry_bound
from cogmap_gym.sites import Map, load_sites
from cogmap_gym.vector_keywords import (
    Flags,
    checked_actions,
    count_of,
    jsonable_list,
    maps_of,
    mask_of,
    mode_of,
    refuse,
    room_table,
    seeds_of,
)
from cogmap_gym.vector_tables import AGAIN, APPEAR, DECLARE, MOVE, REST

Info = dict[str, Any]
_KEYS = ("pose", "room", "coverage", "path_length", "phase", "events", "is_success", *SCORES)
_KEYS_AND_MASKS = (*_KEYS, *(f"_{key}" for key in _KEYS))


class CogMapVectorEnv(VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """Many robots, each in a building of its own, stepped together.

    ``gymnasium.make_vec("CogMap/GoHome-v0", num_envs=64, map=[...])`` makes one. All keywords
    of ``CogMapEnv`` but ``render_mode`` are taken, and besides:

    Args:
        num_envs: how many robots.
        map: one map, or a list of maps that are given out in turn; each is loaded once.
        threads: on how many threads the robots are stepped. The bits do not depend on it.
        autoreset_mode: an ``AutoresetMode`` or its value: ``"NextStep"``, ``"SameStep"`` or
            ``"Disabled"``, as Gymnasium defines them.
        lacking: keywords that the compiled step has nothing for.

    Seeds are given out as in Gymnasium's vector environments: ``reset(seed=s)`` begins robot i
    with s + i. Robot i then does what it would do alone, with seed s + i on its map.

    Raises:
        ValueError: on any keyword that is out of bounds or that the compiled step lacks.
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: str = "explore",
        map: Map | Sequence[Map] = "thesis_office",  # noqa: A002
        control: str = "move",
        laser: LaserSpec | Mapping[str, Any] | None = None,
        odometry: OdometrySpec | Mapping[str, Any] | str = "medium",
        max_moves: int | None = None,
        experiment: int | None = None,
        unreachable: float = 0.0,
        threads: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **lacking: Any,
    ) -> None:
        """Load the plans and build robots and tasks; ``reset`` begins the episodes."""
        refuse(lacking)
        self.num_envs, self.threads = count_of(num_envs, "num_envs"), count_of(threads, "threads")
        self.autoreset_mode = mode_of(autoreset_mode)
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.robot, self.laser = RobotSpec(control=control), laser_spec(laser)
        self.odometry = OdometrySpec.of(odometry)
        course = course_of(task, experiment, unreachable)
        maps = maps_of(map)
        sites, which = load_sites(maps[: self.num_envs])
        where = np.resize(which, self.num_envs)
        steps_a_move = 1 if control == "move" else STEPS_A_MOVE
        limits = [most_moves(max_moves, steps_a_move * course.most_moves(s.plan)) for s in sites]
        self._most_moves = np.array(limits)[where]
        self._fleet = Fleet(sites, where, self.robot, self.laser, self.odometry, self.threads)
        self._crew = Crew(self._fleet, course, self.robot, self.laser, steps_a_move)
        bound = odometry_bound(self.robot, self.odometry)
        self.single_observation_space = observation_space(self.laser, bound)
        self.single_action_space = self.robot.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._room_names, self._room_rows = room_table([site.plan for site in sites], where)
        self._rngs: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds = [-1] * self.num_envs
        self._moves = np.zeros(self.num_envs, dtype=np.int64)
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self._still = np.zeros((self.num_envs, 3))
        self._all = np.ones(self.num_envs, dtype=np.bool_)
        self._last: Observation | None = None

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, Info]:
        """Begin episodes at home, with the doors as the plans have them.

        Args:
            seed: of robot 0, the next ones follow; or one for each robot.
            options: ``{"home": [x, y, degrees]}`` puts home elsewhere; ``{"reset_mask": (N,)}``
                begins only these robots' episodes.

        Raises:
            ValueError: an unknown option, a mask or seeds of another length, or a home that is
                no place for the robot.
        """
        seeds = seeds_of(seed, self.num_envs)
        options = dict(options or {})
        mask = mask_of(options.pop("reset_mask", None), self.num_envs)
        rows = np.flatnonzero(mask)
        self._check_mask(mask)
        goals = {row: self._placed(row, seeds[row], options) for row in rows.tolist()}
        self._last = self._observed(goals, self._last)
        return {key: value.copy() for key, value in self._last.items()}, self._info(mask)

    def step(self, actions: NDArray[np.float32]) -> tuple[Observation, Array, Flags, Flags, Info]:
        """Make one move of each robot, or declare; robots that ended are begun anew by the mode.

        Raises:
            ValueError: actions of another shape than (N, 3), or with NaN; in mode ``Disabled``
                a robot that ended and was not reset.
        """
        checked = checked_actions(actions, self.num_envs)
        goals = self._placed_ended()
        modes = np.where(checked[:, 2] > DECLARED, DECLARE, MOVE)
        self._moves += 1
        if goals:
            modes[list(goals)], self._moves[list(goals)] = APPEAR, 0
        scan, odometry = self._fleet.step(modes, checked)
        rewards, terminated = self._crew.step(modes)
        self._crew.appear(goals)
        self._scan_again(scan)
        truncated = (self._moves >= self._most_moves) & ~terminated
        self._ended = terminated | truncated
        observation, info = self._observation(scan, odometry), self._info(self._all)
        if self.autoreset_mode is AutoresetMode.SAME_STEP and self._ended.any():
            observation, info = self._begun_at_once(observation, info)
        if self.autoreset_mode is AutoresetMode.DISABLED:
            self._last = {key: value.copy() for key, value in observation.items()}
        return observation, rewards, terminated, truncated, info

    def close_extras(self) -> None:
        """Let the threads go."""
        self._fleet.close()

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The generator of each robot."""
        return tuple(self._rng(row) for row in range(self.num_envs))

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each robot's generator."""
        return tuple(self._seeds[row] for row, _ in enumerate(self.np_random))

    @property
    def spec(self) -> EnvSpec | None:
        """How the environment was made; its kwargs survive JSON."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        if spec is not None:
            spec.kwargs = {key: jsonable_list(value) for key, value in spec.kwargs.items()}
        self._spec = spec

    _spec: EnvSpec | None = None

    def _rng(self, row: int, seed: int | None = None) -> np.random.Generator:
        """The generator of one robot, made anew if there is a seed."""
        rng = self._rngs[row]
        if rng is None or seed is not None:
            rng, self._seeds[row] = seeding.np_random(seed)
            self._rngs[row] = rng
        return rng

    def _placed(self, row: int, seed: int | None, options: dict[str, Any]) -> np.random.Generator:
        """Put one robot at the beginning of an episode; answer the stream of its goals.

        The streams are those of ``CogMapEnv.reset``.
        """
        _layout, goals, noise = self._rng(row, seed).spawn(3)
        home = home_of(options, self._fleet.site(row).plan.home) if options else None
        self._crew.place(row, home)
        robot = self._fleet.robots[row]
        robot["turn_sign"], robot["distance_sign"] = 1.0 - 2.0 * noise.integers(2, size=2)
        robot["key"] = noise.bit_generator.random_raw()
        self._moves[row], self._ended[row] = 0, False
        return goals

    def _check_mask(self, mask: Flags) -> None:
        """Refuse to begin some robots' episodes where the others' last step is not kept."""
        disabled = self.autoreset_mode is AutoresetMode.DISABLED and self._last is not None
        if not (disabled or mask.all()):
            raise ValueError("reset_mask: only with autoreset_mode 'Disabled', after a full reset")

    def _placed_ended(self) -> dict[int, np.random.Generator]:
        """Put the robots that ended in the last step at the beginning of their next episode."""
        if self._last is None:
            raise ResetNeeded("Cannot call step before the first reset")
        rows = self._ended.nonzero()[0].tolist()
        if rows and self.autoreset_mode is AutoresetMode.DISABLED:
            raise ValueError(f"step: robots {rows} ended: reset them first, by 'reset_mask'")
        return {row: self._placed(row, None, {}) for row in rows}

    def _begun_at_once(self, last: Observation, info: Info) -> tuple[Observation, Info]:
        """The observation and info of mode ``SameStep``, given those of the robots' ends."""
        ended = self._ended
        rows = np.flatnonzero(ended)
        goals = {row: self._placed(row, None, {}) for row in rows.tolist()}
        observation = self._observed(goals, last)
        fresh = self._info(self._all)
        for row in rows.tolist():
            final = {key: value[row] for key, value in last.items()}
            told = {key: info[key][row] for key in _KEYS}
            self._add_info(fresh, {"final_obs": final, "final_info": told}, row)
        return observation, fresh

    def _scan_again(self, scan: NDArray[np.float32]) -> None:
        """Where a door or barrier has changed after a step, the robot sees it as it is now."""
        if self._crew.changed:
            modes = np.full(self.num_envs, REST)
            modes[list(self._crew.changed)] = AGAIN
            self._fleet.step(modes, self._still, scan)

    def _observed(
        self, goals: dict[int, np.random.Generator], last: Observation | None
    ) -> Observation:
        """The first observation of some robots' episodes, beside the last one of the others."""
        modes = np.full(self.num_envs, REST)
        modes[list(goals)] = APPEAR
        scan, odometry = self._fleet.step(modes, self._still)
        self._crew.appear(goals)
        self._scan_again(scan)
        first = self._observation(scan, odometry)
        if last is not None:
            for key, value in first.items():
                value[modes == REST] = last[key][modes == REST]
        return first

    def _observation(self, scan: NDArray[np.float32], odometry: NDArray[np.float32]) -> Observation:
        """What the robots receive; fresh arrays."""
        return {
            "scan": scan,
            "odometry": odometry,
            "bump": self._fleet.robots["bump"].copy(),
            "mark": self._crew.mark.copy(),
            "goal": self._crew.goal.copy(),
        }

    def _info(self, mask: Flags) -> Info:
        """The truth about the robots, as Gymnasium lays it out; fresh arrays."""
        robots, crew = self._fleet.robots, self._crew
        values = (
            self._fleet.poses(),
            self._room_names.take(self._room_rows + robots["room"]),
            crew.seen / crew.cells,
            robots["length"].copy(),
            crew.phase.copy(),
            crew.events.copy(),
            crew.is_success.copy(),
            *crew.scores.copy(),
        )
        masks = np.empty((len(_KEYS), self.num_envs), dtype=np.bool_)
        masks[:] = mask
        return dict(zip(_KEYS_AND_MASKS, (*values, *masks), strict=True))
