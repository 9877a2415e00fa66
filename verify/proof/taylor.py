"""Taylor coefficients of functions at a ball, from FLINT's series or differential equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import partialmethod
from math import factorial
from typing import Any

from flint import acb, acb_series, ctx, fmpq

from longwave.verify.kernel.axioms import CYLINDER, FUNCTIONS
from longwave.verify.kernel.function_values import Jacobi

Series = list[acb]


def _product(left: Sequence[acb], right: Sequence[acb], place: int) -> acb:
    """Return coefficient number ``place`` of a product of series."""
    return sum((left[i] * right[place - i] for i in range(place + 1)), acb(0))


def periodic(name: str) -> Callable[[acb, int], Series]:
    """Return the series of sin, cos, sinh or cosh, from the alternating derivatives."""
    other = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}[name]
    signs = {"sin": (1, 1, -1, -1), "cos": (1, -1, -1, 1)}.get(name, (1, 1, 1, 1))

    def taylor(z: acb, order: int) -> Series:
        pair = (getattr(z, name)(), getattr(z, other)())
        return [signs[n % 4] * pair[n % 2] / factorial(n) for n in range(order + 1)]

    return taylor


def power(exponent: Fraction) -> Callable[[acb, int], Series]:
    """Return the series of a rational power (principal branch)."""
    q = fmpq(exponent.numerator, exponent.denominator)

    def taylor(z: acb, order: int) -> Series:
        root = z if q.q == 1 else z.sqrt() if exponent == Fraction(1, 2) else z.root(int(q.q))
        series = [root if exponent == Fraction(1, 2) else root ** int(q.p)]
        for n in range(1, order + 1):
            series.append(series[-1] * acb(q - n + 1) / (n * z))
        return series

    return taylor


@contextmanager
def _terms(count: int) -> Iterator[None]:
    """Set the number of terms of FLINT's series in a block; the default is only 10 terms."""
    before, ctx.cap = ctx.cap, count
    try:
        yield
    finally:
        ctx.cap = before


def special(name: str) -> Callable[[acb, int], Series]:
    """Return the series of a function, computed by FLINT's method ``name``."""

    def taylor(z: acb, order: int) -> Series:
        with _terms(order + 1):
            series = getattr(acb_series([z, 1], order + 1), name)()
        return [series[n] for n in range(order + 1)]

    return taylor


logarithm = special("log")


def _ball(name: str, *arguments: Any) -> acb:
    """Return the kernel's ball of a function; ``name`` is a key of its function table."""
    ball = FUNCTIONS[name].ball
    assert ball is not None
    return ball(*arguments)


def bessel(name: str, v: acb) -> Callable[[acb, int], Series]:
    """Return the series of a Bessel function of order ``v``."""
    sign, up = -1 if name in ("bessel_i", "bessel_k") else 1, CYLINDER[name][0]

    def taylor(z: acb, order: int) -> Series:
        value = _ball(name, v, z)
        series = [value, v / z * value + up * _ball(name, v + 1, z)]
        for n in range(order - 1):
            rest = (n * n + sign * z * z - v * v) * series[n]
            rest += (n + 1) * (2 * n + 1) * z * series[-1]
            rest += sign * (2 * z * series[n - 1] if n else acb(0))
            rest += sign * (series[n - 2] if n > 1 else acb(0))
            series.append(-rest / ((n + 2) * (n + 1) * z * z))
        return series[: order + 1]

    return taylor


def weierstrass(g2: acb, g3: acb, slopes: int) -> Callable[[acb, int], Series]:
    """Return the series of Weierstrass' p with these invariants; with ``slopes`` = 1, of p'."""

    def taylor(z: acb, order: int) -> Series:
        series = [_ball(name, z, g2, g3) for name in ("weierstrass_p", "weierstrass_p_prime")]
        for n in range(order + slopes - 1):
            rest = 6 * _product(series, series, n) - (g2 / 2 if n == 0 else 0)
            series.append(rest / ((n + 2) * (n + 1)))
        return [c * (n or 1) if slopes else c for n, c in enumerate(series)][slopes:][: order + 1]

    return taylor


def free(name: str, start: int, *nome: acb) -> Callable[[acb, int], Series]:
    """Return the series of the ``start``-th derivative of a theta or an arbitrary function."""
    kind = "theta" if nome else "jet"
    return lambda z, order: [
        _ball(kind, z, *nome, (name, start + n)) / factorial(n) for n in range(order + 1)
    ]


def inverse(name: str) -> Callable[[acb, int], Series]:
    """Return the series of asin, acos, atan, asinh, acosh or atanh off its cuts, by its slope."""

    def taylor(z: acb, order: int) -> Series:
        with _terms(order + 1):
            slope = INVERSE_SLOPES[name](acb_series([z, 1], order + 1))
        return [getattr(z, name)(), *(slope[n] / (n + 1) for n in range(order))]

    return taylor


INVERSE_SLOPES: dict[str, Callable[[acb_series], acb_series]] = {
    "asin": lambda z: (1 - z * z).rsqrt(),
    "acos": lambda z: -(1 - z * z).rsqrt(),
    "atan": lambda z: 1 / (1 + z * z),
    "asinh": lambda z: (1 + z * z).rsqrt(),
    "acosh": lambda z: (z - 1).rsqrt() * (z + 1).rsqrt(),
    "atanh": lambda z: 1 / (1 - z * z),
}


class ElementaryJacobi:
    """Jacobi functions at m = 0 and at m = 1: sn, cn, dn and epsilon; zeta only at m = 0."""

    K = E = acb(1)
    """Complete integrals K and E up to a common factor; only the ratio E/K is used."""

    def __init__(self, m: acb) -> None:
        self.m = m
        self.sn, self.cn = (acb.sin, acb.cos) if m == 0 else (acb.tanh, acb.sech)

    def dn(self, z: acb) -> acb:
        """Return dn(z)."""
        return acb(1) if self.m == 0 else z.sech()

    def epsilon(self, z: acb) -> acb:
        """Return epsilon(z), the integral of dn**2 from 0 to z."""
        return z if self.m == 0 else z.tanh()

    def zeta(self, z: acb) -> acb:
        """Return zeta = Theta'/Theta for m = 0, where it is 0; raises ValueError for m = 1."""
        return acb(0) if self.m == 0 else self.theta(z)

    def theta(self, _z: acb) -> acb:
        """Raise ValueError: Theta is not available at m = 0 and m = 1."""
        raise ValueError(f"this function needs 0 < m < 1, got m = {self.m.str(10)}")


class Elliptic:
    """Series of the Jacobi functions with a real parameter."""

    def __init__(self, m: acb) -> None:
        self._values = (ElementaryJacobi if m in (0, 1) else Jacobi)(m)

    def epsilon(self, z: acb, order: int) -> Series:
        """Return the series of epsilon, the integral of dn**2 from 0 to z."""
        dn = self.dn(z, order)
        start = self._values.epsilon(z)
        return [start, *(_product(dn, dn, n) / (n + 1) for n in range(order))]

    def zeta(self, z: acb, order: int) -> Series:
        """Return the series of zeta = Theta'/Theta."""
        rest, mean = self.epsilon(z, order)[1:], self._values.E / self._values.K
        return [self._values.zeta(z), *(c - mean * (n == 0) for n, c in enumerate(rest))]

    def theta(self, z: acb, order: int) -> Series:
        """Return the series of theta, from Theta' = zeta Theta."""
        zeta, series = self.zeta(z, order), [self._values.theta(z)]
        for n in range(order):
            series.append(_product(zeta, series, n) / (n + 1))
        return series

    def eta(self, z: acb, order: int) -> Series:
        """Return the series of H = sqrt(k) sn Theta."""
        sn, theta = self.sn(z, order), self.theta(z, order)
        root_k = self._values.m.root(4)
        return [root_k * _product(sn, theta, n) for n in range(order + 1)]

    def _triple(self, place: int, z: acb, order: int) -> Series:
        """Return the series of sn, cn or dn, from the differential equations of all three."""
        values = self._values
        sn, cn, dn = [values.sn(z)], [values.cn(z)], [values.dn(z)]
        for n in range(order):
            slopes = _product(cn, dn, n), -_product(sn, dn, n), -values.m * _product(sn, cn, n)
            for series, slope in zip((sn, cn, dn), slopes, strict=True):
                series.append(slope / (n + 1))
        return (sn, cn, dn)[place]

    sn, cn, dn = partialmethod(_triple, 0), partialmethod(_triple, 1), partialmethod(_triple, 2)
