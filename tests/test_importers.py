"""Floor plans of other programs: each format loads, and what is none is told in words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import cogmap_gym  # noqa: F401 (registers the environments)
from cogmap_gym.floor_plan import FloorPlan
from cogmap_gym.geometry import lengths
from tests.drawings import ARIA, SAMPLES, VECTORMAP, needs_samples, two_rooms, write_ros

PICTURE = {"metres_per_pixel": 0.05}
SAMPLE_PLANS: dict[str, tuple[Any, tuple[float, float], int]] = {
    "GDC3": ("GDC3.vectormap.txt", (2000, 4000), 50),
    "NSH4": ("NSH4.vectormap.txt", (2000, 3500), 60),
    "gdc_1": ("gdc_1.yaml", (500, 800), 10),
    "willow": ("willow-full-0.05.yaml", (1200, 1500), 30),
    "columbia": ("columbia.map", (800, 1000), 10),
    "office_b": ("office_b_furnitures.png", (1000, 1200), 25),
    "lab_c": ("lab_c_scan_furnitures.png", (300, 400), 12),
}
"""By plan: the file, least and most free area [m^2], fewest rooms."""


def write_all(folder: Path) -> dict[str, Any]:
    """The two rooms in each format."""
    write_ros(folder, two_rooms(), image="map.png")
    (folder / "lines.vectormap.txt").write_text(VECTORMAP)
    (folder / "lines.map").write_text(ARIA)
    (folder / "scaled.yml").write_text("image: map.png\nmetres_per_pixel: 0.05\n")
    return {
        "ros": str(folder / "map.yaml"),
        "scaled": folder / "scaled.yml",
        "picture": {"image": str(folder / "map.png"), **PICTURE},
        "vectormap": folder / "lines.vectormap.txt",
        "aria": folder / "lines.map",
    }


def test_each_format_gives_two_rooms_that_our_own_file_keeps(tmp_path: Path) -> None:
    for name, source in write_all(tmp_path).items():
        plan = FloorPlan.load(source)
        assert len(plan.rooms) == 2, name
        assert plan.area == pytest.approx(40.0 if name in ("vectormap", "aria") else 18.2, abs=0.1)
        plan.save(tmp_path / "kept.yaml")
        assert FloorPlan.load(tmp_path / "kept.yaml").to_mapping() == plan.to_mapping()


def test_an_environment_takes_each_format_and_its_spec_survives_json(tmp_path: Path) -> None:
    for source in write_all(tmp_path).values():
        env = gym.make("CogMap/Explore-v0", map=source)
        assert env.spec is not None
        twin = gym.make(EnvSpec.from_json(env.spec.to_json()))
        seen, _ = env.reset(seed=1000)
        again, info = twin.reset(seed=1000)
        assert np.array_equal(seen["scan"], again["scan"])
        assert 0.0 < info["coverage"] <= 1.0
        twin.close()
        env.close()


def test_a_plan_of_lines_keeps_what_bounds_the_free_space_and_the_home_of_the_file(
    tmp_path: Path,
) -> None:
    sources = write_all(tmp_path)
    drawn, given = FloorPlan.load(sources["vectormap"]), FloorPlan.load(sources["aria"])
    assert drawn.bounds == given.bounds == (0.0, 0.0, 8.0, 5.0)
    assert lengths(drawn.wall_segments()).sum() == pytest.approx(26.0 + 4.0)
    assert given.to_mapping()["home"] == [2.0, 2.5, 90.0]
    assert drawn.name == given.name == "lines"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", "1,2,3\n", "line 1: expected x1,y1,x2,y2 in metres, got '1 2 3'"),
        ("a.txt", "0,0,1,1\n0,0,nan,1\n", "line 2: .*'0 0 nan 1'"),
        ("a.txt", "0,0,1,inf\n", "line 1: .*inf"),
        ("a.txt", "0,0,1,1e9\n", "at most 500 m"),
        ("a.txt", "-1e308,0,1e308,1\n", "at most 500 m"),
        ("a.txt", "", "expected lines, got none"),
        ("a.txt", "1,1,1,1\n", "got points alone"),
        ("a.txt", "0,0,1,0\n", "home|free space"),
        ("a.txt", "0,0,.2,0\n.2,0,.2,.2\n.2,.2,0,.2\n0,.2,0,0\n", "home|free space"),
        ("a.map", "3D-Map\n", "expected the first line '2D-Map', got .*3D-Map"),
        ("a.map", "", "expected the first line"),
        ("a.map", "2D-Map\nDATA\n1 2\n", "expected a section LINES"),
        ("a.map", ARIA.replace("NumLines: 6", "NumLines: 9"), "NumLines: expected '9' lines"),
        ("a.map", ARIA.replace("0 5000 0 0\n", "0 5000 0\n"), "line 13: .*millimetres"),
        ("a.map", ARIA.replace("RobotHome 2000", "RobotHome x"), "RobotHome: .*'x 2500"),
        (
            "a.map",
            ARIA.replace("RobotHome 2000 2500", "RobotHome 4100 1000"),
            r"home: .*0\.25.*4\.1",
        ),
        ("a.map", ARIA.replace("RobotHome 2000", "RobotHome 99000"), r"home: .*between.*99\.0"),
        ("a.csv", VECTORMAP, "ending in one of .*got '.csv'"),
        ("plan", "name: x\n", "ending in one of .*got ''"),
        ("a.png", "x", "a picture needs a scale: .*metres_per_pixel"),
    ],
)
def test_a_file_that_is_no_plan_is_told_with_what_it_says(
    name: str, content: str, message: str, tmp_path: Path
) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(ValueError, match=f"{name}: .*({message})"):
        FloorPlan.load(path)


def test_a_file_that_is_no_text_is_told(tmp_path: Path) -> None:
    for name in ("a.txt", "a.map"):
        (tmp_path / name).write_bytes(bytes(range(128, 256)))
        with pytest.raises(ValueError, match=f"{name}: expected text"):
            FloorPlan.load(tmp_path / name)


@needs_samples
@pytest.mark.parametrize("name", SAMPLE_PLANS)
def test_each_sample_of_a_real_building_loads_with_its_rooms_and_an_environment(name: str) -> None:
    file, (least, most), rooms = SAMPLE_PLANS[name]
    source: Any = str(SAMPLES / file)
    if file.endswith(".png"):
        labels = source.replace("furnitures", "gt_segmentation")
        source = {"image": source, **PICTURE, "rooms": labels}
    env: Any = gym.make("CogMap/Explore-v0", map=json.loads(json.dumps(source)))
    plan = env.unwrapped.plan
    assert least < plan.area < most
    assert len(plan.rooms) >= rooms
    inside = sum(plan.room_free_space(room).area for room in plan.rooms)
    assert inside == pytest.approx(plan.area, rel=0.05)
    env.reset(seed=1000)
    env.step(env.unwrapped.robot.move(0.5, 1.0))
