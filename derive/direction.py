"""The direction in which a wave crosses a lattice of two axes, from text to slow variables."""

from __future__ import annotations

from sympy import Expr, Integer, Symbol, atan, cos, sin, sqrt

from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_expression import read_formula
from longwave.derive.algebra.formula_text import Vocabulary
from longwave.derive.lattice import Lattice
from longwave.derive.scaling import SlowVariable
from longwave.derive.symbols import c
from longwave.support.user_files import shown

C, S = Symbol("C", real=True), Symbol("S", real=True)
"""Cosine and sine of the direction's angle with the first axis."""

DRIFT = Symbol("drift", real=True)
"""The speed at which the variable across drifts, where the lattice is not the same in all
directions; the reduction finds it."""

WORDS = Vocabulary({"sqrt": (sqrt, 1), "atan": (atan, 1)})


def read_direction(text: str) -> tuple[Expr, Expr]:
    """Cosine and sine of a direction: of an angle in radians, or of what points along ``a,b``.

    Raises ValueError for any other text, and for a vector of no length.

    >>> read_direction("pi/4"), read_direction("3,4"), read_direction("0,-1")
    ((sqrt(2)/2, sqrt(2)/2), (3/5, 4/5), (0, -1))
    """
    parts = [exact("direction", read_formula(part, WORDS, "direction")) for part in text.split(",")]
    if len(parts) == 1:
        return cos(parts[0]), sin(parts[0])
    if len(parts) != 2 or not any(parts):
        raise ValueError(
            f"direction must be an angle or two numbers, not both 0, got {shown(text)} (such as "
            "pi/4, or 3/5,4/5)"
        )
    length = sqrt(parts[0] ** 2 + parts[1] ** 2)
    return parts[0] / length, parts[1] / length


def slow_variables(
    lattice: Lattice, direction: tuple[Expr, Expr]
) -> tuple[tuple[SlowVariable, ...], dict[str, Expr]]:
    """X along a direction and Z across it, and the values of the symbols that are in them.

    Oblique directions have the symbols C and S, and a drift of Z.  Raises ValueError for a lattice
    of other than two axes, and for one with constants of these names.
    """
    if lattice.dimension != 2:
        raise ValueError(
            f"direction must be of a lattice with two axes, got {lattice.name} with "
            f"{lattice.dimension} (leave it out; square has two)"
        )
    taken = {str(symbol) for symbol in (C, S, DRIFT)} & {str(own) for own in lattice.constants}
    if taken:
        raise ValueError(
            f"constants must have names other than C, S and drift, got {min(taken)} (they are "
            "those of the direction)"
        )
    if all(part.is_Integer for part in direction):
        along, across = direction
        rest = (-across, along)
        return (SlowVariable("X", 1, direction, c), SlowVariable("Z", 2, rest, Integer(0))), {}
    oblique = SlowVariable("X", 1, (C, S), c), SlowVariable("Z", 2, (-S, C), DRIFT)
    return oblique, dict(zip("CS", direction, strict=True))
