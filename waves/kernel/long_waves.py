r"""Dispersion of long waves: mu = (sin(k/2)/(k/2))^2 = 1 - u h(u) for u = k^2.

    h(u) = 2 sum (-u)^n/(2 n + 4)!,   h_2 = (h - 1/12)/u.

h and -h_2 are the cosine transforms of functions >= 0 on (-1, 1), hence for all u >= 0:
0 <= h <= 1/12, |h'| <= 1/360, -1/360 <= h_2 <= 0, |h_2'| <= 1/20160.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial

from flint import arb

from .cosine_series import upper

TERMS = 18
"""Number of terms of the power series of h used near 0."""


def h(u: arb) -> arb:
    """Return h on a ball u >= 0."""
    return _lipschitz(_h, u, 360)


def h2(u: arb) -> arb:
    """Return h_2 on a ball u >= 0."""
    return _lipschitz(_h2, u, 20160)


def _lipschitz(function: Callable[[arb], arb], u: arb, inverse_slope: int) -> arb:
    """Return a function on the ball ``u``; its slope is at most 1/``inverse_slope``."""
    return function(u.mid()) + arb(0, upper(u.rad() / inverse_slope))


def _h(u: arb) -> arb:
    if u > 1:
        half = u.sqrt() / 2
        ratio = half.sin() / half
        return (1 - ratio * ratio) / u
    return h_series(u)


def _h2(u: arb) -> arb:
    return (_h(u) - arb(1) / 12) / u if u > 1 else h_series(u, 1)


def h_series(u: arb, first: int = 0) -> arb:
    """Return 2 sum over n >= first of (-1)^n u^(n - first)/(2 n + 4)! for |u| <= 1.

    The nested form is 1 - u/(a (a + 1)) (1 - ...), where the factor of the last term is below 2.
    """
    total = arb(0, 2)
    for n in reversed(range(TERMS)):
        below = 2 * (n + first) + 5
        total = 1 - u * total / (below * (below + 1))
    return total * 2 * (-1) ** first / factorial(2 * first + 4)
