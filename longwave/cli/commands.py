"""The words of ``python -m verify``, which are those of ``longwave verify`` and ``prove``.

Nothing of the room is imported before a command runs, so help and completion answer at once.
"""

from pathlib import Path
from typing import Any

import click

from longwave.support.command_line import (
    CommandGroup,
    called_by,
    example,
    force_option,
    json_option,
    limit_options,
)

METHODS = ("proof", "residual")
ALGEBRA_SYSTEMS = ("pari", "maxima", "coq")


def complete_waves(_: click.Context, __: click.Parameter, begun: str) -> list[str]:
    """The closed forms whose names begin like that."""
    from longwave.solutions.catalogue import CATALOGUE

    return [name for name in CATALOGUE.names if name.startswith(begun)]


def complete_provable(context: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
    """The closed forms whose names begin like that, or with --library the statements there."""
    if not context.params.get("library"):
        return complete_waves(context, parameter, begun)
    from longwave.verify.published import published

    return [text.name for text in published() if text.name.startswith(begun)]


_only = click.option(
    "--only",
    multiple=True,
    metavar="NAME",
    shell_complete=complete_waves,
    help="Take this form; may be repeated.",
)


STATEMENT_OPTIONS = ("parameters", "domain", "variables", "solve", "limit", "latex", "scheduler")
"""What is said of a statement in text, and of no closed form."""


@click.command(
    epilog=example("longwave prove rogue_cn --output rogue_cn.json")
    + '\n  longwave prove --equation "u_t + c*u_x" --solution "u = sin(x - c*t)"'
)
@click.argument("names", nargs=-1, metavar="[NAME|FILE.toml]...", shell_complete=complete_provable)
@click.option("--equation", "equations", multiple=True, metavar="TEXT", help="As u_t + u*u_x = 0.")
@click.option("--solution", "solutions", multiple=True, metavar="TEXT", help="As u = x/t.")
@click.option("--parameters", metavar="TEXT", help="Domains and names, as k: k>0; m = k**2.")
@click.option("--domain", metavar="TEXT", help="Of the variables, as t > 0.")
@click.option("--variables", metavar="NAMES", help="As r,t (default x, y, z, t and n).")
@click.option("--solve", metavar="NAMES", help="For which values of c, b does it hold?")
@click.option("--library", is_flag=True, help="The published solutions; NAME chooses among them.")
@click.option("--limit", type=float, metavar="SECONDS", help="For a statement (default 60).")
@click.option("--scheduler", metavar="ADDRESS", help="Decide on a Dask cluster, tcp://HOST:PORT.")
@click.option("--latex", is_flag=True, help="Print a sentence on each statement in LaTeX.")
@click.option(
    "--certificate",
    metavar="FILE",
    type=click.Path(),
    help="Write the proofs of statements; without any: check the proofs in this file.",
)
@click.option("--output", metavar="FILE", type=click.Path(), help="Write the proofs' certificates.")
@click.option(
    "--export",
    "system",
    type=click.Choice(ALGEBRA_SYSTEMS),
    help="Write scripts to --output in place of certificates.",
)
@force_option
@json_option
@limit_options
def prove(names: tuple[str, ...], **options: Any) -> int:
    """Prove formulas of your own or by name, or check proofs.

    A formula of your own is stated by --equation and --solution, or with others in a FILE.toml of
    [[problem]] tables; --library decides the published solutions that come with the package.
    Closed forms are proved for all X and T, all lattice constants and all their
    parameters; `longwave list waves` shows the names; rational_<j> is there for every order j.
    """
    if options["system"] and not options["output"]:
        raise click.UsageError("--export must be given with --output FILE, got no file")
    files = [name for name in names if name.endswith(".toml") or name == "-"]
    if options["equations"] or options["solutions"] or options["library"] or files:
        return _prove_statements(names, files, options)
    for option in STATEMENT_OPTIONS:
        if options[option]:
            raise click.UsageError(f"--{option} must stand with --equation or FILE.toml, got none")
    return _prove_names(names, options)


def _prove_statements(names: tuple[str, ...], files: list[str], options: dict[str, Any]) -> int:
    """Decide statements in text; raises UsageError for options that contradict each other."""
    texts = bool(options["equations"]), bool(options["solutions"])
    written, library = options.pop("output"), options.pop("library")
    scripts = written if options["system"] else None
    if any(texts) and (names or library or not all(texts)):
        missing = "no --solution" if texts[0] else "no --equation"
        others = (*names, "--library") if library else names
        got = f"{others[0]} as well" if others else missing
        raise click.UsageError(f"--equation must be given with --solution alone, got {got}")
    stated = "--library" if library else "a FILE.toml" if files else ""
    for wrong, option, other in (
        (library and files, "FILE.toml", "--library"),
        (not library and len(files) < len(names), "FILE.toml", "names of forms"),
        (stated and options["parameters"], "--parameters", stated),
        (stated and options["domain"], "--domain", stated),
        (stated and options["variables"], "--variables", stated),
        (stated and options["solve"], "--solve", stated),
        (scripts and options["solve"], "--solve", "--export"),
        (options["json_wanted"] and options["latex"], "--json", "--latex"),
        (options["certificate"] and written and not scripts, "--certificate", "--output"),
    ):
        if wrong:
            raise click.UsageError(f"{option} must not be given with {other}, got both")
    from longwave.cli.statements import Options, print_statement_verdicts

    options["certificate"] = options["certificate"] or (None if scripts else written)
    chosen = names if library else None
    stated_options = Options(files=files, library=chosen, scripts=scripts, **options)
    return print_statement_verdicts(stated_options, called_by())


def _prove_names(names: tuple[str, ...], options: dict[str, Any]) -> int:
    """Prove closed forms, or check a file; raises UsageError unless it is one of both."""
    certificate, output, system = (options[key] for key in ("certificate", "output", "system"))
    if bool(names) == (certificate is not None):
        got = "both" if names else "neither"
        raise click.UsageError(
            f"either NAME or --certificate FILE must be given, got {got} "
            "(--output FILE writes certificates)"
        )
    if certificate is None:
        from longwave.cli.verdicts import VerdictOptions, print_verdicts

        chosen = tuple(dict.fromkeys(names))
        verdicts = VerdictOptions(
            chosen, options["json_wanted"], output, system=system, force=options["force"]
        )
        return print_verdicts(verdicts, called_by())
    if output is not None and system is None:
        raise click.UsageError("--output must not be given with --certificate, got both")
    from longwave.cli.certificates import print_certificates
    from longwave.cli.exporting import Scripts

    scripts = None if system is None else Scripts(output, system, options["force"])
    return print_certificates(Path(certificate), options["json_wanted"], scripts)


@click.group(
    cls=CommandGroup,
    invoke_without_command=True,
    subcommand_metavar="[COMMAND [ARGS]...]",
    epilog=example("longwave verify --digits 30,50,100"),
)
@_only
@click.option("--json", "json_wanted", is_flag=True, help="Print the verdicts as JSON.")
@click.option("--certificate", metavar="FILE", type=click.Path(), help="Write the certificates.")
@force_option
@click.option("--stable", is_flag=True, help="Prove instead that evaluation form = canonical form.")
@click.option("--method", type=click.Choice(METHODS), help="A residual is evidence, no proof.")
@click.option("--digits", metavar="D1,D2,...", help="Increasing precisions of the residual.")
@click.option("--points", type=int, help="Random points a form for the residual.")
@click.option("--seed", type=int, help="Seed of the points.")
@limit_options
def verify(**options: Any) -> int:
    """Prove every closed form, or measure its residual.

    The words below check misprints and proofs by other systems, and measure the evaluation.
    """
    subcommand = click.get_current_context().invoked_subcommand
    if subcommand is not None:
        given = [name for name, value in options.items() if value not in (None, False, ())]
        if given:
            option = given[0].removesuffix("_wanted")
            raise click.UsageError(
                f"--{option} must stand behind the word that it is meant for, got it before "
                f"{subcommand}"
            )
        return 0
    from longwave.cli.verdicts import VerdictOptions, print_verdicts

    return print_verdicts(VerdictOptions(**options), called_by())


@click.command(epilog=example("longwave check c.json"))
@click.argument("file", type=click.Path(path_type=Path))
@json_option
def check(file: Path, json_wanted: bool) -> int:
    """Repeat the proofs in FILE with other arithmetic."""
    from longwave.cli.certificates import print_certificates

    return print_certificates(file, json_wanted)


@verify.command(epilog=example("longwave verify recheck --only kink"))
@click.option("--only", multiple=True, metavar="NAME", help="Take this form or statement.")
@click.option("--limit", type=float, metavar="SECONDS", help="For a system and a proof.")
@json_option
@limit_options
def recheck(only: tuple[str, ...], limit: float | None, json_wanted: bool) -> int:
    """Let PARI/GP, Maxima and Coq repeat the proofs.

    Those of all closed forms and of the library, without --only.
    """
    from longwave.cli.recheck import print_rechecks

    return print_rechecks(only, limit, json_wanted, called_by())


@verify.command(epilog=example("longwave verify mutations --only kink"))
@_only
@json_option
@limit_options
def mutations(only: tuple[str, ...], json_wanted: bool) -> int:
    """Refute every misprint of the closed forms."""
    from longwave.cli.verdicts import print_mutations

    return print_mutations(only, json_wanted, called_by())


@verify.command(epilog=example("longwave verify accuracy --only kink --drawn 10"))
@_only
@click.option("--jobs", type=int, help="Processes (default all cores).")
@click.option("--drawn", type=int, help="Random cases a wave.")
@json_option
@limit_options
def accuracy(only: tuple[str, ...], jobs: int | None, drawn: int | None, json_wanted: bool) -> int:
    """Measure the evaluation of every wave."""
    from longwave.cli.accuracy import print_accuracy

    return print_accuracy(only, jobs, drawn, json_wanted, called_by())
