"""Options of ``longwave derive``, and the values of constants that they give."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from sympy import Expr, Symbol

from longwave.derive.lattice import Lattice
from longwave.derive.measured import Measured
from longwave.derive.symbols import constant_value


@dataclass(frozen=True)
class DeriveOptions:
    """Options of the command line as text; None if an option is not given."""

    model: str | None = None
    constants: Mapping[str, str] = field(default_factory=dict)
    losses: Mapping[str, str] = field(default_factory=dict)
    background: str | None = None
    amplitude: str | None = None
    time: str | None = None
    orders: str | None = None
    carrier: str | None = None
    branch: str | None = None
    points: str | None = None
    direction: str | None = None
    form: str = "text"
    check: bool = False


def given_constants(lattice: Lattice, options: DeriveOptions) -> dict[str, Expr]:
    """Return the values of constants: measured ones of the lattice, overridden by the options."""
    typed = {name: constant_value(name, text) for name, text in options.constants.items()}
    return {**(dict(lattice.measured.values) if lattice.measured else {}), **typed}


def count(option: str, text: str | None, most: int) -> int | None:
    """Return an option's value as an int from 0 to ``most``, None if it is not given.

    Raises ValueError for any other value.
    """
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 4 and int(text) <= most):
        raise ValueError(
            f"{option} must be a whole number from 0 to {most}, got {text!r} (leave it out for the "
            "default)"
        )
    return int(text)


def measured_with_options(
    lattice: Lattice,
    remaining: Iterable[Symbol],
    values: Mapping[str, Expr],
    options: DeriveOptions,
) -> tuple[Measured | None, str]:
    """Return the measured constants, exact where the user gave a value, and a note to print.

    None instead of constants if intervals are impossible: one of the ``remaining`` constants has no
    value, or a measured constant was substituted before the expansion.
    """
    if lattice.measured is None:
        return None, ""
    names = {str(symbol) for symbol in remaining}
    uncertain = {name for name, deviation in lattice.measured.deviations.items() if deviation}
    uncertain -= {*options.constants, *map(str, lattice.unfelt_constants)}
    if substituted := sorted(uncertain - names):
        names_text = ", ".join(substituted)
        return None, f"(no intervals: {names_text} had to be put in before the expansion)"
    if unknown := sorted(names - values.keys()):
        return None, f"(no intervals: {', '.join(unknown)} has no value)"
    exact = {name: value for name, value in values.items() if name not in uncertain}
    note = "(with standard deviations and 95 % intervals, by the constants' covariance)"
    return lattice.measured.with_exact(exact), note
