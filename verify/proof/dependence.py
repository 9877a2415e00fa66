"""Which parts of an expression depend on the variables; asked often, so remembered."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp


class Dependence:
    """Tells constants (free of ``variables``) from the rest.

    >>> x, a = sp.symbols("x a")
    >>> Dependence([x]).factors(a * sp.sin(a) * x**2)
    (a*sin(a), x**2)
    """

    def __init__(self, variables: Sequence[sp.Symbol]) -> None:
        self.variables = tuple(variables)
        self._moves: dict[sp.Basic, bool] = dict.fromkeys(variables, True)

    def moves(self, node: sp.Basic) -> bool:
        """Whether ``node`` contains a variable."""
        if node not in self._moves:
            self._moves[node] = any(self.moves(inner) for inner in node.args)
        return self._moves[node]

    def factors(self, product: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """The constant and the variable factor of ``product``."""
        return self._parts(product, sp.Mul)

    def summands(self, total: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """The constant and the variable part of a sum."""
        return self._parts(total, sp.Add)

    def _parts(self, whole: sp.Expr, kind: type[sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
        parts = whole.args if isinstance(whole, kind) else (whole,)
        moving = [part for part in parts if self.moves(part)]
        if len(moving) == len(parts):
            return kind(), whole
        return kind(*(part for part in parts if not self.moves(part))), kind(*moving)
