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

    The differences are taken at a precision that leaves ``digits`` of them; they know nothing of
    the derivative rules, which makes them a check of these.
    """
    context, function = mp_function(form.expression, tuple(parameters))
    with context.workdps(digits + GUARD_DIGITS):
        values = [_convert(context, exact) for exact in parameters.values()]
        a, b = _convert(context, normal_form.a), _convert(context, normal_form.b)
        x, t = (a * _point(context, "X", X), b * _point(context, "T", T))
        value = function(x, t, *values)
        slope = context.diff(lambda s: function(s, t, *values), x)
        rate = context.diff(lambda s: function(x, s, *values), t)
        result = value, a * slope, b * rate
    with context.workdps(digits):
        return +result[0], +result[1], +result[2]


def _point(context: Any, name: str, value: object) -> Any:
    """A float argument is the binary number it is, as it is for NumPy."""
    if isinstance(value, float):
        return context.mpf(value)
    return _convert(context, exact_number(name, value))


def _convert(context: Any, exact: sp.Expr) -> Any:
    return context.mpf(exact._to_mpmath(context.prec))
