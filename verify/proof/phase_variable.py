"""An argument ``b*n + d`` with a free constant d as one variable in place of both.

What holds for all d and all n holds for all values of the argument, so that the shifts of a lattice
are sums of the argument and a constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from .typed_statement import Statement


@dataclass(frozen=True)
class PhaseVariable:
    """A residual in ``variables``; ``rest`` is the argument's own part where one was replaced."""

    residual: sp.Expr
    variables: tuple[sp.Symbol, ...]
    rest: sp.Expr = sp.S.Zero


def with_phase(residual: sp.Expr, statement: Statement, kept: Sequence[sp.Symbol]) -> PhaseVariable:
    """The residual in such a variable if that removes another one; d must not be among ``kept``."""
    moving = residual.free_symbols & set(statement.variables)
    arguments = {sp.expand(f.args[0]) for f in residual.atoms(sp.Function)}
    for phase in sorted(residual.free_symbols - {*kept, *statement.variables}, key=str):
        is_any_number = phase.is_nonnegative is None and phase.is_nonpositive is None
        if phase in statement.domains or not (phase.is_real and is_any_number):
            continue
        for argument in sorted(arguments, key=lambda z: (z.count_ops(), str(z))):
            slope = argument.coeff(phase, 1)
            rest = argument - slope * phase
            if not slope.is_Rational or slope == 0 or phase in rest.free_symbols:
                continue
            variable = sp.Symbol(_fresh(residual), real=True)
            image = _expanded(residual.xreplace({phase: (variable - rest) / slope}))
            left = [v for v in statement.variables if v in image.free_symbols]
            if len(left) < len(moving):
                return PhaseVariable(image, (variable, *left), rest)
    return PhaseVariable(residual, statement.variables)


def _expanded(expression: sp.Expr) -> sp.Expr:
    """The expression with the arguments of functions multiplied out."""
    return expression.replace(
        lambda node: isinstance(node, sp.Function),
        lambda node: node.func(*map(sp.expand, node.args)),
    )


def _fresh(expression: sp.Expr) -> str:
    """A name that no symbol has."""
    name = "phase"
    while any(symbol.name == name for symbol in expression.free_symbols):
        name += "_"
    return name
