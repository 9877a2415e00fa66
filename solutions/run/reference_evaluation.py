"""Evaluation of an expression in mpmath, at any precision."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import tau, xi, zeta
from longwave.support.user_files import shown

GUARD_DIGITS = 30
MOST_DIGITS = 100_000
LARGEST = sp.Integer(10) ** 1000
"""Largest position or time; the working precision grows with its logarithm."""


@lru_cache(maxsize=64)
def _formula(expression: sp.Expr, parameters: tuple[sp.Symbol, ...]) -> tuple[Any, MpmathFormula]:
    """A private context, and ``expression`` in (xi, tau, zeta, *parameters)."""
    return mpmath.MPContext(), MpmathFormula.of([xi, tau, zeta, *parameters], [expression])


def evaluate_mp(
    expression: sp.Expr,
    parameters: Mapping[sp.Symbol, sp.Expr],
    variables: tuple[sp.Expr, ...],
    rates: Sequence[sp.Expr],
    point: Sequence[sp.Expr],
    digits: int,
    *,
    drift: sp.Expr = sp.S.Zero,
    highest: int | None = None,
) -> tuple[Any, ...]:
    """U and its xi, tau and zeta derivatives times the ``rates``, to ``digits`` digits, as mpf.

    From the third, ``drift`` times the second is subtracted. With ``highest`` they are U and its xi
    derivatives up to that order instead.
    ``point`` is (x, t) or (x, t, z); xi = a x + d t, tau = b t and zeta = e z for ``variables``
    (a, b, d, e). Where U is complex the values are mpc. Derivatives are by differences, which know
    nothing of the derivative rules and so are a check of these. The working precision is doubled
    until two results agree: the printed forms cancel near the ends of their parameters' domains.
    """
    context, formula = _formula(expression, tuple(parameters))
    along, later, moving, across = variables
    x, t, *z = point
    exact = along * x + moving * t, later * t, across * z[0] if z else sp.S.Zero
    guard, before = GUARD_DIGITS, None
    while True:
        with context.workdps(digits + guard):
            given = [_convert(context, number) for number in parameters.values()]
            place = [_convert(context, number) for number in exact]
            if highest is None:
                values = _with_differences(context, formula, place, len(point), given)
            else:
                values = _along(context, formula, place, given, highest)
            scales = [_convert(context, rate) for rate in rates]
            found = [rate * value for rate, value in zip(scales, values, strict=True)]
            if highest is None:
                found[2] -= _convert(context, drift) * found[1]
        agree = before is not None and _agree(context, found, before, digits)
        if agree:
            with context.workdps(digits):
                return tuple(+value for value in found)
        guard, before = 2 * guard, found


def _with_differences(
    context: Any, formula: MpmathFormula, place: list[Any], directions: int, given: list[Any]
) -> list[Any]:
    """Value and slopes, the latter from values at more than twice their precision."""
    step = context.ldexp(1, -context.prec)
    size = max(1, *(context.mag(coordinate) for coordinate in place))
    with context.workprec(2 * context.prec + size):
        (value,) = formula(context, *place, *given)
        found = [value]
        for direction in range(directions):
            moved = list(place)
            moved[direction] += step
            found.append((formula(context, *moved, *given)[0] - value) / step)
    return found


def _along(
    context: Any, formula: MpmathFormula, place: list[Any], given: list[Any], highest: int
) -> list[Any]:
    """The value and its xi derivatives."""

    def value(x: Any) -> Any:
        return formula(context, x, *place[1:], *given)[0]

    return list(context.diffs(value, place[0], highest))


def _agree(context: Any, one: Sequence[Any], other: Sequence[Any], digits: int) -> bool:
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
