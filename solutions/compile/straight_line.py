"""A straight-line program of an expression and its derivatives.

Every distinct subexpression is one line of the tape, and the derivative of a line follows from
SymPy's derivative of that line alone by the chain rule.  A third derivative is then a few times
the size of the expression, where the expanded SymPy tree is hundreds of times as large.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import sympy as sp

from solutions.functions.multiprecision import MpmathFormula


class UnknownDerivativeError(ValueError):
    """A function on the tape has no derivative that SymPy knows."""


class StraightLine:
    """Lines ``symbol = node`` in order of evaluation; equal nodes share one line.

    >>> from mpmath import mp
    >>> x = sp.Symbol("x")
    >>> tape = StraightLine()
    >>> entry = tape.record(sp.sin(x**2) + x**2)
    >>> len(tape.lines)
    3
    >>> slope = tape.derivative(entry, x)
    >>> print(tape.formula([x], [slope])(mp, mp.zero)[0])
    0.0
    """

    def __init__(self) -> None:
        self.lines: list[tuple[sp.Symbol, sp.Expr]] = []
        self._node: dict[sp.Basic, sp.Expr] = {}
        self._entry: dict[sp.Basic, sp.Expr] = {}
        self._derivative: dict[tuple[sp.Basic, sp.Symbol], sp.Expr] = {}

    def record(self, expression: sp.Basic) -> sp.Expr:
        """Append what is new in ``expression``; return the entry (symbol or number) of its value.

        Symbols that earlier calls returned may stand in ``expression``.
        """
        if not expression.args:
            return expression
        if expression not in self._entry:
            entries = [self.record(argument) for argument in expression.args]
            self._entry[expression] = self._combine(expression.func, entries)
        return self._entry[expression]

    def _combine(self, function: type[sp.Basic], entries: list[sp.Expr]) -> sp.Expr:
        """Products are taken two at a time: the product rule for many factors is slow."""
        if function is not sp.Mul:
            return self._line(function(*entries))
        return functools.reduce(lambda left, right: self._line(left * right), entries)

    def _line(self, node: sp.Expr) -> sp.Expr:
        if not node.args:
            return node
        if node not in self._entry:
            symbol = sp.Symbol(f"_w{len(self.lines)}")
            self.lines.append((symbol, node))
            self._node[symbol] = node
            self._entry[node] = symbol
        return self._entry[node]

    def derivative(self, entry: sp.Expr, variable: sp.Symbol) -> sp.Expr:
        """The entry of the derivative of ``entry`` with respect to the real ``variable``.

        Raises UnknownDerivativeError where SymPy leaves the derivative of a function unevaluated.
        """
        if entry == variable:
            return sp.Integer(1)
        if entry not in self._node:
            return sp.Integer(0)
        key = (entry, variable)
        if key not in self._derivative:
            self._derivative[key] = self.record(self._chain_rule(self._node[entry], variable))
        return self._derivative[key]

    def _chain_rule(self, node: sp.Expr, variable: sp.Symbol) -> sp.Expr:
        if isinstance(node, sp.conjugate | sp.re | sp.im):
            return node.func(self.derivative(node.args[0], variable))
        products = []
        for inner in sorted(node.free_symbols, key=str):
            slope = self.derivative(inner, variable)
            if slope != 0:
                products.append(_partial_derivative(node, inner) * slope)
        return sp.Add(*products)

    def formula(self, arguments: Sequence[sp.Symbol], entries: Sequence[sp.Expr]) -> MpmathFormula:
        """The values of ``entries`` as a formula in ``arguments``, for any mpmath context."""
        return MpmathFormula.of(arguments, entries, self.lines)


def _partial_derivative(node: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    partial = node.diff(symbol)
    if partial.has(sp.Derivative, sp.Subs):
        raise UnknownDerivativeError(
            f"{node.func.__name__} has no known derivative in that argument (give it an fdiff)"
        )
    return partial
