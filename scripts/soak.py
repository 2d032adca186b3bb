"""Drive every environment at random for very many steps, and look for what must never happen.

Each case (id, control, map, level of dynamics) is driven in rounds. After every step: all
numbers are finite, the observation is in its space, robot and boxes are in the building, and the
robot is at most 1 cm inside anything. Once in each round the environment is pickled; the copy must
go on with the same bits. The memory of the process is read after each round.

For example: ``soak.py --map thesis_office --map office:1000 --steps 100000 --out out/soak.json``.
The file is written anew after each case, so that Ctrl-C leaves what was seen so far.
"""

from __future__ import annotations

import gc
import json
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import track

from cogmap_gym import FloorPlan
from cogmap_gym.saving import write_whole
from cogmap_gym.soaking import cases, soak

MAPS = ["thesis_office", "office:1000", "office:1001"]
MOST_FAULTS = 5
"""How many faults are told of one case in one round."""


def resident() -> int:
    """Memory of this process [kB]; 0 where the system does not tell."""
    gc.collect()
    told = Path("/proc/self/status")
    lines = told.read_text().splitlines() if told.exists() else []
    return sum(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def main(
    out: Annotated[Path, typer.Option(dir_okay=False)] = Path("out/soak.json"),
    maps: Annotated[list[str], typer.Option("--map", help="also a mapping, as JSON")] = MAPS,
    steps: Annotated[int, typer.Option(min=1, help="in all")] = 1_000_000,
    rounds: Annotated[int, typer.Option(min=1)] = 4,
    seed: Annotated[int, typer.Option(help="of the first case")] = 1000,
) -> None:
    """Drive every environment at random, and write what was found as JSON."""
    plans = {m: FloorPlan.load(json.loads(m) if m.startswith("{") else m) for m in maps}
    todo = cases(plans)
    each, begin = max(steps // (len(todo) * rounds), 1), time.perf_counter()
    told: dict[str, Any] = {"steps": 0, "of": each * len(todo) * rounds, "cases": len(todo)}
    told |= {"seconds": 0, "deepest_m": {}, "memory_by_round_kb": [], "faults": []}
    out.parent.mkdir(parents=True, exist_ok=True)
    for number, case in track(list(enumerate(todo * rounds, 1)), description="soak"):
        env, first = case.made(plans[case.map]), seed + number
        found = soak(env, first, each, told["deepest_m"])[:MOST_FAULTS]
        told["faults"] += [f"{case}, seed {first}: {fault}" for fault in found]
        told["steps"] += each
        told["seconds"] = round(time.perf_counter() - begin)
        if number % len(todo) == 0:
            told["memory_by_round_kb"].append(resident())
        write_whole(out, json.dumps(told, indent=1).encode())
    print(f"{json.dumps(told, indent=1)}\n{out}")
    raise typer.Exit(int(bool(told["faults"])))


if __name__ == "__main__":
    typer.run(main)
