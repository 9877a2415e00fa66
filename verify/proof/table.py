"""The table of generators: what is known of each function, one entry each.

An entry maps a SymPy node to its image and registers the generators it needs.  A new function is
one more entry.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import sympy as sp

from solutions.special import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)

from . import secondkind
from .algebraic import absolute, conjugate, imaginary_unit, power, sign, symbol
from .elementary import (
    base_of_logarithms,
    exponential,
    hyperbolic,
    primitive,
    primitive_of_the_real_line,
    trigonometric,
)
from .elliptic import point
from .kernels import HYPERBOLIC, TRIGONOMETRIC
from .translation import Handler

if TYPE_CHECKING:
    from .translation import Translation


def _jacobi(name: str) -> Handler:
    def image(translation: Translation, expression: sp.Expr) -> sp.Expr:
        found: sp.Expr = getattr(point(translation, *expression.args), name)
        return found

    return image


def _constant_function(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """A complete integral, pi: a constant of which nothing more is known."""
    return translation.primitive(expression.func.__name__.lower(), expression)


TABLE: Mapping[type, Handler] = {
    sp.Symbol: symbol,
    sp.Dummy: symbol,
    type(sp.I): imaginary_unit,
    type(sp.pi): _constant_function,
    type(sp.E): base_of_logarithms,
    sp.elliptic_k: _constant_function,
    sp.elliptic_e: _constant_function,
    sp.Pow: power,
    sp.Abs: absolute,
    sp.sign: sign,
    sp.conjugate: conjugate,
    sp.re: conjugate,
    sp.im: conjugate,
    sp.exp: exponential,
    **dict.fromkeys(HYPERBOLIC, hyperbolic),
    **dict.fromkeys(TRIGONOMETRIC, trigonometric),
    **dict.fromkeys((sp.log, sp.atan, sp.atanh), primitive),
    **dict.fromkeys((sp.asin, sp.acos, sp.asinh, sp.acosh), primitive_of_the_real_line),
    jacobi_sn: _jacobi("sn"),
    jacobi_cn: _jacobi("cn"),
    jacobi_dn: _jacobi("dn"),
    jacobi_epsilon: secondkind.additive,
    jacobi_zeta: secondkind.additive,
    jacobi_theta: secondkind.theta,
    jacobi_eta: secondkind.eta,
}
