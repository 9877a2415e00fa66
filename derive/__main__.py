"""Command ``python -m derive``, the same as ``longwave derive``: print a reduction.

The help text needs no further imports; SymPy is imported for the derivation.
"""

import sys
from collections.abc import Callable, Sequence
from typing import Any

import click

from longwave.support.command_line import example, limit_options, named_values, run_words

CONSTANTS = ("K2", "K3", "K4")
"""Names of the constants of the strain FPUT lattice."""


def _constant_options(function: Callable[..., Any]) -> Callable[..., Any]:
    for name in reversed(CONSTANTS):
        help_text = f"Value of {name}: a number or a formula, with eps where it is small."
        option = click.option(f"--{name.lower()}", name, metavar="VALUE", help=help_text)
        function = option(function)
    return function


@click.command(
    epilog=example("longwave derive mass_dimer --set m1=1,m2=3,K2=1,K3=1/4,K4=0 --latex")
)
@click.argument("words", nargs=-1, metavar="[check] [MODEL|FILE.toml]")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE,...", help="Values of constants.")
@click.option(
    "--losses",
    multiple=True,
    metavar="NAME=VALUE,...",
    help="Losses of cells and of dashpots beside springs: site=eps^3*gamma,bond=eps*eta.",
)
@click.option(
    "--background",
    metavar="VALUE",
    help="Uniform strain that carries the waves, such as -K3/(3*K4).",
)
@click.option(
    "--direction", metavar="ANGLE|A,B", help="Direction on a square lattice: pi/4, or 3,4."
)
@click.option("--amplitude", metavar="N", help="Power of eps of the wave; found unless given.")
@click.option("--time", metavar="N", help="Power of eps of the slow time; found unless given.")
@click.option("--order", "--orders", "orders", metavar="N", help="Highest power of eps.")
@click.option("--envelope", "carrier", metavar="k[=NUMBER]", help="The envelope of a carrier wave.")
@click.option("--branch", metavar="NAME", help="acoustic, optical or a number, of the carrier.")
@click.option("--map", "points", metavar="N", help="Growth rates at N wavenumbers.")
@click.option("--latex", is_flag=True, help="Print LaTeX.")
@click.option("--json", "json_wanted", is_flag=True, help="Print one JSON document.")
@_constant_options
@limit_options
def derive(
    words: tuple[str, ...],
    sets: tuple[str, ...],
    losses: tuple[str, ...],
    latex: bool,
    json_wanted: bool,
    **options: str | None,
) -> int:
    """Derive the long-wave or envelope equation of a lattice.

    Without a MODEL it is the paper's strain FPUT lattice; `longwave list lattices` shows the
    others, and a FILE.toml may hold one of your own. With `check` the result is compared with plane
    waves, a manufactured wave and the static stress law.
    """
    if latex and json_wanted:
        raise click.UsageError("--json must not be given with --latex, got both (leave one)")
    check = words[:1] == ("check",)
    models = words[1:] if check else words
    if len(models) > 1:
        raise click.UsageError(f"MODEL must be one, got {' '.join(models)} (derive them in turn)")
    given = {name: text for name in CONSTANTS if (text := options.pop(name)) is not None}
    for name, value in named_values("--set", sets).items():
        if name in given:
            raise click.UsageError(
                f"{name} must be given once, got --{name.lower()} {given[name]} and --set "
                f"{name}={value} (leave one out)"
            )
        given[name] = value
    from longwave.derive.output.derive_options import DeriveOptions
    from longwave.derive.output.printout import print_derivation

    return print_derivation(
        DeriveOptions(
            model=models[0] if models else None,
            constants=given,
            losses=named_values("--losses", losses, "site=eps^3*gamma,bond=eps*eta"),
            form="json" if json_wanted else "latex" if latex else "text",
            check=check,
            **options,
        )
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status (2 for wrong input)."""
    return run_words(derive, "python -m derive", arguments)


if __name__ == "__main__":
    sys.exit(main())
