"""Our SLAM rival beside another program's SLAM, on the same scans and odometry.

Usage: python scripts/check_slam.py --yag PYTHON [--offices 1000:1003] [--odometry medium]

A frontier robot with SLAM explores generated offices and goes to places. Its scans and odometry are
then given to yag-slam, in a process of its own, by an interpreter PYTHON that has it:
`pip install yag-slam opencv-python-headless` in an environment apart. Printed are the errors of the
path as known at the end: ATE after one rigid fit, and RPE over 10 m of travel.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Annotated, Any

import gymnasium as gym
import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

import cogmap_gym  # noqa: F401 - registers the environments
from agents.frontier import FrontierAgent
from agents.registry import make_agent
from agents.rollout import run_episode
from agents.trials import seeds_of
from cogmap_gym.geometry import Array, Pose
from cogmap_gym.metrics import dead_reckoning
from cogmap_gym.observation import LaserSpec
from cogmap_gym.pose_scores import pose_scores

WORKER = Path(__file__).with_name("yag_slam_poses.py")
"""What the other interpreter runs."""


def recorded(office: int, seed: int, odometry: str) -> tuple[FrontierAgent, dict[str, Array]]:
    """Explore and go to places; answer the robot, and by step scan, measured motion, true pose."""
    env = gym.make("CogMap/GoTo-v0", map=f"office:{office}", odometry=odometry)
    agent: Any = make_agent("frontier_slam", seed)
    rows: list[tuple[Array, Array, Array]] = []

    def keep(_: int, seen: Any, _action: Any, info: dict[str, Any], _agent: Any) -> None:
        rows.append((seen["scan"], seen["odometry"], info["pose"]))

    run_episode(env, agent, seed, keep)
    names = ("scans", "motions", "true")
    return agent, {k: np.array(v) for k, v in zip(names, zip(*rows, strict=True), strict=True)}


def run_by(python: Path, *words: str | Path) -> None:
    """Let another interpreter run; what it says of its failure is told on."""
    told = subprocess.run(  # noqa: S603 - the interpreter is the user's choice
        [python, *words], capture_output=True, text=True, check=False
    )
    if told.returncode:
        raise ValueError(f"yag: {python} failed: {told.stderr.strip().splitlines()[-1:]}")


def by_yag(python: Path, scans: Array, odometry: Array, laser: LaserSpec) -> Array:
    """The robot's poses by yag-slam, (T, 3), in the frame in which it began."""
    mount = laser.robot_from_laser
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(
            source, scans=scans, odometry=_rows(_pose(row) @ mount for row in odometry),
            laser=(laser.first_angle, laser.step, laser.range_max),
        )  # fmt: skip
        run_by(python, WORKER, source, target)
        poses = np.load(target)["poses"]
    return _rows(_pose(row) @ mount.inverse() for row in poses)


def _pose(row: Array) -> Pose:
    return Pose(*(float(value) for value in row))


def _rows(poses: Any) -> Array:
    return np.array([(pose.x, pose.y, pose.theta) for pose in poses])


def main(
    yag: Annotated[Path, typer.Option(exists=True, dir_okay=False, help="its interpreter")],
    offices: Annotated[str, typer.Option(help="FIRST:LAST, without LAST")] = "1000:1003",
    odometry: Annotated[str, typer.Option(help="low, medium, high, severe")] = "medium",
    seed: Annotated[int, typer.Option(min=0, help="of the episodes")] = 0,
) -> None:
    """Drive, and compare."""
    table = Table("office", "steps", "by", "ATE [m]", "RPE over 10 m [m]")
    try:
        run_by(yag, "-c", "import cv2, yag_slam")
        for office in track(seeds_of(offices), "offices"):
            agent, kept = recorded(office, seed, odometry)
            reckoned = dead_reckoning(kept["motions"])
            ours = _rows(agent.source.poses[: len(kept["true"])])
            theirs = by_yag(yag, kept["scans"], reckoned, agent.laser)
            for name, poses in (("odometry", reckoned), ("ours", ours), ("yag-slam", theirs)):
                scores = pose_scores(poses, kept["true"])
                errors = (f"{scores[key]:.3f}" for key in ("ate", "rpe"))
                table.add_row(str(office), str(len(poses)), name, *errors)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
