"""Evaluation of an expression in mpmath, at any precision."""

from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import tau, xi, zeta
from longwave.support.user_files import shown

GUARD_DIGITS = 30
"""Extra working digits of the first attempt."""

MOST_DIGITS = 100_000
"""Most digits that can be requested."""

LARGEST_COORDINATE = sp.Integer(10) ** 1000
"""Largest position or time; the working precision grows with its logarithm."""


@lru_cache(maxsize=64)
def _formula(expression: sp.Expr, parameters: tuple[sp.Symbol, ...]) -> tuple[Any, MpmathFormula]:
    """Return a new context, and ``expression`` as a formula in (xi, tau, zeta, *parameters)."""
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
    """Return U and its xi, tau and zeta derivatives times ``rates``, to ``digits`` digits, as mpf.

    ``drift`` times the scaled xi derivative is subtracted from the scaled tau derivative. With
    ``highest``, return U and its xi derivatives up to that order instead. ``point`` is (x, t) or
    (x, t, z); xi = a x + d t, tau = b t and zeta = e z for ``variables`` (a, b, d, e). Values of a
    complex U are mpc. Derivatives are computed by differences: they use no derivative rules and so
    check these. The guard digits are doubled until two results agree, because the printed forms
    cancel near the ends of their parameters' domains.
    """
    context, formula = _formula(expression, tuple(parameters))
    space_rate, time_rate, frame_rate, transverse_rate = variables
    x, t, *z = point
    exact = (
        space_rate * x + frame_rate * t,
        time_rate * t,
        transverse_rate * z[0] if z else sp.S.Zero,
    )
    guard, previous = GUARD_DIGITS, None
    while True:
        with context.workdps(digits + guard):
            numbers = [_convert(context, number) for number in parameters.values()]
            coordinates = [_convert(context, number) for number in exact]
            if highest is None:
                values = _with_differences(context, formula, coordinates, len(point), numbers)
            else:
                start, *others = (*coordinates, *numbers)
                along = partial(_value_at, context, formula, others)
                values = list(context.diffs(along, start, highest))
            scales = [_convert(context, rate) for rate in rates]
            results = [rate * value for rate, value in zip(scales, values, strict=True)]
            if highest is None:
                results[2] -= _convert(context, drift) * results[1]
        if previous is not None and _agree(context, results, previous, digits):
            with context.workdps(digits):
                return tuple(+value for value in results)
        guard, previous = 2 * guard, results


def _with_differences(
    context: Any,
    formula: MpmathFormula,
    coordinates: list[Any],
    directions: int,
    parameters: list[Any],
) -> list[Any]:
    """Return value and slopes, the slopes by differences at more than twice the precision."""
    step = context.ldexp(1, -context.prec)
    magnitude = max(1, *(context.mag(coordinate) for coordinate in coordinates))
    with context.workprec(2 * context.prec + magnitude):
        (value,) = formula(context, *coordinates, *parameters)
        slopes = [value]
        for direction in range(directions):
            shifted = list(coordinates)
            shifted[direction] += step
            slopes.append((formula(context, *shifted, *parameters)[0] - value) / step)
    return slopes


def _value_at(context: Any, formula: MpmathFormula, others: list[Any], x: Any) -> Any:
    return formula(context, x, *others)[0]


def _agree(context: Any, first: Sequence[Any], second: Sequence[Any], digits: int) -> bool:
    bound = context.mpf(10) ** -(digits + 1)
    return all(abs(a - b) <= bound * max(1, abs(a)) for a, b in zip(first, second, strict=True))


def exact_point(name: str, value: object) -> sp.Expr:
    """Return the exact number of a position or time; a float keeps its exact binary value.

    Raises ValueError for a value that is not a real number, and beyond ``LARGEST_COORDINATE``.
    """
    if isinstance(value, float | np.floating) and np.isfinite(value):
        exact: sp.Expr = sp.Rational(*map(int, value.as_integer_ratio()))
    else:
        exact = exact_number(name, value)
    if abs(exact) > LARGEST_COORDINATE:
        raise ValueError(
            f"{name} must satisfy |{name}| <= 10**1000, got {shown(value)} (take less)"
        )
    return exact


def check_digits(digits: object) -> int:
    """Return ``digits`` as an integer. Raises ValueError if it is not a valid number of digits."""
    is_whole = isinstance(digits, int | np.integer) and not isinstance(digits, bool)
    if is_whole and 1 <= (count := int(digits)) <= MOST_DIGITS:  # type: ignore[call-overload]
        return count
    raise ValueError(
        f"digits must be a whole number from 1 to {MOST_DIGITS}, got {shown(digits)} (50 is usual)"
    )


def _convert(context: Any, exact: sp.Expr) -> Any:
    return context.mpf(exact._to_mpmath(context.prec))
