"""Symbols, the imaginary unit, roots, and conjugates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy as sp

from .generator import Unsupported

if TYPE_CHECKING:
    from .translation import Translation


def symbol(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A variable or a parameter.

    Where sqrt(1 - s**2) occurs, it is a free generator and s is algebraic over it.
    """
    known = translation.generators.known(expression)
    if known is not None:
        return known
    if expression in translation.kernels.circles:
        other = translation.primitive(f"{expression.name}_prime", sp.sqrt(1 - expression**2))
        own = translation.generators.symbol(expression.name)
        return translation.register(own, expression, {}, 2, 1 - other**2)
    return translation.primitive(expression.name, expression)


def imaginary_unit(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A generator i with i**2 = -1."""
    known = translation.generators.known(expression)
    if known is not None:
        return known
    own = translation.generators.symbol("i")
    return translation.register(own, expression, {}, 2, sp.S.NegativeOne)


def power(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A root: a generator whose power is known.  abs(f)**2 is f times its conjugate."""
    base, exponent = expression.base, expression.exp
    if isinstance(base, sp.Abs) and exponent.is_Integer and exponent % 2 == 0:
        inner = base.args[0]
        square = translation.image(inner) * translation.image(sp.conjugate(inner))
        return square ** (exponent / 2)
    if not exponent.is_Rational:
        raise Unsupported(f"no generator is known for the power {expression}")
    if base.is_Integer:
        primes = sp.factorint(base)
        if len(primes) > 1 or set(primes.values()) != {1}:
            roots = (translation.image(sp.Integer(p) ** exponent) ** n for p, n in primes.items())
            return sp.Mul(*roots)
    return _root(translation, base, int(exponent.q)) ** int(exponent.p)


def _root(translation: Translation, base: sp.Expr, degree: int) -> sp.Expr:
    meaning = sp.Pow(base, sp.Rational(1, degree))
    rest = 1 - base
    if degree == 2 and rest.is_Pow and rest.base in translation.kernels.circles:
        translation.image(rest.base)
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    value = translation.image(base)
    own = translation.generators.symbol("root")
    rates = translation.derivatives(base)
    slopes = {v: rate * own / (degree * value) for v, rate in rates.items()}
    return translation.register(own, meaning, slopes, degree, value)


def conjugate(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A conjugate, real or imaginary part: I becomes -I, everything else must be real."""
    inner = expression.args[0]
    if not all(free.is_real for free in inner.free_symbols):
        raise Unsupported(f"the conjugate of {inner} needs real symbols (declare them real)")
    value, other = translation.image(inner), translation.image(inner.xreplace({sp.I: -sp.I}))
    if expression.func is sp.conjugate:
        return other
    if expression.func is sp.re:
        return (value + other) / 2
    return (value - other) / (2 * translation.image(sp.I))
