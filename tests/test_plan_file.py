"""Plan files: they round trip, and each mistake is told with file, key and value."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from cogmap_gym import plan_file, plan_schema
from cogmap_gym.floor_plan import FloorPlan
from tests import rooms


def thin() -> dict[str, Any]:
    return rooms.thin_rooms().to_mapping()


@pytest.mark.parametrize("name", plan_file.map_names())
def test_a_saved_plan_is_read_back_bit_by_bit(name: str, tmp_path: Path) -> None:
    plan = FloorPlan.load(name)
    plan.save(tmp_path / "plan.yaml")
    assert FloorPlan.load(tmp_path / "plan.yaml").to_mapping() == plan.to_mapping()
    assert [path.name for path in tmp_path.iterdir()] == ["plan.yaml"]


def test_odd_names_and_awkward_numbers_survive_a_file(tmp_path: Path) -> None:
    mapping = thin() | {"name": "yes", "closed": ["no: # 1"]}
    mapping["doors"] = {"no: # 1": [[4.0, 2.0], [4.0, 3.0]]}
    mapping["barriers"] = {"é": [[1e-7, 0.1 + 0.2], [1 / 3, 12345.678901234567]]}
    plan = FloorPlan.from_mapping(mapping)
    plan.save(tmp_path / "plan.yaml")
    assert FloorPlan.load(tmp_path / "plan.yaml").to_mapping() == plan.to_mapping() == mapping


def test_a_failed_save_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    rooms.l_room().save(path)
    before = path.read_text()
    with pytest.raises(yaml.YAMLError):
        plan_file.write({"name": object()}, path)
    assert path.read_text() == before
    assert list(tmp_path.iterdir()) == [path]


NAN = float("nan")
MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "unknown key": ({"windows": [1]}, r"windows: unknown, got \[1\]"),
    "nan": ({"walls": [[[0, 0], [NAN, 1]]]}, r"walls\.0: .*finite.*nan"),
    "infinite home": ({"home": [1, float("inf"), 0]}, "home: .*finite.*inf"),
    "far too large": ({"walls": [[[0, 0], [1e300, 1]]]}, r"walls\.0: .*1e\+300"),
    "an integer beyond any float": ({"home": [10**400, 1, 0]}, r"home: .*\[1000"),
    "a number that is a truth value": ({"home": [True, 1, 0]}, "home: .*True"),
    "a number that is text": ({"home": ["1", 1, 0]}, "home: .*'1'"),
    "home of two numbers": ({"home": [1, 1]}, r"home: expected 3 numbers, got \[1, 1\]"),
    "wall of no length": ({"walls": [[[0, 0], [0, 0]]]}, r"walls\.0: .*zero length"),
    "wall of one point": ({"walls": [[[0, 0]]]}, r"walls\.0: .*2 or more points"),
    "point of three numbers": ({"walls": [[[0, 0, 0], [1, 1, 1]]]}, r"walls\.0: .*2 numbers"),
    "no walls": ({"walls": []}, r"walls: .*at least one"),
    "walls by name": ({"walls": {"a": [[0, 0], [1, 1]]}}, "walls: expected a list"),
    "doors as a list": ({"doors": [[[4, 2], [4, 3]]]}, "doors: expected names"),
    "door of no length": ({"doors": {"E1": [[4, 2], [4, 2]]}}, r"doors\.E1: .*zero length"),
    "door of three points": ({"doors": {"E1": [[4, 2], [4, 3], [4, 4]]}}, r"doors\.E1: .*2 points"),
    "door in the open": ({"doors": {"E1": [[2, 2], [2, 3]]}}, r"doors\.E1: .*wall.*2\.0"),
    "door short of the jamb": ({"doors": {"E1": [[4, 2], [4, 2.8]]}}, r"doors\.E1: .*0\.200 m"),
    "door without a name": ({"doors": {1: [[4, 2], [4, 3]]}}, "doors: expected a name.*1"),
    "closed names no door": ({"closed": ["E9"]}, "closed: .*'E9'"),
    "closed names a door twice": ({"closed": ["E1", "E1"]}, "closed: .*'E1'"),
    "closed as text": ({"closed": "E1"}, "closed: expected a list"),
    "room that crosses itself": (
        {"rooms": {"R1": [[0, 0], [2, 2], [2, 0], [0, 2]]}},
        r"rooms\.R1: .*cross",
    ),
    "room without area": ({"rooms": {"R1": [[0, 0], [1, 0], [2, 0]]}}, r"rooms\.R1: .*area"),
    "furniture of two points": ({"furniture": [[[1, 1], [2, 2]]]}, r"furniture\.0: .*3 or more"),
    "home at a wall": ({"home": [0.2, 1, 0]}, r"home: .*0\.25 m or more .*\[0\.2, 1\.0\]"),
    "home outside": ({"home": [-5, 1, 0]}, r"home: .*between the outer walls.*-5\.0"),
    "home in furniture": (
        {"furniture": [[[0.5, 1], [3.5, 1], [3.5, 4], [0.5, 4]]]},
        "home: .*furniture",
    ),
    "home where no room is": (
        {"rooms": {"R9": [[10, 0], [12, 0], [12, 2]]}},
        "home: .*outside the walls",
    ),
    "no name": ({"name": ""}, "name: .*''"),
}


@pytest.mark.parametrize(("change", "message"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_with_file_key_and_value(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(yaml.safe_dump(thin() | change))
    with pytest.raises(ValueError, match=f"wrong.yaml: {message}"):
        FloorPlan.load(path)
    with pytest.raises(ValueError, match=f"mapping: {message}"):
        FloorPlan.load(thin() | change)


@pytest.mark.parametrize("key", plan_schema.KEYS)
def test_a_missing_key_is_named(key: str) -> None:
    mapping = thin()
    del mapping[key]
    with pytest.raises(ValueError, match=f"mapping: {key}: missing"):
        FloorPlan.from_mapping(mapping)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: [1, 2", "YAML"),
        ("- 1\n- 2\n", "expected a mapping"),
        ("", "expected a mapping"),
        ("name: a\nname: b\n", "'name' stands twice"),
        ("name: !!python/object:os.system {}", "YAML"),
        ("\x00", "YAML"),
        ("[" * 200_000, "nested more than 8 deep"),
        ("- " * 100 + "1", "nested more than 8 deep"),
    ],
)
def test_a_file_that_is_no_plan_is_told(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"odd.yaml: .*{message}"):
        FloorPlan.load(path)


def test_a_door_drawn_twice_is_told(tmp_path: Path) -> None:
    path = tmp_path / "odd.yaml"
    path.write_text("doors: {E1: [[4, 2], [4, 3]], E1: [[4, 2], [4, 3]]}")
    with pytest.raises(ValueError, match="'E1' stands twice"):
        FloorPlan.load(path)


def test_a_file_of_few_bytes_that_unfolds_to_many_points_is_told(tmp_path: Path) -> None:
    path = tmp_path / "bomb.yaml"
    lines = [
        "a0: &a0 [0, 1]",
        *(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 12)),
    ]
    keys = [f"{key}: *a11" for key in plan_schema.KEYS]
    path.write_text("\n".join(lines + keys))
    with pytest.raises(ValueError, match=r"bomb\.yaml: a0: unknown"):
        FloorPlan.load(path)


def test_binary_huge_and_absent_files_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plan.yaml").write_bytes(bytes(range(128, 256)))
    with pytest.raises(ValueError, match=r"plan\.yaml: expected a plan in YAML"):
        FloorPlan.load(tmp_path / "plan.yaml")
    monkeypatch.setattr(plan_file, "MAX_BYTES", 100)
    with pytest.raises(ValueError, match=r"plan\.yaml: expected a plan of at most 100 bytes"):
        FloorPlan.load(tmp_path / "plan.yaml")
    with pytest.raises(ValueError, match=r"thesis_office.*two_rooms.*'no_such_map'"):
        FloorPlan.load("no_such_map")
    for odd in ("a" * 5000, "a\0b", "", str(tmp_path)):
        with pytest.raises(ValueError, match=r"map: expected a file or one of"):
            FloorPlan.load(odd)
