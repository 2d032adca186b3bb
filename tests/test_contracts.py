"""What the project promises of its own source: who may know what, and where numbers come from.

The rules on imports stand in pyproject.toml too, for import-linter. Here they are checked
once more by reading the source, for every robot without naming it.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ROBOT_MAY_IMPORT = {"cogmap_gym.geometry", "cogmap_gym.observation"}
NOT_SCRIPTED = {
    *("rollout", "report", "step_cost", "office_trials", "trials", "ablation", "registry"),
    "plan_trials",
    *("rival_trials", "sweep", "trial_row", "workers", "watch", "provenance", "ppo", "failures"),
}
"""What under agents/ may know the world: the runners of episodes, trials, sweeps, their rows, who
works at them and watches, where rows come from, what looks closer at failures, the report of an
experiment, the clock of the thesis robot's steps, the list of all robots, what the frontier robot
is measured with, and learned robots' training."""
ROBOT_MAY_SHARE = {"agents.base"}
PURE = {
    "geometry": {"numpy", "shapely"},
    "raycast": {
        "numpy",
        "numba",
        "cogmap_gym.geometry",
        "cogmap_gym.raycast_kernel",
        "cogmap_gym.wall_cells",
    },
    "raycast_kernel": {"numpy", "numba", "cogmap_gym.geometry"},
    "wall_cells": {"numpy", "numba", "cogmap_gym.geometry", "cogmap_gym.raycast_kernel"},
}
SOURCED = re.compile(r"\[[^\[\]]+\]\. (Thesis \d+(\.\d+)*\b[^.]*|Ours: .+)\.$", re.DOTALL)
TRUTH = re.compile(r"(^|_)(world|info)(_|$)")
NAMES_A_MACHINE = re.compile(r"/(?:home|root|Users|opt|work)/\w|pypi\.\w|find-links|index-url")
SCRIPT_LINES = 150


def sources(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


def named(path: Path) -> str:
    return str(path.relative_to(ROOT))


def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), named(path))


def imports(path: Path) -> Iterator[str]:
    """Every module that a file imports anywhere, ``from a import b`` as ``a`` or ``a.b``."""
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{named(path)}:{node.lineno}: relative import"
            assert node.module is not None
            for alias in node.names:
                is_module = (ROOT / node.module.replace(".", "/") / f"{alias.name}.py").exists()
                yield f"{node.module}.{alias.name}" if is_module else node.module


def within(name: str, packages: set[str]) -> bool:
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def scripted_robots() -> list[Path]:
    return [
        path
        for path in sources("agents")
        if path.relative_to(ROOT / "agents").parts[0].removesuffix(".py") not in NOT_SCRIPTED
    ]


def params() -> list[tuple[ast.ClassDef, ast.AnnAssign, ast.stmt | None]]:
    """Each field of params.py with its class and the statement that follows it."""
    tree = parsed(ROOT / "agents" / "cogmap" / "params.py")
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    groups = {cls.name for cls in classes}
    return [
        (cls, field, following)
        for cls in classes
        for field, following in zip(cls.body, [*cls.body[1:], None], strict=True)
        if isinstance(field, ast.AnnAssign) and ast.unparse(field.annotation) not in groups
    ]


@pytest.mark.parametrize(
    ("cls", "field", "following"),
    params(),
    ids=[f"{cls.name}.{ast.unparse(field.target)}" for cls, field, _ in params()],
)
def test_every_number_of_the_robot_has_a_unit_and_a_source(
    cls: ast.ClassDef, field: ast.AnnAssign, following: ast.stmt | None
) -> None:
    doc = following.value if isinstance(following, ast.Expr) else None
    text = doc.value if isinstance(doc, ast.Constant) else None
    assert isinstance(text, str), f"params.py:{field.lineno}: no docstring"
    assert SOURCED.search(" ".join(text.split())), (
        f"params.py:{field.lineno}: expected it to end '[unit]. Thesis 3.3.' "
        f"or '[unit]. Ours: reason.', got {text!r}"
    )


@pytest.mark.parametrize("path", scripted_robots(), ids=named)
def test_a_scripted_robot_imports_nothing_of_the_world_that_knows_the_truth(path: Path) -> None:
    of_world = {name for name in imports(path) if within(name, {"cogmap_gym", "scripts", "tests"})}
    assert of_world <= ROBOT_MAY_IMPORT


@pytest.mark.parametrize("path", scripted_robots(), ids=named)
def test_robots_share_no_code_with_one_another(path: Path) -> None:
    own = path.relative_to(ROOT / "agents").parts[0].removesuffix(".py")
    of_robots = {name for name in imports(path) if within(name, {"agents"})}
    assert all(within(name, ROBOT_MAY_SHARE | {f"agents.{own}"}) for name in of_robots)


@pytest.mark.parametrize("path", sources("agents/cogmap"), ids=named)
def test_the_thesis_robot_has_no_word_for_the_truth(path: Path) -> None:
    for node in ast.walk(parsed(path)):
        names = [
            getattr(node, key, None) for key in ("id", "attr", "arg", "name", "asname", "value")
        ]
        for name in names:
            if isinstance(name, str) and name.isidentifier():
                assert not TRUTH.search(name), f"{named(path)}:{getattr(node, 'lineno', 0)}: {name}"


@pytest.mark.parametrize("path", sources("cogmap_gym"), ids=named)
def test_the_world_imports_no_robot_and_no_learner(path: Path) -> None:
    foreign = {"agents", "scripts", "tests", "stable_baselines3", "torch"}
    assert not [name for name in imports(path) if within(name, foreign)]


@pytest.mark.parametrize("module", sorted(PURE))
def test_geometry_and_the_laser_kernel_see_only_arrays(module: str) -> None:
    allowed = PURE[module] | set(sys.stdlib_module_names)
    found = set(imports(ROOT / "cogmap_gym" / f"{module}.py"))
    assert not [name for name in found if not within(name, allowed)]


@pytest.mark.parametrize("path", sources("agents") + sources("cogmap_gym"), ids=named)
def test_only_learned_robots_import_a_learner(path: Path) -> None:
    learned = (ROOT / "agents" / "ppo") in path.parents
    learners = {"stable_baselines3", "sb3_contrib", "torch"}
    assert learned or not [name for name in imports(path) if within(name, learners)]


@pytest.mark.parametrize("path", sources("scripts"), ids=named)
def test_a_script_is_short_and_imports_no_other(path: Path) -> None:
    assert path.parent == ROOT / "scripts", "scripts are flat"
    assert len(path.read_text(encoding="utf-8").splitlines()) <= SCRIPT_LINES
    others = {other.stem for other in sources("scripts")} | {"scripts"}
    assert not [name for name in imports(path) if within(name, others)]


def test_no_tracked_file_names_a_machine_or_a_registry() -> None:
    git = shutil.which("git")
    if git is None or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    listed = subprocess.run(
        [git, "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout.split("\0")  # fmt: skip
    found = []
    for name in filter(None, listed):
        path = ROOT / name
        if path == Path(__file__).resolve() or not path.is_file():
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        found += [
            f"{name}:{number}"
            for number, line in enumerate(text.splitlines(), 1)
            if NAMES_A_MACHINE.search(line)
        ]
    assert not found


def test_the_package_loads_without_a_display_and_without_what_draws() -> None:
    program = (
        "import sys, cogmap_gym\n"
        "drawers = {'matplotlib', 'pygame', 'stable_baselines3', 'torch'} & set(sys.modules)\n"
        "assert not drawers, drawers\n"
    )
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=ROOT, env={"PATH": ""}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
