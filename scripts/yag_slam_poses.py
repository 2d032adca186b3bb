"""Poses by yag-slam, another program's graph SLAM after Karto, of recorded scans and odometry.

Usage: PYTHON scripts/yag_slam_poses.py IN.npz OUT.npz

PYTHON is an interpreter that has yag-slam and opencv-python-headless; this project needs neither.
IN.npz holds `scans` (T, beams) [m], `odometry` (T, 3), where the wheels say that the laser was
[m, m, rad], and `laser`: first angle, step [rad] and range [m]. OUT.npz gets `poses` (T, 3), where
yag-slam says at the end that the laser was. `check_slam.py` calls it.
"""

import sys

import numpy as np
from yag_slam.graph_slam import GraphSlam
from yag_slam.models import LocalizedRangeScan
from yag_slam.scan_matching import Scan2DMatcherCpp

SHARE = 0.98
"""Beams that reach so much of the range met nothing [1]. Ours."""


def main(source: str, target: str) -> None:
    """Feed all scans, in order."""
    told = np.load(source)
    first, step, far = told["laser"].tolist()
    last = first + step * (told["scans"].shape[1] - 1)
    slam = GraphSlam(Scan2DMatcherCpp({}), Scan2DMatcherCpp({}, loop=True))
    for ranges, (x, y, theta) in zip(told["scans"], told["odometry"], strict=True):
        scan = LocalizedRangeScan(
            ranges.astype(float).tolist(), first, last, step, 0.0, far, SHARE * far, x, y, theta
        )
        slam.process_scan(scan)
    poses = [vertex.obj.corrected_pose for vertex in slam.graph.vertices]
    np.savez(target, poses=[(p.x, p.y, p.euler[-1]) for p in poses])


if __name__ == "__main__":
    main(*sys.argv[1:])
