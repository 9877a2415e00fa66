"""The commands and their options: one tree, declared with click.

No room is imported before a command runs, so that help and completion answer at once.
"""

import json
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem, get_completion_class

from longwave.cli.commands import check, library, prove, verify
from longwave.derive.__main__ import derive
from longwave.reports.__main__ import report
from longwave.support.command_line import (
    CommandGroup,
    command_name,
    example,
    force_option,
    json_option,
    limit_options,
    limits_of_each,
    named_values,
    path_option,
    set_option,
)

COMPLETION = "_LONGWAVE_COMPLETE"
"""Environment variable with which a shell requests completions."""

INVENTORY_KINDS = (
    *("lattices", "waves", "schemes", "scenes", "lattice-scenes", "bench-scenes"),
    *("sweeps", "observables"),
)
RUN_PICTURES = (
    *("all", "snapshots", "space_time", "spectra", "errors", "crest"),
    *("sensors", "transmission", "balance", "flux", "modes", "cells", "growth"),
)
SWEEP_PICTURES = ("values", "work_precision", "growth_map")
SHELLS = ("bash", "zsh", "fish")
PACKAGE_FOLDER = Path(__file__).parents[1]
SWEEP_FOLDER = PACKAGE_FOLDER / "runs" / "sweeps"
"""Folder of the shipped sweeps."""

SCENE_FOLDER = PACKAGE_FOLDER / "scenes" / "shipped"
"""Folder of the shipped scenes."""


def scene_names() -> list[str]:
    """Return the names of the shipped scenes, read from file names; importing `scenes` is slow."""
    return sorted(path.stem for path in SCENE_FOLDER.rglob("*.toml"))


def complete_scenes(_: click.Context, __: click.Parameter, prefix: str) -> list[CompletionItem]:
    """Complete the name of a shipped scene; if none fits or ``prefix`` is a path, a file name."""
    return _shipped_or_files(scene_names(), prefix)


def complete_sweeps(_: click.Context, __: click.Parameter, prefix: str) -> list[CompletionItem]:
    """Complete the name of a shipped sweep; if none fits or ``prefix`` is a path, a file name."""
    return _shipped_or_files(sorted(path.stem for path in SWEEP_FOLDER.glob("*.toml")), prefix)


def _shipped_or_files(names: list[str], prefix: str) -> list[CompletionItem]:
    items = [CompletionItem(name) for name in names if name.startswith(prefix)]
    return items if prefix and items else [*items, CompletionItem(prefix, type="file")]


def _completion(context: click.Context, _: click.Parameter, shell: str | None) -> None:
    shell_class = get_completion_class(shell) if shell else None
    if shell_class is not None and not context.resilient_parsing:
        click.echo(shell_class(longwave, {}, "longwave", COMPLETION).source())
        context.exit()


@click.group(
    cls=CommandGroup,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=example("longwave run rogue_cn_k_0.5")
    + "\n\nExit status: 0 all is well, 1 something is refuted, undecided, missing or broke off, "
    "2 wrong input, 130 Ctrl-C.",
)
@click.version_option(
    package_name="longwave", message="longwave %(version)s", help="Print the version."
)
@click.option(
    "--completion",
    type=click.Choice(SHELLS),
    expose_value=False,
    is_eager=True,
    callback=_completion,
    help="Print the script that completes words and options in this shell.",
)
def longwave() -> None:
    """Derive the long-wave limit of a lattice, prove its closed-form solutions, and test them on
    the lattice itself.
    """


for command in (derive, prove, library, check, verify):
    longwave.add_command(command)


@longwave.command(epilog=example("longwave fit force.csv --output chain.toml --plot fit.png"))
@click.argument("points", metavar="FILE.csv...", nargs=-1, required=True, type=click.Path())
@click.option("--scene", metavar="SCENE", help="Fit this chain on a bench to its sensors' records.")
@click.option("--free", metavar="NAME,...", help="Constants or losses.site, losses.bond to fit.")
@click.option("--law", metavar="FORMULA", help="Force in the stretch x, or hertz, or table.")
@click.option(
    "--fix", "fixed", multiple=True, metavar="NAME=VALUE,...", help="Constants not fitted."
)
@click.option("--units", metavar="LENGTH,FORCE", help="Units of the columns, as mm,N.")
@path_option("--output", "LATTICE.toml", "Write the lattice, its constants and covariance.")
@path_option("--plot", "FILE", "Draw the law and the residuals: PNG, PDF or SVG.")
@force_option
@json_option
@limit_options
def fit(
    points: tuple[str, ...],
    fixed: tuple[str, ...],
    scene: str | None,
    free: str | None,
    **options: Any,
) -> int:
    """Fit a force law, or a scene to its sensors.

    For a law, the file has measured points and begins with the line stretch,force,deviation; the
    standard deviations of the forces may be left out. Without --law the polynomial K2*x +
    K3*x**2 + ... with the least AICc is fitted. With --scene, files are records of its sensors and
    begin with a line such as time,displacement_0,velocity_7. `longwave derive` reads the lattice
    that is written, and gives its coefficients with intervals.
    """
    law_options = {"--law": options["law"], "--units": options["units"], "--plot": options["plot"]}
    if (scene is None) != (free is None):
        raise click.UsageError("--scene must be given with --free, got one of them alone")
    if scene is None or free is None:
        if len(points) > 1:
            raise click.UsageError(f"FILE.csv must be one file without --scene, got {len(points)}")
        from longwave.cli.fit import fit_and_print

        return fit_and_print(points[0], fixed=named_values("--fix", fixed), **options)
    for name, value in {**law_options, "--fix": fixed}.items():
        if value:
            raise click.UsageError(f"{name} must not be given with --scene, got both")
    from longwave.cli.fit import fit_scene_and_print

    outputs = {key: options[key] for key in ("output", "force", "json_wanted")}
    return fit_scene_and_print(points, scene, free, **outputs)


@longwave.command(
    epilog=example("longwave wave fput_strain --set K2=1,K3=0,K4=1 --near dn --k 3/5 --eps 2/25")
)
@click.argument("model", metavar="MODEL|FILE.toml")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE,...", help="Values of constants.")
@click.option(
    "--near", metavar="dn|cn|sn|cnoidal|soliton", help="The wave next to this one of mKdV or KdV."
)
@click.option("--k", metavar="X", help="Modulus of --near, 0 < k < 1.")
@click.option("--eps", metavar="X", help="Small parameter of --near.")
@click.option("--every-eps-to", metavar="X", help="All eps up to this one, for --near (and --k).")
@click.option("--period", metavar="P", help="A periodic wave of this period in cells.")
@click.option("--mean", metavar="X", help="Its mean strain (0).")
@click.option("--first-mode", metavar="X", help="Its first mode f_1: f_0 + 2 f_1 cos(...) + ...")
@click.option("--speed", metavar="V", help="A solitary wave of this speed, in cells a time unit.")
@click.option("--stability", metavar="X", help="Also the growth at kappa P/(2 pi) = X.")
@click.option("--ring", type=int, metavar="M", help="Also the stability on M wavelengths.")
@path_option("--certificate", "FILE.json", "Write the proof, for longwave check.")
@click.option("--digits", type=click.IntRange(2, 38), default=16, metavar="N", help="Digits (16).")
@force_option
@json_option
@limit_options
def wave(model: str, sets: tuple[str, ...], **options: Any) -> int:
    """Find an exact wave of a lattice and prove it.

    MODEL is a chain of equal masses (`longwave list lattices`), or a file of one. The verdict is
    EXISTS, NOT PROVED with the inequality that failed, or REFUSED for a lattice outside the
    theorems. Every number is printed with its proved error.
    """
    from longwave.cli.wave_command import wave_and_print

    return wave_and_print(model, named_values("--set", sets), **options)


@longwave.command(
    epilog=example("longwave orbit alpha_fput --set K2=1,K3=1/5 --sites 5 --energy 1/2")
    + "\n  longwave orbit klein_gordon --set K2=2/25,g1=1,g2=0,g3=1 --frequency 8/5"
)
@click.argument("model", metavar="MODEL|FILE.toml")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE,...", help="Values of constants.")
@click.option("--sites", type=int, metavar="N", help="A finite chain of N sites, its ends fixed.")
@click.option("--mode", type=int, default=1, metavar="N", help="Its linear mode (1, the lowest).")
@click.option("--energy", metavar="X", help="Energy of the orbit, for unit masses.")
@click.option("--frequency", metavar="X", help="A breather of the infinite chain: its frequency.")
@path_option("--certificate", "FILE.json", "Write the proof, for longwave check.")
@click.option("--digits", type=click.IntRange(2, 38), default=16, metavar="N", help="Digits (16).")
@force_option
@json_option
@limit_options
def orbit(model: str, sets: tuple[str, ...], **options: Any) -> int:
    """Find an exact time-periodic orbit of a lattice and prove it.

    MODEL is a chain of equal masses (`longwave list lattices`), or a file of one, in displacements.
    The orbit of a finite chain continues a linear mode, and its Floquet multipliers are proved
    too. The verdicts are those of `longwave wave`.
    """
    from longwave.cli.orbit_command import orbit_and_print

    return orbit_and_print(model, named_values("--set", sets), **options)


@longwave.command(epilog=example("longwave run rational_2_eps_0.05 --tolerance 1e-3"))
@click.argument("scene", shell_complete=complete_scenes)
@click.option(
    "--tolerance",
    type=float,
    metavar="X",
    help="Allowed sup error of y/eps; the program then chooses step and domain.",
)
@click.option(
    "--engine",
    metavar="E",
    help="Method with a tolerance: stencil (site by site) or spectral (spectral ring).",
)
@set_option
@path_option("--output", "FILE.nc", "Write the run as NetCDF-4.")
@path_option(
    "--store",
    "FOLDER",
    "Save the run in this folder; a run there is not repeated, an interrupted one is resumed.",
)
@click.option("--force", is_flag=True, help="Let --output overwrite an older run.")
@json_option
@limit_options
def run(scene: str, **options: Any) -> int:
    """Run the lattice from a wave and compare the two.

    SCENE is a TOML file or the name of a shipped scene (`longwave list scenes`, `longwave list
    lattice-scenes`). If it is the file of a run, its scene is run again, and the command reports
    whether all bits are the same (exit status 0) or what differs (1).
    """
    from longwave.cli.scene_command import run_and_print

    return run_and_print(scene, command_name(), **options)


@longwave.command(epilog=example("longwave sweep error_over_k --processes 2 --output errors.nc"))
@click.argument("sweep", shell_complete=complete_sweeps)
@set_option
@click.option("--samples", type=int, metavar="N", help="Run a scene at N samples of its constants.")
@click.option("--seed", type=int, metavar="N", help="Seed of the samples (0).")
@click.option("--processes", type=int, metavar="N", help="Worker processes (all cores).")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, tcp://HOST:PORT, instead.")
@path_option("--store", "FOLDER", "Folder for the runs (default SWEEP.store).")
@path_option("--output", "FILE.nc", "File for the cells' numbers (default SWEEP.nc).")
@click.option("--force", is_flag=True, help="Also overwrite a file of another origin.")
@json_option
@limit_options
def sweep(sweep: str, **options: Any) -> int:
    """Run a scene for many values of its fields.

    SWEEP is a TOML file with these values, or the name of a shipped sweep (`longwave list sweeps`).
    Runs are saved in a folder: repeat an interrupted command to resume it. A cell that fails is
    recorded with its error.

    With --samples, SWEEP is a scene whose lattice file has the covariance of its constants, as
    `longwave fit` writes it. Each observable is then printed with its 95 % interval.
    """
    from longwave.cli.sweep_command import sweep_and_print

    return sweep_and_print(sweep, command_name(), **options)


@longwave.command(epilog=example("longwave plot rogue_cn_k_0.5 --output rogue_cn.pdf"))
@click.argument("source", shell_complete=complete_scenes)
@path_option("--output", "FILE", "PNG, PDF or SVG (default SOURCE.png).")
@set_option
@click.option(
    "--kind",
    type=click.Choice(RUN_PICTURES + SWEEP_PICTURES),
    default="all",
    help="Kind of picture.",
)
@click.option("--variable", metavar="NAME", default="error", help="For a sweep: what to draw.")
@click.option(
    "--at",
    metavar="NAME=VALUE,...",
    multiple=True,
    callback=lambda _, __, texts: named_values("--at", texts, "eps=0.1"),
    help="For a sweep: draw these cells.",
)
@click.option(
    "--columns",
    type=int,
    default=2,
    show_default=True,
    help="Width in columns of a journal, 1 or 2.",
)
@force_option
@limit_options
def plot(source: str, **options: Any) -> int:
    """Draw a run or a sweep, or run a scene and draw it.

    SOURCE is a run written by `longwave run SCENE --output run.nc`, a scene's TOML file or the name
    of a shipped scene. The pictures are the snapshots against the wave, the space-time map, the
    spectra, the error curves and the track of the crest: all that the run has, or one kind.
    For a sweep's file they are one number of its cells over the swept fields, as curves or heat
    maps, and the errors against the work.
    """
    from longwave.cli.plot_command import plot_and_print

    return plot_and_print(source, command_name(), **options)


@longwave.command(epilog=example("longwave animate rational_3_eps_0.05 --times -2000 2000"))
@click.argument("source", shell_complete=complete_scenes)
@path_option("--output", "FILE", "MP4 or GIF (default SOURCE.mp4; SOURCE.gif without ffmpeg).")
@set_option
@click.option("--duration", type=float, default=6.0, show_default=True, help="Seconds.")
@click.option("--fps", type=float, default=25.0, show_default=True, help="Frames a second.")
@click.option("--dpi", type=float, default=110.0, show_default=True, help="Pixels an inch.")
@click.option("--times", type=float, nargs=2, metavar="T1 T2", help="Show these lattice times.")
@force_option
@limit_options
def animate(
    source: str, output: str | None, force: bool, changes: dict[str, Any], **options: Any
) -> int:
    """Make a film of a run, or of a scene.

    SOURCE is a run written by `longwave run SCENE --output run.nc`, whose snapshots are the frames,
    a scene's TOML file or the name of a shipped scene, which is run with a snapshot for each frame.
    Lattice and wave are shown in the frame moving at the speed of sound, with time and error.
    """
    from longwave.reports.pictures.animation import draw_film

    return draw_film(source, output, options, command_name(), force, changes)


longwave.add_command(report)


@longwave.command(epilog=example("longwave converge toda_soliton --eps 0.2,0.14,0.1,0.07"))
@click.argument("scene", shell_complete=complete_scenes)
@click.option("--eps", metavar="E1,E2,...", help="Values (2, 1.4, 1, 0.7 times the scene's).")
@click.option("--tolerance", type=float, metavar="X", help="Replaces the scene's tolerance.")
@set_option
@path_option("--output", "FILE", "Draw it: PNG, PDF or SVG.")
@force_option
@json_option
@limit_options
def converge(scene: str, **options: Any) -> int:
    """Run a scene at several eps and fit its rate.

    SCENE is a TOML file or the name of a shipped scene with a tolerance (`longwave list
    lattice-scenes`). Slow times and the compared range of X do not change. The table shows each
    error next to the numerical error of the run itself.
    """
    from longwave.cli.converge import converge_and_draw

    return converge_and_draw(scene, command_name(), **options)


@longwave.command(epilog=example("longwave explore --no-browser --port 5006"))
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Port of the page (default any free one).",
)
@click.option("--no-browser", is_flag=True, help="Print the address and open nothing.")
@limits_of_each(memory="2G", time="10s")
def explore(port: int, no_browser: bool) -> int:
    """Compare lattice and wave in the browser.

    The page is served to this machine alone, until Ctrl-C. The limits apply to each run that is
    chosen there. The page requires the extra `explore`:
    pip install 'longwave[explore]'.
    """
    from longwave.explore.explore_server import explore as serve

    return serve(port, not no_browser, command_name())


@longwave.command("list", epilog=example("longwave list waves --json"))
@click.argument("kind", required=False, type=click.Choice(INVENTORY_KINDS), metavar="[KIND]")
@click.option("--library", is_flag=True, help="Show the published solutions instead.")
@json_option
def list_(kind: str | None, library: bool, json_wanted: bool) -> int:
    """Show lattices, waves, schemes, scenes and more.

    KIND is one of these words; without it, all kinds are shown.
    """
    if library:
        if kind:
            raise click.UsageError(f"--library must not be given with KIND, got {kind} as well")
        from longwave.verify.published import print_library, records

        click.echo(json.dumps(records(), indent=2)) if json_wanted else print_library()
        return 0
    from longwave.cli.inventory import inventory, print_tables

    records_by_kind = inventory((kind,) if kind else INVENTORY_KINDS)
    if json_wanted:
        click.echo(json.dumps(records_by_kind[kind] if kind else records_by_kind, indent=2))
    else:
        print_tables(records_by_kind)
    return 0


@longwave.command(epilog=example("longwave doctor --json"))
@json_option
def doctor(json_wanted: bool) -> int:
    """Show what is installed, and what each missing piece costs."""
    from longwave.cli.health import examine, print_findings

    findings = examine()
    if json_wanted:
        click.echo(json.dumps([finding.json() for finding in findings], indent=2))
    else:
        print_findings(findings)
    return 1 if any(finding.state == "broken" for finding in findings) else 0
