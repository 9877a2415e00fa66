"""The words of the command line that run scenes.

Nothing of the rooms is imported before a command runs, so help and completion answer at once.
"""

from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from derive.command_line import called_by, example, limit_options

ENGINES = ("stencil", "spectral")
SCENES = tuple(Path(__file__).parents[1] / "verify" / room for room in ("comparison", "lattices"))
"""Where the shipped scenes lie."""


def scene_names() -> list[str]:
    """The names of the shipped scenes, found as files: importing the lattice takes seconds."""
    return sorted(path.stem for room in SCENES for path in room.rglob("*.toml"))


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
@click.option("--output", metavar="FILE.nc", type=click.Path(), help="Write the run as netCDF.")
@limit_options
def run(**options: Any) -> int:
    """Run the lattice from a wave and compare the two.

    SCENE is a TOML file or the name of a shipped scene (`longwave list scenes`, `longwave list
    lattice-scenes`); one that names a lattice has its equation derived first.
    """
    from runs.scene_command import RunOptions, run_and_print

    return run_and_print(RunOptions(**options), called_by())
