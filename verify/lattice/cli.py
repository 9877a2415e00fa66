"""``python -m verify run SCENE``: run a scene file or a shipped scene."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from verify.lattice.families import rational_family_scenes
from verify.lattice.restart import save_run
from verify.lattice.run import run
from verify.lattice.scene import (
    ENGINES,
    Scene,
    further_scenes,
    load_scene,
    shipped_scenes,
    with_tolerance,
)

COLUMNS = {
    "error": "relative error",
    "error_far_field": "against far field",
    "time_step_error": "time step / eps",
    "domain_error": "domain / eps",
}


def run_command(arguments: Sequence[str]) -> int:
    """Run one scene, print its errors and its cost, and write it if asked.

    ``arguments`` are the words after ``run``. Exit status 0, 1 if the run blew up, 2 for bad
    input, which is told in one line.
    """
    options = _parser().parse_args(list(arguments))
    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    try:
        _check_output(options.output)
        scene = _changed(_find_scene(options.scene), options.tolerance, options.engine)
        dataset = _run_with_bar(scene, errors)
        if options.output is not None:
            save_run(dataset, options.output)
    except (ValueError, OSError) as error:
        errors.print(f"error: {error}", markup=False)
        return 2
    _print_summary(dataset, Console(highlight=False))
    return 1 if dataset.attrs["blow_up"] else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m verify run",
        description="Run the lattice from a closed-form wave and compare the two.",
        epilog=f"Shipped scenes: {', '.join((*shipped_scenes(), *further_scenes()))}; "
        f"families: {', '.join(rational_family_scenes())}.",
    )
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or a shipped scene's name")
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="X",
        help="sup error of y/eps to be kept; step and domain are then chosen by the program",
    )
    parser.add_argument("--engine", metavar="E", help=f"{' or '.join(ENGINES)}, with a tolerance")
    parser.add_argument("--output", type=Path, metavar="FILE.nc", help="write the run as netCDF")
    return parser


def _check_output(path: Path | None) -> None:
    if path is not None and not path.parent.is_dir():
        raise ValueError(f"--output must lie in an existing folder, got {path}")


def _find_scene(text: str) -> Scene:
    if text.endswith(".toml") or Path(text).is_file():
        return Scene.from_toml(text)
    family = rational_family_scenes()
    return family[text] if text in family else load_scene(text)


def _changed(scene: Scene, tolerance: float | None, engine: str | None) -> Scene:
    """The scene with what the command line says in the place of what the file says."""
    if tolerance is not None:
        scene = with_tolerance(scene, tolerance)
    return scene if engine is None else replace(scene, engine=engine)


def _run_with_bar(scene: Scene, console: Console) -> xr.Dataset:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(scene.name, total=1.0)
        return run(scene, lambda share: bar.update(task, completed=share))


def _print_summary(dataset: xr.Dataset, console: Console) -> None:
    shown = {name: title for name, title in COLUMNS.items() if name in dataset}
    if shown:
        table = Table("t", *shown.values(), title=dataset.attrs["title"])
        for index, t in enumerate(dataset["time"].values):
            table.add_row(f"{t:g}", *(f"{float(dataset[name][index]):.3g}" for name in shown))
        console.print(table)
    console.print(_cost(dataset), markup=False, soft_wrap=True)
    if dataset.attrs["blow_up"]:
        console.print(
            f"{dataset.attrs['blow_up']}; {dataset.sizes['time']} snapshots before it are kept",
            markup=False,
            soft_wrap=True,
        )


def _cost(dataset: xr.Dataset) -> str:
    """The cost line: what was done, how exact it is, what it took, and what more would take."""
    cost = dataset.attrs
    line = (
        f"{cost['engine']}, {cost['scheme']}: {cost['steps']} steps, {cost['sites']} sites, "
        f"{cost['force_evaluations']} force evaluations a site, {cost['seconds']:.2f} s"
    )
    if "step_limit" in cost:
        line += f" (step limit {cost['step_limit']:.3g})"
    return line + (_accuracy(cost) if "tolerance" in cost else "")


def _accuracy(cost: Mapping[str, Any]) -> str:
    """Estimate against tolerance, planning, and the next decade."""
    dear = cost["next_decade"]
    return (
        f"; error estimate {cost['error_estimate']:.2g} of {cost['tolerance']:g} allowed, "
        f"planned in {cost['planning_seconds']:.2f} s; an estimate of "
        f"{cost['error_estimate'] / 10:.2g} would take {dear:.2g} times as long, "
        f"{dear * cost['seconds']:.2g} s"
    )
