"""Whether a statement's label, or a witness, is right: by values at admissible points.

Nothing here is shared with the prover: functions are mpmath's, derivatives are differences at
high precision.
"""

from __future__ import annotations

import functools
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import mpmath
import sympy as sp

from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.functions.multiprecision import IMPLEMENTATIONS
from longwave.verify.subexpressions import distinct_nodes
from searches.statements.random_statement import (
    Point,
    RandomStatement,
    Setting,
    Truth,
)

Numbers = Mapping[sp.Symbol, Any]

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

    def value(self, formula: sp.Expr, point: Numbers) -> Any:
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

    def derivative(self, formula: sp.Expr, orders: Mapping[sp.Symbol, int], point: Numbers) -> Any:
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

    def residual(self, statement: RandomStatement, point: Numbers) -> Any:
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


POINTS = 6
TRIES = 10
DIGITS = (40, 240)
"""Two precisions suffice for most residuals that are no rounding."""

MORE_DIGITS = (*DIGITS, 700, 1400, 6000)
"""Where terms cancel: changes by 10**-200, and witnesses far out: 1 - tanh(1000)."""

SAME = 1e-3
"""Relative difference up to which two values are one; rounding differs by 10**-200 and more."""


def fails_at(statement: RandomStatement, point: Point, digits: Sequence[int] = MORE_DIGITS) -> bool:
    """Whether the statement has a residual at ``point``; raises ValueMissing without a value.

    A residual that is one term by construction is taken from that term where it is small.
    """
    if _is_number(lambda values: values.residual(statement, point), digits[:2]):
        return True
    change = statement.change
    if change is not None:
        return _is_number(lambda values: values.value(change, point), digits)
    return _is_number(lambda values: values.residual(statement, point), digits[1:])


def with_counterexample(statement: RandomStatement, draw: random.Random) -> RandomStatement | None:
    """A false statement with an admissible point that shows it; None if some tries find none."""
    for _ in range(TRIES):
        point = statement.point(draw)
        try:
            if fails_at(statement, point, DIGITS):
                return replace(statement, counterexample=point)
        except ValueMissing:
            continue
    return None


def shown_at(term: sp.Expr, setting: Setting, digits: int) -> Point | None:
    """An admissible point at which ``term`` is clearly not 0."""
    values = values_at(digits)
    for _ in range(4 * TRIES):
        point = setting.point()
        try:
            size = abs(values.value(term, point))
        except ValueMissing:
            continue
        if size > values.context.mpf(10) ** (-digits / 3):
            return point
    return None


def _is_number(find: Callable[[Values], Any], digits: Sequence[int]) -> bool:
    """Whether ``find`` gives one number other than 0, however small, at two of the precisions.

    Rounding falls with the precision.  Raises ValueMissing if there is a value at none of them.
    """
    before, missing = None, None
    for values in map(values_at, digits):
        try:
            found = find(values)
        except ValueMissing as error:
            missing = error
            continue
        if before is not None and _is_same(before, found):
            return True
        before = found
    if before is None and missing is not None:
        raise missing
    return False


def _is_same(coarse: Any, fine: Any) -> bool:
    return bool(abs(coarse - fine) < SAME * abs(fine))


def label_fault(statement: RandomStatement, points: int = POINTS) -> str | None:
    """What speaks against the label, in words; None if nothing does.

    A true statement's residual must be rounding at every point where it has a value, a false
    one's must not be at its counterexample, and a void one must have no value anywhere.
    """
    if statement.truth is Truth.FALSE:
        return _false_fault(statement)
    draw = random.Random(f"{statement.seed}:{statement.index}")
    find = _void_fault if statement.truth is Truth.VOID else _true_fault
    for _ in range(points):
        point = statement.point(draw)
        try:
            fault = find(statement, point)
        except ValueMissing:
            continue
        if fault is not None:
            return fault
    return None


def _true_fault(statement: RandomStatement, point: Point) -> str | None:
    if fails_at(statement, point, DIGITS) and fails_at(statement, point, MORE_DIGITS[-2:]):
        return f"the residual at {point} is no rounding"
    return None


def _void_fault(statement: RandomStatement, point: Point) -> str | None:
    """A division by 0 gives rounding, if it gives anything: another value at other digits."""
    same = _is_number(lambda values: values.value(statement.right, point), DIGITS)
    return f"there is a value at {point}" if same else None


def _false_fault(statement: RandomStatement) -> str | None:
    point = statement.counterexample
    if point is None:
        return "there is no counterexample"
    for made in statement.ranges:
        if not made.holds(point[made.symbol]):
            return f"{made.symbol} = {point[made.symbol]} is not in its range"
    try:
        shown = fails_at(statement, point)
        return None if shown else f"the residual at {point} is rounding"
    except ValueMissing as error:
        return f"no value at the counterexample {point}: {error}"
