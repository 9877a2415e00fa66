"""Exponentials, trigonometric and hyperbolic functions, and primitives made of logarithms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy as sp

from .generator import Unsupported
from .lattice import without_logarithms

if TYPE_CHECKING:
    from .translation import Translation


def exponential(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A product of powers of the exponentials of the basis arguments."""
    return power_of_e(translation, expression.args[0])


def hyperbolic(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """sinh, cosh, tanh and their reciprocals in one exponential."""
    e = power_of_e(translation, expression.args[0])
    return _in_exponential(expression.func, e)


def trigonometric(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """sin, cos, tan and their reciprocals in one exponential and I."""
    i = translation.image(sp.I)
    e = power_of_e(translation, sp.I * expression.args[0])
    return {
        sp.cos: (e + 1 / e) / 2,
        sp.sin: (e - 1 / e) / (2 * i),
        sp.tan: (e**2 - 1) / (i * (e**2 + 1)),
        sp.cot: i * (e**2 + 1) / (e**2 - 1),
        sp.sec: 2 / (e + 1 / e),
        sp.csc: 2 * i / (e - 1 / e),
    }[expression.func]


def _in_exponential(function: type, e: sp.Expr) -> sp.Expr:
    return {
        sp.cosh: (e + 1 / e) / 2,
        sp.sinh: (e - 1 / e) / 2,
        sp.tanh: (e**2 - 1) / (e**2 + 1),
        sp.coth: (e**2 + 1) / (e**2 - 1),
        sp.sech: 2 / (e + 1 / e),
        sp.csch: 2 / (e - 1 / e),
    }[function]


def power_of_e(translation: Translation, argument: sp.Expr) -> sp.Expr:
    """exp(argument) in the exponentials of the basis arguments; exp(q log f) is f**q."""
    rest, logarithms = without_logarithms(argument)
    lattice = translation.kernels.exponents
    powers = zip(lattice.basis, lattice.coordinates(rest), strict=True)
    factors = [_generator(translation, basis) ** n for basis, n in powers if n]
    factors += [translation.image(sp.Pow(f, q)) for f, q in logarithms.items()]
    return sp.Mul(*factors)


def _generator(translation: Translation, argument: sp.Expr) -> sp.Symbol:
    meaning = sp.exp(argument)
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    symbol = translation.generators.symbol("e")
    rates = translation.derivatives(argument)
    return translation.register(symbol, meaning, {v: r * symbol for v, r in rates.items()})


def base_of_logarithms(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """The number e."""
    return power_of_e(translation, sp.S.One)


def primitive(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A function with SymPy's derivative off its cuts, such as f'/(1 + f**2) of atan f."""
    return translation.primitive(expression.func.__name__, expression)


def primitive_of_the_real_line(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """asin, acos, acosh or asinh, off whose cuts the argument must be shown to lie.

    On a cut, the root in SymPy's derivative and the function may belong to different sides.
    """
    if not translation.rewriting.signs.is_real(expression):
        raise Unsupported(f"{expression} is not shown to be real on the domain")
    return primitive(translation, expression)
