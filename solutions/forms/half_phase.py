"""Sums ``a + b cosh(phase)`` divided by ``cosh(phase/2)**2``."""

import sympy as sp

__all__ = ["by_sech", "by_tanh"]


def by_tanh(total: sp.Expr, phase: sp.Expr) -> sp.Expr:
    """``(a + b) + (b - a) tanh(phase/2)**2``: nothing cancels where ``|a| <= b``.

    >>> z = sp.Symbol("z")
    >>> by_tanh(3 + 5 * sp.cosh(z), z)
    2*tanh(z/2)**2 + 8
    """
    a, b = _coefficients(total, phase)
    return (a + b) + (b - a) * sp.tanh(phase / 2) ** 2


def by_sech(total: sp.Expr, phase: sp.Expr) -> sp.Expr:
    """``2 b + (a - b) sech(phase/2)**2``: nothing cancels where ``a >= b >= 0``.

    >>> z = sp.Symbol("z")
    >>> by_sech(5 + 3 * sp.cosh(z), z)
    2*sech(z/2)**2 + 6
    """
    a, b = _coefficients(total, phase)
    return 2 * b + (a - b) * sp.sech(phase / 2) ** 2


def _coefficients(total: sp.Expr, phase: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    b = total.coeff(sp.cosh(phase))
    return total - b * sp.cosh(phase), b
