"""The words of the command line and their options: one tree, declared with click.

Nothing of the rooms is imported before a command runs, so help and completion answer at once.
"""

import json
import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem, get_completion_class

from derive.__main__ import derive
from derive.command_line import example, fail

COMPLETION = "_LONGWAVE_COMPLETE"
"""The environment variable by which a shell asks for completions."""

ENGINES = ("stencil", "spectral")
METHODS = ("proof", "residual")
KINDS = ("lattices", "waves", "schemes", "scenes", "observables")
PICTURES = ("all", "snapshots", "space_time", "errors", "crest")
SHELLS = ("bash", "zsh", "fish")


class Words(click.Group):
    """A group whose unknown word is told together with the known ones."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the first word; a UsageError lists the words if it is none."""
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            known = ", ".join(self.commands)
            raise click.UsageError(f"COMMAND must be a known one, got {args[0]} (one of {known})")
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The words in the order in which they are declared."""
        return list(self.commands)


def _program() -> str:
    """What the command was called by, as in `longwave verify mutations`."""
    return click.get_current_context().command_path


def _version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        from importlib.metadata import version

        click.echo(f"longwave {version('longwave')}")
        context.exit()


def _completion(context: click.Context, _: click.Parameter, shell: str | None) -> None:
    found = get_completion_class(shell) if shell else None
    if found is not None and not context.resilient_parsing:
        click.echo(found(longwave, {}, "longwave", COMPLETION).source())
        context.exit()


def _scenes(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    """Files, where a path or nothing that is shipped has been begun, else the shipped scenes."""
    names = [name for name in scene_names() if name.startswith(begun)]
    items = [CompletionItem(name) for name in names]
    return items if begun and names else [*items, CompletionItem(begun, type="file")]


def scene_names() -> list[str]:
    """The names of the shipped scenes, found as files: importing the lattice takes seconds."""
    spec = find_spec("verify")
    roots = (spec.submodule_search_locations if spec else None) or ()
    return sorted(path.stem for root in roots for path in Path(root, "comparison").rglob("*.toml"))


def _waves(_: click.Context, __: click.Parameter, begun: str) -> list[str]:
    from solutions.catalogue import CATALOGUE

    return [name for name in CATALOGUE.names if name.startswith(begun)]


_json = click.option("--json", "json_wanted", is_flag=True, help="Print JSON.")
_only = click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    shell_complete=_waves,
    help="Take this form; may be repeated.",
)


@click.group(
    cls=Words,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=example("longwave run rogue_cn_k_0.5")
    + "\n\nExit status: 0 all is well, 1 something is refuted, undecided, missing or broke off, "
    "2 wrong input, 130 Ctrl-C.",
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_version,
    help="Print it.",
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


longwave.add_command(derive)


@longwave.command(epilog=example("longwave prove rogue_cn --output rogue_cn.json"))
@click.argument("names", nargs=-1, metavar="[NAME]...", shell_complete=_waves)
@click.option(
    "--certificate", metavar="FILE", type=click.Path(), help="Check the proofs in this file."
)
@click.option("--output", metavar="FILE", type=click.Path(), help="Write the proofs' certificates.")
@_json
def prove(
    names: tuple[str, ...], certificate: str | None, output: str | None, json_wanted: bool
) -> int:
    """Prove closed forms by name, or check the proofs in a file.

    What is proved holds for all X and T, all lattice constants and all parameters of the form.
    `longwave list waves` shows the names; rational_<j> is there for every order j.
    """
    if bool(names) == (certificate is not None):
        got = "both" if names else "neither"
        raise click.UsageError(
            f"either NAME or --certificate FILE must be given, got {got} "
            "(--output FILE writes certificates)"
        )
    if certificate is None:
        from verify.cli.verdicts import Options, print_verdicts

        path = None if output is None else Path(output)
        return print_verdicts(
            Options(only=tuple(dict.fromkeys(names)), json=json_wanted, certificate=path),
            _program(),
        )
    if output is not None:
        raise click.UsageError("--output must not be given with --certificate, got both")
    from verify.cli.certificates import print_certificates

    return print_certificates(Path(certificate), json_wanted)


@longwave.group(
    cls=Words,
    invoke_without_command=True,
    subcommand_metavar="[COMMAND [ARGS]...]",
    epilog=example("longwave verify --digits 30,50,100"),
)
@_only
@click.option("--json", "json_wanted", is_flag=True, help="Print the verdicts as JSON.")
@click.option("--certificate", metavar="FILE", type=click.Path(), help="Write the certificates.")
@click.option("--stable", is_flag=True, help="Prove instead that evaluation form = canonical form.")
@click.option("--method", type=click.Choice(METHODS), help="A residual is evidence, no proof.")
@click.option("--digits", metavar="D1,D2,...", help="Increasing precisions of the residual.")
@click.option("--points", type=int, help="Random points a form for the residual.")
@click.option("--seed", type=int, help="Seed of the points.")
def verify(
    only: tuple[str, ...],
    json_wanted: bool,
    certificate: str | None,
    digits: str | None,
    **how: Any,
) -> int:
    """Prove every closed form, or measure its residual.

    The words below check certificates and misprints, and measure the evaluation.
    """
    context = click.get_current_context()
    if context.invoked_subcommand is not None:
        given = [name for name in context.params if context.params[name] not in (None, False, ())]
        if given:
            option = "json" if given[0] == "json_wanted" else given[0]
            raise click.UsageError(
                f"--{option} must stand behind the word that it is meant for, got it before "
                f"{context.invoked_subcommand}"
            )
        return 0
    from verify.cli.verdicts import Options, digits_in, print_verdicts

    try:
        precisions = None if digits is None else digits_in(digits)
    except ValueError as error:
        return fail(error)
    path = None if certificate is None else Path(certificate)
    options = Options(only, json_wanted, path, digits=precisions, **how)
    return print_verdicts(options, _program())


@verify.command("check-certificate", epilog=example("longwave verify check-certificate c.json"))
@click.argument("file", type=click.Path())
@_json
def check_certificate(file: str, json_wanted: bool) -> int:
    """Repeat the proofs in FILE with other arithmetic."""
    from verify.cli.certificates import print_certificates

    return print_certificates(Path(file), json_wanted)


@verify.command(epilog=example("longwave verify mutations --only kink"))
@_only
@_json
def mutations(only: tuple[str, ...], json_wanted: bool) -> int:
    """Refute every misprint of the closed forms."""
    from verify.cli.mutations import print_mutations

    return print_mutations(only, json_wanted, _program())


@verify.command(epilog=example("longwave verify accuracy --only kink --drawn 10"))
@_only
@click.option("--jobs", type=int, help="Processes (default all cores).")
@click.option("--drawn", type=int, help="Random cases a wave.")
@_json
def accuracy(only: tuple[str, ...], jobs: int | None, drawn: int | None, json_wanted: bool) -> int:
    """Measure the evaluation of every wave."""
    from verify.cli.accuracy import accuracy_command

    words = [f"--only={name}" for name in only]
    words += [f"--jobs={jobs}"] if jobs is not None else []
    words += [f"--drawn={drawn}"] if drawn is not None else []
    return accuracy_command([*words, *(["--json"] if json_wanted else [])])


@click.command(epilog=example("longwave run rational_2_eps_0.05 --tolerance 1e-3"))
@click.argument("scene", shell_complete=_scenes)
@click.option(
    "--tolerance",
    type=float,
    metavar="X",
    help="Sup error of y/eps to be kept; step and domain are then chosen by the program.",
)
@click.option("--engine", metavar="E", help=f"{' or '.join(ENGINES)}, with a tolerance.")
@click.option("--output", metavar="FILE.nc", type=click.Path(), help="Write the run as netCDF.")
def run(**options: Any) -> int:
    """Run the lattice from a wave and compare the two.

    SCENE is a TOML file or the name of a shipped scene (`longwave list scenes`).
    """
    from verify.cli.run import Options, run_and_print

    return run_and_print(Options(**options), _program())


longwave.add_command(run)
verify.add_command(run)


@longwave.command(epilog=example("longwave plot rogue_cn_k_0.5 --output rogue_cn.pdf"))
@click.argument("source", shell_complete=_scenes)
@click.option(
    "--output", metavar="FILE", type=click.Path(), help="PNG, PDF or SVG (default SOURCE.png)."
)
@click.option("--kind", type=click.Choice(PICTURES), default="all", help="Which picture.")
def plot(source: str, output: str | None, kind: str) -> int:
    """Draw a run, or run a scene and draw it.

    SOURCE is a run written by `longwave run SCENE --output run.nc`, a scene's TOML file or the name
    of a shipped scene. The pictures are the snapshots against the wave, the space-time map, the
    error curves and the track of the crest: all that the run holds, or one kind.
    """
    from longwave.plotting import draw

    return draw(source, output, kind, _program())


@longwave.command(epilog=example("longwave report --output report"))
@click.option("--output", metavar="FOLDER", type=click.Path(), help="Where it is written.")
@click.option("--full", is_flag=True, help="Take the long scenes and the full studies as well.")
@click.option("--workers", type=int, metavar="N", help="Processes to use (default all cores).")
def report(output: str | None, full: bool, workers: int | None) -> int:
    """Derive, check and run everything, and write it as a PDF.

    It goes to the folder longwave-report in the working folder.
    """
    from reports.__main__ import FOLDER, Options, write_report

    folder = FOLDER if output is None else Path(output)
    processes = os.cpu_count() or 1 if workers is None else workers
    return write_report(Options(folder, full, processes), _program())


@longwave.command("list", epilog=example("longwave list waves --json"))
@click.argument("kind", required=False, type=click.Choice(KINDS), metavar="[KIND]")
@_json
def list_(kind: str | None, json_wanted: bool) -> int:
    """Show lattices, waves, schemes, scenes or observables.

    KIND is one of these words; without it all are shown.
    """
    from longwave.inventory import inventory, print_tables

    found = inventory((kind,) if kind else KINDS)
    if json_wanted:
        click.echo(json.dumps(found[kind] if kind else found, indent=2))
    else:
        print_tables(found)
    return 0


@longwave.command(epilog=example("longwave doctor --json"))
@_json
def doctor(json_wanted: bool) -> int:
    """Show what is installed, and what each missing piece costs."""
    from longwave.health import examine, print_findings

    findings = examine()
    if json_wanted:
        click.echo(json.dumps([finding.json() for finding in findings], indent=2))
    else:
        print_findings(findings)
    return 1 if any(finding.state == "broken" for finding in findings) else 0
