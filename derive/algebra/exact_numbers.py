"""Checks of arguments: numbers made exact without evaluating text, errors naming the argument."""

import math
import re
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Real
from numbers import Rational as RationalNumber
from typing import Any, TypeAlias, TypeVar

from sympy import Expr, Float, I, N, Rational, nan, nsimplify, oo, zoo
from sympy.matrices.expressions.matexpr import MatrixExpr

from longwave.support.user_files import shown

Kind = TypeVar("Kind")

Number: TypeAlias = int | float | str | Fraction | Decimal | Expr

LONGEST_NUMBER = 1000
"""Longest number in text, in characters."""

_DECIMAL = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_RATIO = re.compile(r"[+-]?\d+/\d+", re.ASCII)


def parse_rational(name: str, text: str) -> Rational:
    """Return the exact rational of a text: an integer, a decimal or ``p/q``.

    ``name`` is the argument named in the ValueError for anything else.

    >>> parse_rational("K4", "0.1"), parse_rational("K4", "-3/6")
    (1/10, -1/2)
    """
    stripped = text.strip()
    spelt = _DECIMAL.fullmatch(stripped) or _RATIO.fullmatch(stripped)
    if not spelt or len(stripped) > LONGEST_NUMBER:
        raise ValueError(
            f"{name} must be a rational number, got {shown(text)} (write 4, 0.25, 1e-3 or 1/3)"
        )
    try:
        value = Fraction(stripped)
    except ZeroDivisionError:
        raise ValueError(
            f"{name} must have a nonzero denominator, got {shown(text)} (write 4, 0.25 or 1/3)"
        ) from None
    return Rational(value.numerator, value.denominator)


def exact(name: str, value: Number) -> Expr:
    """Return ``value`` exactly: a float as its shortest decimal, symbols unchanged.

    Raises ValueError for text that is not a rational number, for NaN and infinity, for non-real
    numbers, and for an expression that contains a float, NaN, infinity or I.

    >>> exact("K2", 0.1), exact("K2", "1/3")
    (1/10, 1/3)
    """
    if isinstance(value, str):
        return parse_rational(name, value)
    if isinstance(value, Expr) and not value.is_Float:
        if value.has(Float):
            raise ValueError(
                f"{name} must be exact, got {shown(value)} with a float in it (write "
                "Rational(1, 10) for 0.1)"
            )
        unreal = value.is_real is False or value.has(nan, oo, -oo, zoo, I)
        if unreal or not value.is_commutative or isinstance(value, MatrixExpr):
            raise _not_real(name, value)
        return value
    if isinstance(value, bool):
        raise _not_real(name, value)
    if isinstance(value, Decimal) and value.is_finite():
        return parse_rational(name, f"{value:e}")
    if isinstance(value, RationalNumber):
        return Rational(int(value.numerator), int(value.denominator))
    if isinstance(value, (Real, Float)):
        return parse_rational(name, _decimal(name, value))
    raise _not_real(name, value)


def _decimal(name: str, value: Any) -> str:
    """Return the shortest decimal that reads as ``value``. Raises ValueError if there is none."""
    texts = [repr(float(value))] if isinstance(value, float) else [str(value), repr(float(value))]
    for text in texts:
        with suppress(TypeError, ValueError):  # types that are not made from text
            if _DECIMAL.fullmatch(text) and type(value)(text) == value:
                return text
    raise _not_real(name, value)


def _not_real(name: str, value: object) -> ValueError:
    return ValueError(
        f"{name} must be a finite real number or a symbol, got {shown(value)} "
        "(write 4, 0.25 or 1/3)"
    )


def exact_number(name: str, value: object) -> Expr:
    """Return the exact SymPy number of ``value``; a float means its decimal literal.

    ``value`` may be an int, a float, a Fraction, a Decimal, a NumPy scalar or a real SymPy
    number such as ``elliptic_k(Rational(1, 4)) / 2``. ``name`` is used in the message.

    Raises ValueError for NaN, infinities, complex numbers and anything that is not a number.

    >>> exact_number("k", 0.7)
    7/10
    >>> exact_number("k", "0.7")
    Traceback (most recent call last):
    ...
    ValueError: k must be a real number, got '0.7' (write it without quotes)
    """
    if isinstance(value, Expr):
        if value.free_symbols:
            raise ValueError(f"{name} must be a number, got {value} (substitute its symbols first)")
        if not (value.is_real and value.is_finite) and not N(value).is_Float:
            raise ValueError(f"{name} must be real and finite, got {value} (take a real number)")
        return nsimplify(value, rational=True) if value.has(Float) else value
    if isinstance(value, bool) or not isinstance(value, Real | Decimal):
        is_text = isinstance(value, str)
        remedy = "write it without quotes" if is_text else "such as 0.7 or Fraction(7, 10)"
        raise ValueError(f"{name} must be a real number, got {shown(value)} ({remedy})")
    if isinstance(value, RationalNumber):
        return Rational(int(value.numerator), int(value.denominator))
    literal = str(value) if isinstance(value, Decimal) else repr(float(value))
    if not math.isfinite(float(literal)):
        raise ValueError(f"{name} must be finite, got {literal} (take a number)")
    fraction = Fraction(literal)
    return Rational(fraction.numerator, fraction.denominator)


def integer(name: str, value: object, least: int, hint: str) -> int:
    """Return ``value`` as an int >= ``least``. Raises ValueError, with ``hint``, otherwise."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise ValueError(f"{name} must be an integer >= {least}, got {shown(value)} ({hint})")
    return int(value)


def instance(name: str, value: object, kind: type[Kind], remedy: str) -> Kind:
    """Return ``value`` if it is of type ``kind``. Raises ValueError, with ``remedy``, otherwise.

    >>> instance("name", 3, str, "such as 'chain'")
    Traceback (most recent call last):
    ...
    ValueError: name must be a str, got 3 (such as 'chain')
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOaeio" else "a"
        raise ValueError(f"{name} must be {article} {kind.__name__}, got {shown(value)} ({remedy})")
    return value


def tuple_of(name: str, value: object, kind: type[Kind], remedy: str) -> tuple[Kind, ...]:
    """Return a nonempty tuple or list of ``kind`` entries as a tuple; ValueError for any other."""
    if not isinstance(value, tuple | list) or not value:
        kinds = "" if kind is object else f" of {kind.__name__}"
        raise ValueError(f"{name} must be a tuple{kinds}, got {shown(value)} ({remedy})")
    return tuple(instance(f"each of {name}", entry, kind, remedy) for entry in value)
