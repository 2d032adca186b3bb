"""Drive every environment at random for very many steps, and look for what must never happen.

Each case (id, control, map, level of dynamics) is driven in rounds. After every step: all
numbers are finite, the observation is in its space, robot and boxes are in the building, and the
robot is at most 1 cm inside anything. Once in each round the environment is pickled; the copy must
go on with the same bits. The memory of the process is read after each round.

For example: ``soak.py --map thesis_office --map office:1000 --steps 100000 --out out/soak.json``.
Ctrl-C ends it with what was seen so far.
"""

from __future__ import annotations

import gc
import json
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from cogmap_gym import FloorPlan
from cogmap_gym.saving import write_whole
from cogmap_gym.soaking import cases, soak

MAPS = ["thesis_office", "office:1000", "office:1001"]


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
    todo, deepest, found, memory, done = cases(plans), {}, [], [], 0
    each, begin = max(steps // (len(todo) * rounds), 1), time.perf_counter()
    try:
        with Progress() as progress:
            for number, case in progress.track(list(enumerate(todo * rounds)), description="soak"):
                told = soak(case.made(plans[case.map]), seed + number, each, deepest)
                found += [f"{case}, seed {seed + number}: {fault}" for fault in told[:5]]
                done += each
                if (number + 1) % len(todo) == 0:
                    memory.append(resident())
    except KeyboardInterrupt:
        print("interrupted")
    seconds = round(time.perf_counter() - begin)
    result = {"steps": done, "cases": len(todo), "seconds": seconds, "deepest_m": deepest}
    text = json.dumps({**result, "memory_by_round_kb": memory, "faults": found}, indent=1)
    out.parent.mkdir(parents=True, exist_ok=True)
    print(text, write_whole(out, text.encode()))
    raise typer.Exit(130 if done < each * len(todo) * rounds else int(bool(found)))


if __name__ == "__main__":
    typer.run(main)
