"""Symbols, the imaginary unit, roots, absolute values and conjugates."""

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
    if isinstance(base, sp.Abs) and exponent.is_Integer:
        if exponent % 2:
            return translation.image(base) ** exponent
        return _square(translation, base.args[0]) ** (exponent / 2)
    if not exponent.is_Rational:
        raise Unsupported(f"no generator is known for the power {expression}")
    if base.is_Integer:
        primes = sp.factorint(base)
        if len(primes) > 1 or set(primes.values()) != {1}:
            roots = (translation.image(sp.Integer(p) ** exponent) ** n for p, n in primes.items())
            return sp.Mul(*roots)
    degree = translation.kernels.degrees.get(base, 1)
    degree *= int(exponent.q) // sp.igcd(degree, exponent.q)
    return _root(translation, base, degree) ** int(exponent * degree)


def absolute(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """abs(f), a generator whose square is f times its conjugate."""
    square = _square(translation, expression.args[0])
    return _registered_root(translation, "abs", expression, square, 2)


def sign(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """f/abs(f)."""
    inner = expression.args[0]
    return translation.image(inner) / translation.image(sp.Abs(inner))


def conjugate(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """What `rewriting` leaves of conjugates: those of roots and logarithms of unknown sign."""
    raise Unsupported(
        f"{expression} is not simplified on the domain: a root or logarithm in it may be of a "
        "negative number"
    )


def _square(translation: Translation, inner: sp.Expr) -> sp.Expr:
    other = translation.rewriting(sp.conjugate(inner))
    return translation.image(inner) * translation.image(other)


def _root(translation: Translation, base: sp.Expr, degree: int) -> sp.Expr:
    meaning = sp.Pow(base, sp.Rational(1, degree))
    rest = 1 - base
    if degree == 2 and rest.is_Pow and rest.base in translation.kernels.circles:
        translation.image(rest.base)
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    return _registered_root(translation, "root", meaning, translation.image(base), degree)


def _registered_root(
    translation: Translation, name: str, meaning: sp.Expr, value: sp.Expr, degree: int
) -> sp.Expr:
    """The generator of a root of ``value``; w' = v'/(n v) w holds for every branch."""
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    own = translation.generators.symbol(name)
    if isinstance(meaning, sp.Pow):
        rates = translation.derivatives(meaning.base)
    else:
        rates = translation.derivatives_of_image(value)
    slopes = {v: rate * own / (degree * value) for v, rate in rates.items()}
    return translation.register(own, meaning, slopes, degree, value)
