"""``longwave run FILE`` of a scene on any lattice: derive, run, compare, print."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from derive.command_line import fail, interrupted
from runs.run_file import save_run
from verify.cli.console import plain_console, progress_bar
from verify.comparison.scene_run import Announcer
from verify.lattices.lattice_run import LatticeRun, run_lattice_scene
from verify.lattices.lattice_scene import LatticeScene

if TYPE_CHECKING:
    from runs.scene_command import RunOptions


def run_lattice_and_print(scene: LatticeScene, options: RunOptions, program: str) -> int:
    """Run the scene, print its errors and its cost, and write it if asked.

    Exit status 0, 2 for bad input, told in one line, and 130 after Ctrl-C, which ``program`` tells.
    More than 10 s are announced.
    """
    try:
        if options.engine is not None:
            raise ValueError(
                f"--engine must not be given for a scene that names a lattice, got "
                f"{options.engine} (leave it out)"
            )
        if options.tolerance is not None:
            scene = scene.changed(tolerance=options.tolerance)
        run = run_with_bar(scene)
        if options.output is not None:
            save_run(run.dataset, options.output)
    except KeyboardInterrupt:
        return interrupted(program, "nothing was kept")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"sites must fit the memory, got a scene that does not: {error} (take fewer)")
    print_lattice_run(run, plain_console())
    return 0


def run_with_bar(scene: LatticeScene) -> LatticeRun:
    """Run a scene, with a bar where there is a terminal; long work is announced."""
    errors = plain_console(stderr=True, soft_wrap=True)
    with progress_bar(scene.name, f"{scene.name} to {scene.tolerance:g}", errors) as bar:
        return run_lattice_scene(scene, bar[0], Announcer(bar[1]))


def print_lattice_run(run: LatticeRun, console: Console) -> None:
    """Print the errors at each time, what was derived, and the cost."""
    scene = run.scene
    unit = f"sup error / {run.unit}"
    console.print(scene.title or scene.name, markup=False, soft_wrap=True)
    table = Table("t", "T", unit, "relative error")
    rows = zip(run.times, run.slow_times, run.errors, run.relative_errors, strict=True)
    for t, T, error, relative in rows:
        table.add_row(f"{t:.6g}", f"{T:.3g}", f"{error:.3g}", f"{relative:.3g}")
    console.print(table)
    for line in _lines(run):
        console.print(line, markup=False, soft_wrap=True)


def _lines(run: LatticeRun) -> Iterator[str]:
    cost = run.cost
    scene = run.scene
    yield f"{scene.lattice}, eps = {scene.eps:g}, {scene.order} order; {run.derived.text()}"
    line = (
        f"{cost['engine']}, {cost['scheme']}: {cost['steps']} steps, {cost['sites']} sites, "
        f"{cost['force_evaluations']} force evaluations a site, {cost['seconds']:.2f} s; error "
        f"estimate {run.error_estimate:.2g} of {run.scene.tolerance:g} allowed, planned in "
        f"{cost['planning_seconds']:.2f} s"
    )
    drift = cost.get("energy_drift")
    yield line if drift is None else f"{line}; energy kept to {drift:.1g}"
