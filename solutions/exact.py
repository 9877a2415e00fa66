"""Exact numbers from what a user writes."""

import math
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Rational, Real

import sympy as sp

__all__ = ["exact_number", "shown"]

LONGEST = 40


def shown(value: object) -> str:
    """``value`` as a message shows it: in one line of at most ``LONGEST`` characters.

    >>> shown(10**5000), shown("a" * 50)
    ('an int of 16610 bits', "'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa...")
    """
    if isinstance(value, int) and value.bit_length() > 1000:
        return f"an int of {value.bit_length()} bits"
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def exact_number(name: str, value: object) -> sp.Expr:
    """The exact SymPy number meant by ``value``; a float means its decimal literal.

    ``value`` may be an int, a float, a Fraction, a Decimal, a NumPy scalar or a real SymPy
    number such as ``elliptic_k(Rational(1, 4)) / 2``. ``name`` is used in the message.

    Raises ValueError for NaN, infinities, complex numbers and anything that is no number.

    >>> exact_number("k", 0.7)
    7/10
    >>> exact_number("k", "0.7")
    Traceback (most recent call last):
    ...
    ValueError: k must be a real number, got '0.7' (write it without quotes)
    """
    if isinstance(value, sp.Expr):
        return _exact_expression(name, value)
    if isinstance(value, bool) or not isinstance(value, Real | Decimal):
        remedy = (
            "write it without quotes"
            if isinstance(value, str)
            else "such as 0.7 or Fraction(7, 10)"
        )
        raise ValueError(f"{name} must be a real number, got {shown(value)} ({remedy})")
    if isinstance(value, Integral):
        return sp.Integer(int(value))
    if isinstance(value, Rational):
        return sp.Rational(int(value.numerator), int(value.denominator))
    literal = str(value) if isinstance(value, Decimal) else repr(float(value))
    if not math.isfinite(float(literal)):
        raise ValueError(f"{name} must be finite, got {literal} (take a number)")
    fraction = Fraction(literal)
    return sp.Rational(fraction.numerator, fraction.denominator)


def _exact_expression(name: str, value: sp.Expr) -> sp.Expr:
    if value.free_symbols:
        raise ValueError(f"{name} must be a number, got {value} (substitute its symbols first)")
    if not (value.is_real and value.is_finite) and not sp.N(value).is_Float:
        raise ValueError(f"{name} must be real and finite, got {value} (take a real number)")
    exact: sp.Expr = sp.nsimplify(value, rational=True) if value.has(sp.Float) else value
    return exact
