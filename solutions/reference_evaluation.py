"""Evaluation of the canonical expression in mpmath, at any precision."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import mpmath
import sympy as sp

from derive.normal_form import NormalForm
from solutions.closed_form import ClosedForm
from solutions.exact import exact_number
from solutions.special.mp import mp_module
from solutions.symbols import tau, xi

__all__ = ["evaluate_mp", "mp_function"]

GUARD_DIGITS = 30


@lru_cache(maxsize=64)
def mp_function(
    expression: sp.Expr, parameters: tuple[sp.Symbol, ...]
) -> tuple[Any, Callable[..., Any]]:
    """A private context and ``expression`` as a function of (xi, tau, *parameters) in it.

    Set the context's precision before calling; the arguments are its mpf.
    """
    context = mpmath.MPContext()
    modules = [mp_module(context), "mpmath"]
    return context, sp.lambdify([xi, tau, *parameters], expression, modules, cse=True)


def evaluate_mp(
    form: ClosedForm,
    normal_form: NormalForm,
    parameters: Mapping[sp.Symbol, sp.Expr],
    X: object,
    T: object,
    digits: int,
) -> tuple[Any, Any, Any]:
    """Y, Y_X, Y_T at the exact X, T, to ``digits`` digits; derivatives by differences in mpmath.

    The differences know nothing of the derivative rules, which makes them a check of these. The
    working precision is doubled until two results agree: the printed forms cancel near the ends
    of their parameters' domains.
    """
    context, function = mp_function(form.expression, tuple(parameters))
    guard, before = GUARD_DIGITS, None
    while True:
        with context.workdps(digits + guard):
            point = [_convert(context, exact) for exact in parameters.values()]
            a, b = _convert(context, normal_form.a), _convert(context, normal_form.b)
            x, t = a * _point(context, "X", X), b * _point(context, "T", T)
            values = _with_differences(context, function, x, t, point)
        with context.workdps(digits):
            found = tuple(f * value for f, value in zip((1, a, b), values, strict=True))
            if before is not None and _agree(context, found, before, digits):
                return found[0], found[1], found[2]
        guard, before = 2 * guard, found


def _with_differences(
    context: Any, function: Callable[..., Any], x: Any, t: Any, point: list[Any]
) -> tuple[Any, Any, Any]:
    value = function(x, t, *point)
    slope = context.diff(lambda s: function(s, t, *point), x)
    return value, slope, context.diff(lambda s: function(x, s, *point), t)


def _agree(context: Any, one: tuple[Any, ...], other: tuple[Any, ...], digits: int) -> bool:
    bound = context.mpf(10) ** (2 - digits)
    return all(abs(a - b) <= bound * max(1, abs(a)) for a, b in zip(one, other, strict=True))


def _point(context: Any, name: str, value: object) -> Any:
    """A float argument is the binary number it is, as it is for NumPy."""
    if isinstance(value, float):
        return context.mpf(value)
    return _convert(context, exact_number(name, value))


def _convert(context: Any, exact: sp.Expr) -> Any:
    return context.mpf(exact._to_mpmath(context.prec))
