"""Evaluation of an expression in mpmath, at any precision."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from derive.algebra.exact_numbers import exact_number, shown
from solutions.functions.multiprecision import MpmathFormula
from solutions.symbols import tau, xi

__all__ = ["check_digits", "evaluate_mp", "exact_point"]

GUARD_DIGITS = 30
MOST_DIGITS = 100_000
LARGEST = sp.Integer(10) ** 1000
"""Largest position or time; the working precision grows with its logarithm."""


@lru_cache(maxsize=64)
def _formula(expression: sp.Expr, parameters: tuple[sp.Symbol, ...]) -> tuple[Any, MpmathFormula]:
    """A private context, and ``expression`` as a formula in (xi, tau, *parameters)."""
    return mpmath.MPContext(), MpmathFormula.of([xi, tau, *parameters], [expression])


def evaluate_mp(
    expression: sp.Expr,
    parameters: Mapping[sp.Symbol, sp.Expr],
    variables: tuple[sp.Expr, sp.Expr, sp.Expr],
    rates: tuple[sp.Expr, sp.Expr],
    point: tuple[sp.Expr, sp.Expr],
    digits: int,
) -> tuple[Any, Any, Any]:
    """U and its xi and tau derivatives times the two ``rates``, to ``digits`` digits, as mpf.

    ``point`` is (x, t); xi = a x + d t and tau = b t for ``variables`` (a, b, d). Derivatives are
    by differences, which know nothing of the derivative rules and so are a check of these. The
    working precision is doubled until two results agree: the printed forms cancel near the ends of
    their parameters' domains.
    """
    context, formula = _formula(expression, tuple(parameters))
    along, later, drift = variables
    moving = along * point[0] + drift * point[1], later * point[1]
    exact = (*parameters.values(), *moving, *rates)
    guard, before = GUARD_DIGITS, None
    while True:
        with context.workdps(digits + guard):
            *given, x, t, a, b = (_convert(context, number) for number in exact)
            values = _with_differences(context, formula, x, t, given)
            found = values[0], a * values[1], b * values[2]
            agree = before is not None and _agree(context, found, before, digits)
        if agree:
            with context.workdps(digits):
                return +found[0], +found[1], +found[2]
        guard, before = 2 * guard, found


def _with_differences(
    context: Any, formula: MpmathFormula, x: Any, t: Any, point: list[Any]
) -> tuple[Any, Any, Any]:
    """Value and slopes from three values at more than twice the precision of the slopes."""
    step = context.ldexp(1, -context.prec)
    size = max(context.mag(x), context.mag(t), 1)
    with context.workprec(2 * context.prec + size):
        (value,) = formula(context, x, t, *point)
        (moved,) = formula(context, x + step, t, *point)
        (later,) = formula(context, x, t + step, *point)
        slope, rate = (moved - value) / step, (later - value) / step
    return value, slope, rate


def _agree(context: Any, one: tuple[Any, ...], other: tuple[Any, ...], digits: int) -> bool:
    bound = context.mpf(10) ** -(digits + 1)
    return all(abs(a - b) <= bound * max(1, abs(a)) for a, b in zip(one, other, strict=True))


def exact_point(name: str, value: object) -> sp.Expr:
    """The exact number of a position or time; a float is the binary number it is.

    Raises ValueError for what is no real number, and beyond ``LARGEST``.
    """
    if isinstance(value, float | np.floating) and np.isfinite(value):
        exact: sp.Expr = sp.Rational(*map(int, value.as_integer_ratio()))
    else:
        exact = exact_number(name, value)
    if abs(exact) > LARGEST:
        raise ValueError(
            f"{name} must satisfy |{name}| <= 10**1000, got {shown(value)} (take less)"
        )
    return exact


def check_digits(digits: object) -> int:
    """``digits`` if it is a number of digits, else a ValueError."""
    is_whole = isinstance(digits, int | np.integer) and not isinstance(digits, bool)
    if is_whole and 1 <= (found := int(digits)) <= MOST_DIGITS:  # type: ignore[call-overload]
        return found
    raise ValueError(
        f"digits must be a whole number from 1 to {MOST_DIGITS}, got {shown(digits)} (50 is usual)"
    )


def _convert(context: Any, exact: sp.Expr) -> Any:
    return context.mpf(exact._to_mpmath(context.prec))
