"""The commands about proofs: `prove`, `library`, `check`, and `verify` with its subcommands.

No room is imported before a command runs, so that help and completion answer at once.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from longwave.support import command_line

METHODS = ("proof", "residual")
EXPORT_SYSTEMS = ("pari", "maxima", "coq")

Wrapped = TypeVar("Wrapped", bound=Callable[..., Any])


def complete_waves(_: click.Context, __: click.Parameter, prefix: str) -> list[str]:
    """Return the names of closed forms that start with ``prefix``."""
    from longwave.solutions.catalogue import CATALOGUE

    return [name for name in CATALOGUE.names if name.startswith(prefix)]


def complete_published(_: click.Context, __: click.Parameter, prefix: str) -> list[str]:
    """Return the names of published statements that start with ``prefix``."""
    from longwave.verify.published import published

    return [text.name for text in published() if text.name.startswith(prefix)]


_only = click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    shell_complete=complete_waves,
    help="Take this form; may be repeated.",
)
_export = click.option(
    "--export",
    "system",
    type=click.Choice(EXPORT_SYSTEMS),
    help="Write scripts for this system to --output, no certificates.",
)


_certificates = command_line.path_option("--output", "FILE", "Write the proofs' certificates.")


def _decision_options(command: Wrapped) -> Wrapped:
    """Decorate a command with the options for deciding statements that are given as text."""
    for option in (
        command_line.limit_options,
        command_line.json_option,
        command_line.force_option,
        _export,
        _certificates,
        click.option("--latex", is_flag=True, help="Print a sentence on each in LaTeX."),
        click.option("--scheduler", metavar="ADDRESS", help="A Dask cluster, tcp://HOST:PORT."),
        click.option("--limit", type=float, metavar="SECONDS", help="Limit for each (default 60)."),
        click.option("--keep-going", is_flag=True, help="Decide the others if one is unreadable."),
        command_line.path_option(
            "--lines", "FILE.jsonl", "Append each verdict; skip those already in it."
        ),
    ):
        command = option(command)
    return command


def _refuse_both(*pairs: tuple[object, str, object, str]) -> None:
    """Raise UsageError if two options are both given; a pair is (value, name, value, name)."""
    for one, option, other, name in pairs:
        if one and other:
            raise click.UsageError(f"{option} must not be given with {name}, got both")


CERTIFICATE_HINT = "--output FILE writes certificates, longwave check FILE repeats them;"
HINTS = {"--certificate": CERTIFICATE_HINT}


@click.command(
    epilog=command_line.example(
        'longwave prove --equation "u_t + c*u_x" --solution "u = sin(x - c*t)"'
    )
    + "\n  longwave prove problems.toml --output proofs.json",
    context_settings={"obj": HINTS | {"--library": "write longwave library;"}},
)
@click.argument("files", nargs=-1, metavar="[FILE.toml]...", type=click.Path())
@click.option(
    "--equation", "equations", multiple=True, metavar="TEXT", help="Such as u_t + u*u_x = 0."
)
@click.option("--solution", "solutions", multiple=True, metavar="TEXT", help="Such as u = x/t.")
@click.option("--parameters", metavar="TEXT", help="Domains and names, such as k: k>0; m = k**2.")
@click.option("--domain", metavar="TEXT", help="Domain of the variables, such as t > 0.")
@click.option("--variables", metavar="NAMES", help="Such as r,t (default x, y, z, t and n).")
@click.option("--solve", metavar="NAMES", help="For which values of c, b does it hold?")
@click.option("--weak", is_flag=True, help="As a weak solution, across its jump or corner?")
@_decision_options
def prove(files: tuple[str, ...], **options: Any) -> int:
    """Prove formulas of your own.

    State one with --equation and --solution, which may be repeated, or several as [[problem]]
    tables in a FILE.toml or on the standard input (-). `longwave verify` proves the shipped closed
    forms, `longwave library` published solutions.
    """
    for name in files:
        if not name.endswith(".toml") and name != "-":
            raise click.UsageError(
                f"FILE must end in .toml, got {name} (a closed form: longwave verify --only "
                f"{name}; a published solution: longwave library {name})"
            )
    stated = bool(options["equations"]), bool(options["solutions"])
    if not files and not any(stated):
        raise click.UsageError("--equation or FILE.toml must be given, got neither")
    if any(stated) and (files or not all(stated)):
        missing = "no --solution" if stated[0] else "no --equation"
        got = f"{files[0]} as well" if files else missing
        raise click.UsageError(f"--equation must be given with --solution and no file, got {got}")
    typed = ("parameters", "domain", "variables", "solve", "weak")
    _refuse_both(
        *((options[name], f"--{name}", files, "a FILE.toml") for name in typed),
        (options["solve"], "--solve", options["system"], "--export"),
        (options["json_wanted"], "--json", options["latex"], "--latex"),
    )
    from longwave.cli.statements import prove_and_print

    return prove_and_print(command_line.command_name(), files, **options)


@click.command(
    epilog=command_line.example("longwave library kdv_one_soliton kdv_soliton_speed"),
    context_settings={"obj": HINTS},
)
@click.argument("names", nargs=-1, metavar="[NAME]...", shell_complete=complete_published)
@_decision_options
def library(names: tuple[str, ...], **options: Any) -> int:
    """Decide the shipped published solutions.

    NAME is a statement or an equation (`longwave list --library`); without it, all are decided.
    """
    _refuse_both((options["json_wanted"], "--json", options["latex"], "--latex"))
    from longwave.cli.statements import decide_library_and_print

    return decide_library_and_print(command_line.command_name(), names, **options)


@click.command(epilog=command_line.example("longwave check c.json"))
@click.argument("file", type=click.Path(path_type=Path))
@command_line.path_option("--output", "FILE", "Write the scripts of --export.")
@_export
@command_line.force_option
@command_line.json_option
def check(file: Path, **options: Any) -> int:
    """Repeat the proofs in FILE with other arithmetic."""
    from longwave.cli.certificates import print_certificates

    return print_certificates(file, **options)


@click.group(
    cls=command_line.CommandGroup,
    otherwise="--only NAME takes a form",
    invoke_without_command=True,
    subcommand_metavar="[COMMAND [ARGS]...]",
    epilog=command_line.example("longwave verify --only kink --output kink.json"),
    context_settings={"obj": HINTS},
)
@_only
@command_line.json_option
@_certificates
@_export
@command_line.force_option
@click.option("--stable", is_flag=True, help="Prove instead that evaluation form = canonical form.")
@click.option("--method", type=click.Choice(METHODS), help="A residual is evidence, not a proof.")
@click.option("--digits", metavar="D1,D2,...", help="Increasing precisions of the residual.")
@click.option("--points", type=int, help="Random points for each form's residual.")
@click.option("--seed", type=int, help="Seed of the random points.")
@command_line.limit_options
def verify(**options: Any) -> int:
    """Prove every closed form, or measure its residual.

    Forms are proved for all X and T, all lattice constants and all their parameters; `longwave list
    waves` shows the names; rational_<j> exists for every order j. The commands below refute
    misprints, repeat proofs by other systems, and measure the evaluation.
    """
    context = click.get_current_context()
    if context.invoked_subcommand is not None:
        for parameter in context.command.params:
            if options.get(str(parameter.name)) not in (None, False, ()):
                raise click.UsageError(
                    f"{parameter.opts[0]} must stand after the command to which it applies, got "
                    f"it before {context.invoked_subcommand}"
                )
        return 0
    from longwave.cli.verdicts import print_verdicts

    return print_verdicts(command_line.command_name(), **options)


@verify.command(epilog=command_line.example("longwave verify recheck --only kink"))
@click.option("--only", multiple=True, metavar="NAME", help="Take this form or statement.")
@click.option("--limit", type=float, metavar="SECONDS", help="Limit for each system and proof.")
@command_line.json_option
@command_line.limit_options
def recheck(only: tuple[str, ...], limit: float | None, json_wanted: bool) -> int:
    """Let PARI/GP, Maxima and Coq repeat the proofs.

    Without --only, all closed forms and the library are taken.
    """
    from longwave.cli.recheck import print_rechecks

    return print_rechecks(only, limit, json_wanted, command_line.command_name())


@verify.command(epilog=command_line.example("longwave verify mutations --only kink"))
@_only
@command_line.json_option
@command_line.limit_options
def mutations(only: tuple[str, ...], json_wanted: bool) -> int:
    """Refute every misprint of the closed forms."""
    from longwave.cli.verdicts import print_mutations

    return print_mutations(only, json_wanted, command_line.command_name())


@verify.command(epilog=command_line.example("longwave verify accuracy --only kink --drawn 10"))
@_only
@click.option("--jobs", type=int, help="Processes (default all cores).")
@click.option("--drawn", type=int, help="Random cases for each wave.")
@command_line.json_option
@command_line.limit_options
def accuracy(only: tuple[str, ...], jobs: int | None, drawn: int | None, json_wanted: bool) -> int:
    """Measure the evaluation of every wave."""
    from longwave.cli.accuracy import print_accuracy

    return print_accuracy(only, jobs, drawn, json_wanted, command_line.command_name())
