"""Values of formulas and residuals by mpmath, to judge labels and witnesses.

Nothing here is shared with the prover: functions are mpmath's, derivatives are differences at
high precision.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import mpmath
import sympy as sp

from solutions.functions.jacobi import JacobiFunction
from solutions.functions.multiprecision import IMPLEMENTATIONS
from verify.subexpressions import distinct_nodes

from .record import Statement

Point = Mapping[sp.Symbol, Any]

UNARY = {
    **{
        getattr(sp, name): name
        for name in (
            *("exp", "log", "sin", "cos", "tan", "cot", "sec", "csc"),
            *("sinh", "cosh", "tanh", "coth", "sech", "csch"),
            *("asin", "acos", "atan", "asinh", "acosh", "atanh", "sign", "re", "im"),
            *("gamma", "floor"),
        )
    },
    sp.Abs: "fabs",
    sp.conjugate: "conj",
    sp.elliptic_k: "ellipk",
    sp.elliptic_e: "ellipe",
}
CUT = {sp.log, sp.atan, sp.asin, sp.acos, sp.asinh, sp.acosh, sp.atanh, sp.sign}
GUARD = 10
DUST = 0.75
"""An imaginary part below 10 to the minus this share of the digits is rounding, before a cut."""


@functools.cache
def values_at(digits: int) -> Values:
    """The `Values` with ``digits`` decimals; a context takes a millisecond to make."""
    return Values(digits)


class ValueMissing(ArithmeticError):
    """A formula has no finite value at a point."""


class Values:
    """Formulas at points, with ``digits`` decimals.

    >>> x = sp.Symbol("x")
    >>> print(mpmath.nstr(Values(20).value(sp.sqrt(x) + sp.I, {x: sp.Rational(1, 4)}), 5))
    (0.5 + 1.0j)
    """

    def __init__(self, digits: int) -> None:
        self.context = mpmath.mp.clone()
        self.context.dps = digits + GUARD
        self.digits = digits

    def value(self, formula: sp.Expr, point: Point) -> Any:
        """The value of ``formula``; raises ValueMissing where there is none."""
        known = {symbol: self._number(value) for symbol, value in point.items()}
        try:
            for node in reversed(distinct_nodes(formula)):
                self._settle(node, known)
        except (ValueError, ZeroDivisionError, OverflowError) as error:
            raise ValueMissing(str(error)) from error
        if not self.context.isfinite(known[formula]):
            raise ValueMissing(f"{formula} is not finite")
        return known[formula]

    def derivative(self, formula: sp.Expr, orders: Mapping[sp.Symbol, int], point: Point) -> Any:
        """A partial derivative of ``formula``, by differences."""
        moving = [symbol for symbol, order in orders.items() if order]
        if not moving:
            return self.value(formula, point)

        def along(*values: Any) -> Any:
            return self.value(formula, {**point, **dict(zip(moving, values, strict=True))})

        start = tuple(self._number(point[symbol]) for symbol in moving)
        found = self.context.diff(along, start, tuple(orders[symbol] for symbol in moving))
        if not self.context.isfinite(found):
            raise ValueMissing(f"a derivative of {formula} is not finite")
        return found

    def residual(self, statement: Statement, point: Point) -> Any:
        """The difference of the sides, or the residual, relative to 1 plus its largest term."""
        if statement.unknown is None:
            terms = [self.value(statement.left, point), -self.value(statement.right, point)]
        else:
            images: dict[sp.Expr, Any] = {statement.unknown: statement.right}
            values = dict(point)
            left = statement.left if statement.left.has(sp.Subs) else statement.left.doit()
            for node in distinct_nodes(left):
                if isinstance(node, sp.Subs) and node.expr == statement.unknown:
                    moved = {**point, **dict(zip(node.variables, node.point, strict=True))}
                    symbol = images[node] = sp.Dummy()
                    values[symbol] = self.value(statement.right, moved)
                elif isinstance(node, sp.Derivative):
                    symbol = images[node] = sp.Dummy()
                    orders = {v: int(n) for v, n in node.variable_count}
                    values[symbol] = self.derivative(statement.right, orders, point)
            flat = left.xreplace(images)
            terms = [self.value(term, values) for term in sp.Add.make_args(flat)]
        return self.context.fsum(terms) / (1 + max(abs(term) for term in terms))

    def _number(self, value: Any) -> Any:
        if isinstance(value, sp.Rational):
            return self.context.mpf(int(value.p)) / int(value.q)
        return value

    def _settle(self, node: sp.Expr, known: dict[sp.Expr, Any]) -> None:
        if node not in known:
            for argument in node.args:
                self._settle(argument, known)
            known[node] = self._node(node, [known[argument] for argument in node.args])

    def _node(self, node: sp.Expr, values: list[Any]) -> Any:
        context = self.context
        if node.is_Rational:
            return self._number(node)
        if node is sp.I:
            return context.mpc(0, 1)
        if node is sp.pi:
            return +context.pi
        if node is sp.E:
            return +context.e
        if node.is_Add:
            return context.fsum(values)
        if node.is_Mul:
            return context.fprod(values)
        if node.is_Pow:
            return self._power(node, *values)
        if isinstance(node, JacobiFunction):
            return IMPLEMENTATIONS[node.func.__name__](context, *values)
        if node.func in CUT:
            values = [self._clean(value) for value in values]
        if node.func not in UNARY:
            raise ValueMissing(f"no value of {node.func.__name__} is known")
        return getattr(context, UNARY[node.func])(*values)

    def _power(self, node: sp.Expr, base: Any, exponent: Any) -> Any:
        if node.exp.is_Integer:
            return base ** int(node.exp)
        if base == 0 and node.exp.is_positive:
            return self.context.zero
        return self.context.power(self._clean(base), exponent)

    def _clean(self, value: Any) -> Any:
        """``value`` without an imaginary part that is rounding, so that a cut is met as meant."""
        if isinstance(value, self.context.mpc):
            dust = self.context.mpf(10) ** (-DUST * self.digits)
            if abs(value.imag) <= dust * abs(value.real):
                return value.real
        return value
