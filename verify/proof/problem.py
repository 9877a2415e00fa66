"""What is to be decided: an equation, its unknown, and the formula put in its place."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp
from sympy.core.function import AppliedUndef

from verify.terms import FieldEquation

from .balls import Point

POINTS = 4
DENOMINATOR = 1009


@dataclass(frozen=True)
class Problem:
    """Does ``expression`` for ``unknown`` make ``left`` vanish?

    ``points`` are admissible rational points, for witnesses and for denominators.
    """

    left: sp.Expr
    unknown: sp.Expr
    expression: sp.Expr
    points: tuple[Point, ...]
    name: str
    equation_name: str

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """The arguments of the unknown function."""
        return tuple(self.unknown.args)


def make_problem(
    equation: FieldEquation | sp.Expr, expression: sp.Expr, points: Sequence[Point], name: str
) -> Problem:
    """The problem that `prove` is called with; raises ValueError without a single unknown."""
    if isinstance(equation, sp.Expr):
        left, label = equation, f"{equation} = 0"
    else:
        left, label = equation.residual(sp.Function("U")(equation.xi, equation.tau)), equation.name
    unknowns = left.atoms(AppliedUndef)
    if len(unknowns) != 1:
        raise ValueError(
            f"equation must contain one unknown function, got {len(unknowns)} "
            "(write it with sympy.Function('u')(x, t))"
        )
    (unknown,) = unknowns
    symbols = left.free_symbols | expression.free_symbols
    found = tuple(points) or random_points(symbols)
    return Problem(left, unknown, expression, found, name, label)


def random_points(symbols: Iterable[sp.Basic], seed: int = 0) -> tuple[Point, ...]:
    """Points with every symbol strictly between 0 and 1, the same for the same seed."""
    draw = random.Random(seed)
    ordered = sorted(symbols, key=str)
    return tuple(
        {symbol: sp.Rational(draw.randint(1, DENOMINATOR - 1), DENOMINATOR) for symbol in ordered}
        for _ in range(POINTS)
    )
