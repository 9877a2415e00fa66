"""``longwave run FILE`` of a scene on any lattice: derive, run, compare, print."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from longwave.runs.output_checkpoint import OutputCheckpoint
from longwave.runs.save_elsewhere import fail_or_save_elsewhere
from longwave.runs.store_messages import fetch_with_messages
from longwave.scenes.scene import Scene
from longwave.support.command_line import fail_for_memory, interrupted
from longwave.support.console import plain_console, progress_bar

if TYPE_CHECKING:
    import xarray as xr


def run_lattice_and_print(
    scene: Scene,
    program: str,
    tolerance: float | None,
    engine: str | None,
    output: str | None,
    store: str | None,
    force: bool,
) -> int:
    """Run the scene, print its errors and its cost, and write it if asked.

    Exit status 0, 1 if it could not be written, 2 for bad input, told in one line, and 130 after
    Ctrl-C, which ``program`` tells. More than 5 s are announced.
    """
    checkpoint = OutputCheckpoint(output, store)
    try:
        if engine is not None:
            scene = scene.changed(engine=engine)
        if tolerance is not None:
            scene = scene.changed(tolerance=tolerance)
        with checkpoint.kept(scene):
            run = run_with_bar(scene, store)
    except KeyboardInterrupt:
        return interrupted(program, checkpoint.left("nothing was kept"))
    except (ValueError, OSError) as error:
        return fail_or_save_elsewhere(error)
    except MemoryError as error:
        return fail_for_memory(error)
    status = checkpoint.settle(lambda: run, force)
    print_lattice_run(run, scene, plain_console())
    return status


def run_with_bar(scene: Scene, store: str | None) -> xr.Dataset:
    """Run a scene, or find its run in the store, with a bar where there is a terminal."""
    errors = plain_console(stderr=True, soft_wrap=True)
    with progress_bar(scene.name, f"{scene.name} to {scene.target.tolerance:g}", errors) as bar:
        if store is None:
            return scene.run(*bar)
        return fetch_with_messages(store, scene, *bar)


def print_lattice_run(run: xr.Dataset, scene: Scene, console: Console) -> None:
    """Print the errors, or sizes, at each time, what was derived, and the cost."""
    console.print(scene.title or scene.name, markup=False, soft_wrap=True)
    if scene.is_growth:
        table = Table("t", "T", "sidebands / carrier", "in theory")
        names = ("time", "slow_time", "sideband_size", "sideband_theory")
    else:
        table = Table("t", "T", f"sup error / {run['sup_error'].attrs['units']}", "relative error")
        names = ("time", "slow_time", "sup_error", "error")
    for t, T, *values in zip(*(run[name].values for name in names), strict=True):
        table.add_row(f"{t:.6g}", f"{T:.3g}", *(f"{value:.3g}" for value in values))
    console.print(table)
    for line in (*_lines(run.attrs, scene), *_pulse_lines(run)):
        console.print(line, markup=False, soft_wrap=True)


def _lines(told: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    yield f"{scene.lattice}, eps = {scene.eps:g}, {scene.order} order; {told['equation']}"
    if scene.is_growth:
        yield str(told["verdict"])
    line = (
        f"{told['engine']}, {told['scheme']}: {told['steps']} steps, {told['sites']} sites, "
        f"{told['force_evaluations']} force evaluations a site, {told['seconds']:.2f} s; error "
        f"estimate {told['error_estimate']:.2g} of {scene.target.tolerance:g} allowed, planned in "
        f"{told['planning_seconds']:.2f} s"
    )
    drift = told.get("energy_drift")
    yield line if drift is None else f"{line}; energy kept to {drift:.1g}"


def _pulse_lines(run: xr.Dataset) -> Iterator[str]:
    """What disorder left of a wave."""
    if "peak" not in run:
        return
    peak, energy, delay = (
        f"{run[name].values[-1]:.4g} +- {run[name + '_error'].values[-1]:.1g}"
        for name in ("peak", "energy", "delay")
    )
    unknown = np.isnan(run["energy"].values[-1])
    held = "" if unknown else f" and energy {energy}"
    yield f"at the end: largest force {peak}{held} of the start's, {delay} sites late"
    if unknown:
        yield "no energy is told: the lattice has none, or the wave goes on beyond half_width"
    speed = run.attrs.get("effective_speed")
    if speed is not None:
        yield f"very long waves: {speed:.6g} of the ordered lattice's speed"
