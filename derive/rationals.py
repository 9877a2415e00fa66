"""Numbers from outside made exact: no float survives, no text is evaluated."""

from __future__ import annotations

import re
from fractions import Fraction
from numbers import Integral, Real
from numbers import Rational as RationalNumber
from typing import TypeAlias

from sympy import Expr, Rational, nan

Number: TypeAlias = int | float | str | Fraction | Expr

_DECIMAL = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_RATIO = re.compile(r"[+-]?\d+/\d+", re.ASCII)


def parse_rational(name: str, text: str) -> Rational:
    """The exact rational that ``text`` spells as an integer, a decimal or ``p/q``.

    ``name`` is the argument named in the ValueError for anything else.

    >>> parse_rational("K4", "0.1"), parse_rational("K4", "-3/6")
    (1/10, -1/2)
    """
    stripped = text.strip()
    if not (_DECIMAL.fullmatch(stripped) or _RATIO.fullmatch(stripped)):
        raise ValueError(
            f"{name} must be a rational number, got {text!r} (write 4, 0.25, 1e-3 or 1/3)"
        )
    try:
        value = Fraction(stripped)
    except ZeroDivisionError:
        raise ValueError(
            f"{name} must have a nonzero denominator, got {text!r} (write 4, 0.25 or 1/3)"
        ) from None
    return Rational(value.numerator, value.denominator)


def exact(name: str, value: Number) -> Expr:
    """``value`` exactly: a float as the shortest decimal that denotes it, symbols unchanged.

    Raises ValueError for text that is no rational, for NaN and infinity and for non-real numbers.

    >>> exact("K2", 0.1), exact("K2", "1/3")
    (1/10, 1/3)
    """
    if isinstance(value, str):
        return parse_rational(name, value)
    if isinstance(value, Expr) and not value.is_Float:
        if value.is_real is False or value.has(nan):
            raise _not_real(name, value)
        return value
    if isinstance(value, bool):
        raise _not_real(name, value)
    if isinstance(value, Integral):
        return Rational(int(value))
    if isinstance(value, RationalNumber):
        return Rational(int(value.numerator), int(value.denominator))
    if isinstance(value, (Real, Expr)):
        return parse_rational(name, float.__repr__(float(value)))
    raise _not_real(name, value)


def _not_real(name: str, value: object) -> ValueError:
    return ValueError(
        f"{name} must be a finite real number or a symbol, got {value!r} (write 4, 0.25 or 1/3)"
    )
