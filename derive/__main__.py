"""The command ``python -m derive``, which is ``longwave derive`` too: print a reduction.

Nothing is imported for the help; SymPy comes with the derivation.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import click

from derive.command_line import example, run_words

CONSTANTS = ("K2", "K3", "K4")
"""The constants of the strain FPUT lattice."""


def _constant_options(function: Callable[..., Any]) -> Callable[..., Any]:
    for name in reversed(CONSTANTS):
        said = f"Value of {name} for the coefficients (integer, decimal or ratio)."
        option = click.option(f"--{name.lower()}", name, metavar="P/Q", help=said)
        function = option(function)
    return function


@click.command(epilog=example("longwave derive --k2 1 --k4 1/3"))
@click.option("--latex", is_flag=True, help="Print LaTeX (an aligned block).")
@click.option("--json", "json_wanted", is_flag=True, help="Print one JSON document.")
@click.option("--orders", metavar="N", help="Highest power of eps.")
@_constant_options
def derive(latex: bool, json_wanted: bool, orders: str | None, **constants: str | None) -> int:
    """Derive the reduced equation and its coefficients."""
    if latex and json_wanted:
        raise click.UsageError("--json must not be given with --latex, got both (leave one)")
    from derive.output.printout import print_reduction

    return print_reduction(
        constants, orders, "json" if json_wanted else "latex" if latex else "text"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status (2 for wrong input)."""
    return run_words(derive, "python -m derive", arguments)


if __name__ == "__main__":
    sys.exit(main())
