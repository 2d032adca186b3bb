"""Draw what was understood of a floor plan: walls, rooms, doors and home, to scale.

For example: ``show_map.py plan.png --metres-per-pixel 0.05 --out plan_understood.png``.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from cogmap_gym import FloorPlan
from cogmap_gym.plan_figures import plan_figure
from cogmap_gym.saving import save_png


def described(plan: str, metres_per_pixel: float | None, rooms: Path | None) -> Any:
    """What ``FloorPlan.load`` takes: the plan itself, or the description of a picture."""
    if metres_per_pixel is None and rooms is None:
        return plan
    picture = {"image": plan, "metres_per_pixel": metres_per_pixel, "rooms": rooms}
    return {key: str(v) if key == "rooms" else v for key, v in picture.items() if v is not None}


def main(
    plan: Annotated[str, typer.Argument(help="a plan by name or path, or a picture")],
    out: Annotated[Path, typer.Option(dir_okay=False, help="picture to write")] = Path(
        "out/map.png"
    ),
    save: Annotated[Path | None, typer.Option(dir_okay=False, help="plan to write, .yaml")] = None,
    metres_per_pixel: Annotated[float | None, typer.Option(help="scale of a picture")] = None,
    rooms: Annotated[Path | None, typer.Option(help="a picture's rooms by colour")] = None,
) -> None:
    """Draw what was understood of a floor plan, and write it as our YAML if wanted."""
    begin = time.perf_counter()
    try:
        loaded = FloorPlan.load(described(plan, metres_per_pixel, rooms))
        print(
            f"{loaded.name}: {len(loaded.walls_and_furniture())} wall segments, "
            f"{len(loaded.rooms)} rooms, {len(loaded.doors)} doors, {loaded.area:.0f} m^2 free, "
            f"home at ({loaded.home.x:.2f}, {loaded.home.y:.2f}), "
            f"read in {time.perf_counter() - begin:.1f} s"
        )
        out.parent.mkdir(parents=True, exist_ok=True)
        print(save_png(plan_figure(loaded), out))
        if save is not None:
            save.parent.mkdir(parents=True, exist_ok=True)
            loaded.save(save)
            print(save)
    except (ValueError, OSError) as error:
        raise typer.BadParameter(str(error)) from error


if __name__ == "__main__":
    typer.run(main)
