"""Map a recording of a real robot: scans and raw odometry of a CARMEN log go to the mapper.

Usage: python scripts/map_log.py LOG --out DIR [--every-m 0.5 --every-deg 15] [--corrected CSV]

Writes mfis.json, poses.csv and mfis.png. Corrected poses serve for scoring only.
"""

from __future__ import annotations

import io
import json
import math
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from rich.progress import track

from agents.cogmap.mapper import Mapper
from agents.cogmap.params import Params
from cogmap_gym import log_metrics
from cogmap_gym.carmen import LaserLog, read_carmen
from cogmap_gym.geometry import Pose, Segments


@dataclass
class Run:
    """What was done so far; row k of every list belongs to the k-th scan fed."""

    scan_index: list[int] = field(default_factory=list)
    poses: list[list[float]] = field(default_factory=list)
    landmarks: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    surfaces: Segments = field(default_factory=lambda: np.zeros((0, 2, 2)))
    interrupted: bool = False

    @property
    def steps_without_landmark(self) -> int:
        """Steps that recognised nothing; the first, with nothing to recognise, is not counted."""
        return sum(count == 0 for count in self.landmarks[1:])


def feed(mapper: Mapper, log: LaserLog, indices: np.ndarray) -> Run:
    """Show the mapper the chosen scans; Ctrl-C ends it early with what was done."""
    run = Run()
    motions = log.motions(indices)
    try:
        for index, motion in track(list(zip(indices, motions, strict=True)), "mapping"):
            begun = time.perf_counter()
            mapper.observe(log.scans[index], Pose(*motion.tolist()))
            run.seconds.append(time.perf_counter() - begun)
            run.landmarks.append(mapper.landmark_count)
            run.poses.append([mapper.pose.x, mapper.pose.y, mapper.pose.theta])
            run.scan_index.append(int(index))
    except KeyboardInterrupt:
        run.interrupted = True
    run.surfaces = mapper.surfaces
    return run


def picture(run: Run, title: str) -> bytes:
    """The surfaces and the believed path as a PNG."""
    figure = Figure((10, 10), layout="constrained")
    axes = figure.add_subplot(xlabel="x [m]", ylabel="y [m]", title=title)
    axes.add_collection(LineCollection(list(run.surfaces), colors="black", label="surfaces (MFIS)"))
    x, y = np.array(run.poses).reshape(-1, 3).T[:2]
    axes.plot(x, y, color="#0072B2", linewidth=0.8, label="believed path")
    axes.plot(x[:1], y[:1], "o", color="#009E73", label="start")
    axes.plot(x[-1:], y[-1:], "s", color="#D55E00", label="end")
    axes.set_aspect("equal")
    axes.autoscale()
    axes.legend()
    figure.savefig(buffer := io.BytesIO(), format="png", dpi=130)
    return buffer.getvalue()


def write(path: Path, content: bytes) -> None:
    """Write a file so that a reader sees the old one or the whole new one."""
    part = path.with_name(f".{path.name}.part")
    part.write_bytes(content)
    part.replace(path)
    print(path)


def write_all(run: Run, out: Path, title: str) -> None:
    """Write the three files of a run."""
    out.mkdir(parents=True, exist_ok=True)
    ends = enumerate(run.surfaces.tolist(), start=1)
    sketch = {
        "surfaces": [{"id": number, "p": p, "q": q} for number, (p, q) in ends],
        "scans": len(run.poses),
        "steps_without_landmark": run.steps_without_landmark,
        "complete": not run.interrupted,
    }
    poses = zip(run.scan_index, run.poses, strict=True)
    rows = [f"{index},{x:.6f},{y:.6f},{theta:.6f}\n" for index, (x, y, theta) in poses]
    write(out / "mfis.json", json.dumps(sketch, indent=1).encode())
    write(out / "poses.csv", "".join(("scan_index,x,y,theta\n", *rows)).encode())
    write(out / "mfis.png", picture(run, title))


def report_scores(run: Run, log: LaserLog, corrected: log_metrics.PoseTable) -> None:
    """Print how well the believed poses and the raw odometry agree with the corrected poses."""
    both, rows, ref_index = np.intersect1d(
        run.scan_index, corrected.scan_index, assume_unique=True, return_indices=True
    )
    if not len(both):
        print("no scan has both a believed and a corrected pose: nothing to score")
        return
    believed, raw = np.array(run.poses)[rows], log.poses_odometry[both]
    mapper = log_metrics.score_poses(believed, corrected.poses, ref_index)
    odometry = log_metrics.score_poses(raw, corrected.poses, ref_index)
    print(f"mapper:       {mapper}\nraw odometry: {odometry}")
    print(f"mapper / raw odometry over 10 m: {mapper.relative / odometry.relative:.3f}")


def main(
    log: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="CARMEN log")],
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for three files")],
    every_m: Annotated[float | None, typer.Option(min=0.0, help="one scan per metres")] = None,
    every_deg: Annotated[float | None, typer.Option(min=0.0, help="or per degrees")] = None,
    corrected: Annotated[Path | None, typer.Option(exists=True, help="only for scores")] = None,
) -> None:
    """Map a CARMEN log, every scan of it or one per given motion, whichever comes first."""
    try:
        recording = read_carmen(log)
        reference = None if corrected is None else log_metrics.read_corrected(corrected)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    metres, degrees = (math.inf if v is None else v for v in (every_m, every_deg))
    every_scan = every_m is None and every_deg is None
    indices = recording.every(0.0 if every_scan else metres, math.radians(degrees))
    run = feed(Mapper(Params(), recording.laser), recording, indices)
    write_all(run, out, f"{log.name}: {len(run.poses)} of {len(recording.times)} scans")
    print(f"{len(run.poses)} scans, {len(run.surfaces)} surfaces")
    print(f"steps without a landmark: {run.steps_without_landmark}")
    print(f"ms a scan (median): {1e3 * float(np.median(run.seconds or [np.nan])):.2f}")
    if reference is not None:
        report_scores(run, recording, reference)
    if run.interrupted:
        raise typer.Exit(130)


if __name__ == "__main__":
    typer.run(main)
