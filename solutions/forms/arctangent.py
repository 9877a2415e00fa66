"""Waves of the form ``U = 2 d/dxi arctan(f)``."""

import sympy as sp

from solutions.symbols import xi

__all__ = ["arctangent_slope", "bounded_slope"]


def arctangent_slope(tangent: sp.Expr) -> sp.Expr:
    """``2 d/dxi arctan(tangent)``."""
    return 2 * sp.diff(sp.atan(tangent), xi)


def bounded_slope(tangent: sp.Expr) -> sp.Expr:
    """The same with every ``1/cosh`` written ``sech``, so that nothing grows exponentially."""
    bounded = tangent.replace(sp.cosh, lambda z: 1 / sp.sech(z))
    return 2 * sp.diff(bounded, xi) / (1 + bounded**2)
