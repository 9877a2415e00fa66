"""The words of the command line that run scenes.

Nothing of the rooms is imported before a command runs, so help and completion answer at once.
"""

from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from longwave.support.command_line import called_by, example, limit_options

ROOMS = Path(__file__).parents[1]
SWEEPS = ROOMS / "runs" / "sweeps"
"""Where the shipped sweeps lie."""

ENGINES = ("stencil", "spectral")
SCENES = ROOMS / "scenes"
"""Where the shipped scenes lie."""


def scene_names() -> list[str]:
    """The names of the shipped scenes, found as files: importing the lattice takes seconds."""
    return sorted(path.stem for path in SCENES.rglob("*.toml"))


def complete_scenes(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    """Files, where a path or nothing that is shipped has been begun, else the shipped scenes."""
    names = [name for name in scene_names() if name.startswith(begun)]
    items = [CompletionItem(name) for name in names]
    return items if begun and names else [*items, CompletionItem(begun, type="file")]


@click.command(epilog=example("longwave run rational_2_eps_0.05 --tolerance 1e-3"))
@click.argument("scene", shell_complete=complete_scenes)
@click.option(
    "--tolerance",
    type=float,
    metavar="X",
    help="Sup error of y/eps to be kept; step and domain are then chosen by the program.",
)
@click.option("--engine", metavar="E", help=f"{' or '.join(ENGINES)}, with a tolerance.")
@click.option("--output", metavar="FILE.nc", type=click.Path(), help="Write the run as NetCDF-4.")
@click.option(
    "--store",
    metavar="FOLDER",
    type=click.Path(),
    help="Keep the run in this folder; one that is there is not run again, one that was broken off "
    "is gone on with.",
)
@click.option("--force", is_flag=True, help="Let --output overwrite an older run.")
@limit_options
def run(scene: str, **options: Any) -> int:
    """Run the lattice from a wave and compare the two.

    SCENE is a TOML file or the name of a shipped scene (`longwave list scenes`, `longwave list
    lattice-scenes`); one that names a lattice has its equation derived first. Or it is the file of
    a run: its scene is run again, and it is told whether that gave the same bits (exit status 0)
    or what differs (1).
    """
    from longwave.cli.scene_command import run_and_print

    return run_and_print(scene, called_by(), **options)


def complete_sweeps(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    """The shipped sweeps, and files."""
    names = sorted(path.stem for path in SWEEPS.glob("*.toml") if path.stem.startswith(begun))
    return [*map(CompletionItem, names), CompletionItem(begun, type="file")]


@click.command(epilog=example("longwave sweep error_over_k --processes 2 --output errors.nc"))
@click.argument("sweep", shell_complete=complete_sweeps)
@click.option("--processes", type=int, metavar="N", help="Worker processes (all cores).")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, tcp://HOST:PORT, instead.")
@click.option(
    "--store", metavar="FOLDER", type=click.Path(), help="Keeps the runs (default SWEEP.store)."
)
@click.option(
    "--output", metavar="FILE.nc", type=click.Path(), help="The cells' numbers (SWEEP.nc)."
)
@click.option("--force", is_flag=True, help="Overwrite what is no result of this sweep, too.")
@limit_options
def sweep(sweep: str, **options: Any) -> int:
    """Run a scene for many values of its fields.

    SWEEP is a TOML file that says which, or the name of a shipped sweep (`longwave list sweeps`).
    Runs are kept in a folder: the same command goes on where it was stopped. A cell that fails is
    recorded with its error.
    """
    from longwave.cli.sweep_command import sweep_and_print

    return sweep_and_print(sweep, called_by(), **options)
