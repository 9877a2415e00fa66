"""Linear phases ``p x + q t + r + w z`` as sums of three floats, at arrays of points.

The coefficients are sums of three floats as well. If ``p x`` and ``q t`` are 1e15 and cancel, the
sum still has double-double precision. A phase of 1e25, as at late times with strong forces, still
has the digits of its position in its period.
"""

from __future__ import annotations

import copyreg
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from longwave.solutions.run import doubledouble as dd
from longwave.solutions.run.doubledouble import Three, check_range, normalized, split_three
from longwave.support.compiled.jit import THREE, doubles, njit

if TYPE_CHECKING:
    from sympy import Expr

Array = NDArray[np.float64]

PHASE_ERROR = 2.0**-150
"""Bound of a phase's error, relative to the largest of its terms."""


@njit()
def _three(c: Three, x: float) -> Three:
    """Return ``c x`` as three floats."""
    high, e = dd.two_prod(c[0], x)
    middle, f = dd.two_prod(c[1], x)
    middle, e = dd.two_sum(middle, e)
    return high, middle, c[2] * x + (e + f)


@njit()
def _plus(a: Three, b: Three) -> Three:
    high, e = dd.two_sum(a[0], b[0])
    middle, f = dd.two_sum(a[1], b[1])
    middle, g = dd.two_sum(middle, e)
    return high, middle, a[2] + b[2] + (f + g)


@njit(cache=True, examples=[(THREE, doubles(1), doubles(2))])
def _add_across(w: Three, z: Array, out: Array) -> None:
    """Add ``w z`` to the phase in ``out``, which `_fill` has computed."""
    for i in range(z.size):
        transverse_term = _three(w, z[i])
        high, middle, low = _plus((out[0, i], out[1, i], out[2, i]), transverse_term)
        out[0, i], out[1, i], out[2, i] = normalized(high, middle, low)
        out[3, i] += PHASE_ERROR * abs(transverse_term[0])


@njit(cache=True, examples=[(THREE, THREE, THREE, doubles(1), doubles(1), doubles(2))])
def _fill(p: Three, q: Three, r: Three, x: Array, t: Array, out: Array) -> None:
    for i in range(x.size):
        moving, drifting = _three(p, x[i]), _three(q, t[i])
        high, middle, low = _plus(_plus(moving, drifting), r)
        out[0, i], out[1, i], out[2, i] = normalized(high, middle, low)
        out[3, i] = PHASE_ERROR * (abs(moving[0]) + abs(drifting[0]) + abs(r[0]))


def as_pairs(phase: Array) -> Array:
    """Return high part, low part and error bound of the values of a phase: (3, points).

    >>> as_pairs(np.array([[1.0], [2.0**-54], [-(2.0**-108)], [0.0]]))[2] == 2.0**-108
    array([ True])
    """
    pairs = phase[:3].copy()
    np.abs(pairs[2], out=pairs[2])
    pairs[2] += phase[3]
    return pairs


class LinearPhase:
    """A linear phase ``p x + q t + r + w z`` with exact or long coefficients.

    Raises OverflowError for a coefficient beyond 1e-250 .. 1e250.

    >>> from fractions import Fraction
    >>> phase = LinearPhase(Fraction(1, 3), Fraction(-1, 3), 0)
    >>> high, middle, low, bound = phase(np.array([1e6]), np.array([1e6]))
    >>> print(high[0], middle[0], low[0], bound[0] < 1e-38)
    0.0 0.0 0.0 True
    """

    def __init__(self, p: Any, q: Any, r: Any, w: Any = 0) -> None:
        p, q, r, w = (split_three(check_range(coefficient)) for coefficient in (p, q, r, w))
        self._coefficients: tuple[Three, Three, Three] = p, q, r
        self._transverse: Three = w

    @property
    def rate(self) -> float:
        """Coefficient p of x, rounded to a double."""
        return self._coefficients[0][0]

    def zero(self, t: float, z: float = 0.0) -> float | None:
        """Return the x at which the phase vanishes at time t; None for a phase constant in x.

        >>> LinearPhase(2, -6, 3).zero(1.0)
        1.5
        """
        p, q, r = (coefficient[0] for coefficient in self._coefficients)
        return None if p == 0 else -(q * t + r + self._transverse[0] * z) / p

    def __call__(self, x: Array, t: Array, *transverse: Array) -> Array:
        """Return the phase at the points (x, t), or (x, t, z), flat and of one size: (4, points).

        The first three rows are floats to be added, each below the rounding of the one before; the
        last row is a bound of the error of their sum.
        """
        out = np.empty((4, x.size))
        _fill(*self._coefficients, x, t, out)
        for z in transverse:
            _add_across(self._transverse, z, out)
        return out


CONSTANT_DIGITS = 120

LONG: Any = mpmath.MPContext()
"""mpmath context of long numbers, with CONSTANT_DIGITS digits."""
LONG.dps = CONSTANT_DIGITS


def long_number(exact: Expr | Fraction) -> Any:
    """Return an exact number as an mpf of the constants' precision."""
    if isinstance(exact, Fraction):
        return LONG.mpf(exact.numerator) / exact.denominator
    return LONG.mpf(exact._to_mpmath(LONG.prec))


def long_of(parts: tuple[int, int, int, int]) -> Any:
    """Return the mpf of a sign, mantissa, exponent and bit count, mpmath's internal format."""
    sign, mantissa, exponent, bits = parts
    return LONG.make_mpf((sign, mpmath.libmp.MPZ(mantissa), exponent, bits))


copyreg.pickle(LONG.mpf, lambda number: (long_of, (tuple(map(int, number._mpf_)),)))


@dataclass(frozen=True)
class Variables:
    """A closed form's variables: ``xi = a x + d t``, ``tau = b t``, ``zeta = e z``.

    The coefficients are long numbers. ``eps`` is set if x and t are site and lattice time, and None
    if they are X and T.
    """

    a: Any
    b: Any
    d: Any
    eps: Fraction | Expr | None = None
    e: Any = 0

    def phase(self, p: Any, q: Any, r: Any, w: Any = 0) -> LinearPhase:
        """Return ``p xi + q tau + r + w zeta`` as a phase in the caller's variables.

        The coefficients p, q, r, w are long numbers.

        Raises OverflowError for a coefficient beyond 1e-250 .. 1e250.
        """
        return LinearPhase(p * self.a, p * self.d + q * self.b, r, w * self.e)
