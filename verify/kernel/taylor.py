"""Taylor coefficients of special functions at a ball, each by its differential equation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import factorial

from flint import acb, fmpq

Series = list[acb]


def _product(left: Sequence[acb], right: Sequence[acb], place: int) -> acb:
    """Coefficient ``place`` of a product of series."""
    return sum((left[i] * right[place - i] for i in range(place + 1)), acb(0))


def exponential(z: acb, order: int) -> Series:
    """exp."""
    found = [z.exp()]
    for n in range(1, order + 1):
        found.append(found[-1] / n)
    return found


def periodic(name: str) -> Callable[[acb, int], Series]:
    """sin, cos, sinh or cosh, each two derivatives away from itself or minus itself."""
    other = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}[name]
    signs = {"sin": (1, 1, -1, -1), "cos": (1, -1, -1, 1)}.get(name, (1, 1, 1, 1))

    def taylor(z: acb, order: int) -> Series:
        pair = (getattr(z, name)(), getattr(z, other)())
        return [signs[n % 4] * pair[n % 2] / factorial(n) for n in range(order + 1)]

    return taylor


def power(exponent: Fraction) -> Callable[[acb, int], Series]:
    """z to a rational power (principal branch)."""
    q = fmpq(exponent.numerator, exponent.denominator)

    def taylor(z: acb, order: int) -> Series:
        found = [z.sqrt() if exponent == Fraction(1, 2) else _integer_or_root(z, exponent)]
        for n in range(1, order + 1):
            found.append(found[-1] * acb(q - n + 1) / (n * z))
        return found

    return taylor


def _integer_or_root(z: acb, exponent: Fraction) -> acb:
    if exponent.denominator == 1:
        return z**exponent.numerator
    return z.root(exponent.denominator) ** exponent.numerator


def logarithm(z: acb, order: int) -> Series:
    """log (principal branch)."""
    found, inverse = [z.log()], 1 / z
    term = acb(-1)
    for n in range(1, order + 1):
        term = -term * inverse
        found.append(term / n)
    return found


def arctangent(z: acb, order: int) -> Series:
    """atan, whose derivative is 1/(1 + z**2)."""
    square = [1 + z * z, 2 * z, acb(1)]
    inverse = [1 / square[0]]
    for n in range(1, order):
        known = sum((square[i] * inverse[n - i] for i in range(1, min(n, 2) + 1)), acb(0))
        inverse.append(-known / square[0])
    return [z.atan(), *(inverse[n - 1] / n for n in range(1, order + 1))]


def inverse(name: str) -> Callable[[acb, int], Series]:
    """asin, acos, asinh, acosh or atanh, off its cuts, by the powers in its derivative."""
    sign, factors = INVERSE_SLOPES[name]

    def taylor(z: acb, order: int) -> Series:
        slope = [acb(sign), *[acb(0)] * order]
        for square, exponent in factors:
            inner = [square[0] + square[1] * z + square[2] * z * z]
            inner += [acb(square[1]) + 2 * square[2] * z, acb(square[2])]
            power_series = _power_of_quadratic(inner, exponent, order)
            slope = [_product(slope, power_series, n) for n in range(order + 1)]
        return [getattr(z, name)(), *(slope[n] / (n + 1) for n in range(order))]

    return taylor


MINUS_HALF = Fraction(-1, 2)
INVERSE_SLOPES: dict[str, tuple[int, list[tuple[tuple[int, int, int], Fraction]]]] = {
    "asin": (1, [((1, 0, -1), MINUS_HALF)]),
    "acos": (-1, [((1, 0, -1), MINUS_HALF)]),
    "asinh": (1, [((1, 0, 1), MINUS_HALF)]),
    "acosh": (1, [((-1, 1, 0), MINUS_HALF), ((1, 1, 0), MINUS_HALF)]),
    "atanh": (1, [((1, 0, -1), Fraction(-1))]),
}
"""The sign, and the polynomials (1, z, z**2) with their exponents, of each derivative."""


def _power_of_quadratic(inner: Sequence[acb], exponent: Fraction, order: int) -> Series:
    """(a + b h + c h**2) to a power: n a p_n is a sum over the two terms before."""
    q = fmpq(exponent.numerator, exponent.denominator)
    found = power(exponent)(inner[0], 0)
    for n in range(1, order + 1):
        total = acb(q - n + 1) * inner[1] * found[n - 1]
        if n > 1:
            total += acb(2 * q - n + 2) * inner[2] * found[n - 2]
        found.append(total / (n * inner[0]))
    return found


class Elliptic:
    """The Jacobi functions of a real parameter ``m < 1``, ``m != 0``, at any argument."""

    def __init__(self, m: acb) -> None:
        if not (m.imag == 0 and m.real < 1 and m.real != 0):
            raise ValueError(f"m must satisfy m < 1 and m != 0, got {m.str(10)} (take 0 < k < 1)")
        self.m = m
        self.K, self.E = m.elliptic_k(), m.elliptic_e()
        self.tau = acb(0, 1) * (1 - m).elliptic_k() / self.K

    def sn(self, z: acb, order: int) -> Series:
        """sn."""
        return self._triple(z, order)[0]

    def cn(self, z: acb, order: int) -> Series:
        """cn."""
        return self._triple(z, order)[1]

    def dn(self, z: acb, order: int) -> Series:
        """dn."""
        return self._triple(z, order)[2]

    def epsilon(self, z: acb, order: int) -> Series:
        """The integral of dn**2 from 0."""
        dn = self.dn(z, order)
        start = self._zeta(z) + self.E / self.K * z
        return [start, *(_product(dn, dn, n) / (n + 1) for n in range(order))]

    def zeta(self, z: acb, order: int) -> Series:
        """Theta'/Theta."""
        found = self.epsilon(z, order)
        mean = self.E / self.K
        return [found[0] - mean * z, *(c - mean * (n == 0) for n, c in enumerate(found[1:]))]

    def theta(self, z: acb, order: int) -> Series:
        """Theta, with Theta' = zeta Theta."""
        zeta, found = self.zeta(z, order), [self._thetas(z)[3]]
        for n in range(order):
            found.append(_product(zeta, found, n) / (n + 1))
        return found

    def eta(self, z: acb, order: int) -> Series:
        """H = theta_2(0)/theta_3(0) sn Theta, the factor being sqrt(k)."""
        _, two, three, _ = self._thetas(acb(0))
        sn, theta, root = self.sn(z, order), self.theta(z, order), two / three
        return [root * _product(sn, theta, n) for n in range(order + 1)]

    def _thetas(self, z: acb) -> tuple[acb, ...]:
        return tuple(acb.modular_theta(z / (2 * self.K), self.tau))

    def _zeta(self, z: acb) -> acb:
        """theta_4'/theta_4 from Weierstrass' zeta function of the periods 1 and tau."""
        v = z / (2 * self.K) + self.tau / 2
        eta = acb(0.5).elliptic_zeta(self.tau)
        slope = v.elliptic_zeta(self.tau) - 2 * eta * v + acb(0, 1) * acb.pi()
        return slope / (2 * self.K)

    def _triple(self, z: acb, order: int) -> tuple[Series, Series, Series]:
        one, two, three, four = self._thetas(z)
        _, two_0, three_0, four_0 = self._thetas(acb(0))
        sn = [three_0 * one / (two_0 * four)]
        cn = [four_0 * two / (two_0 * four)]
        dn = [four_0 * three / (three_0 * four)]
        for n in range(order):
            slopes = _product(cn, dn, n), -_product(sn, dn, n), -self.m * _product(sn, cn, n)
            for series, slope in zip((sn, cn, dn), slopes, strict=True):
                series.append(slope / (n + 1))
        return sn, cn, dn
