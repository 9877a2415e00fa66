"""What is taken for granted of each function: definitions, derivatives, addition theorems.

The arguments are fractions (`ring.Element`) or whatever has the same arithmetic; nothing here
knows of certificates.  ``docs/trust.md`` states each axiom as a formula.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from flint import fmpq

Value = Any
"""An element of a field: + - * / with its own kind and ``**`` with integers."""

HALF, TWO = fmpq(1, 2), 2

HYPERBOLIC: Mapping[str, Callable[[Value, Value], Value]] = {
    "cosh": lambda e, one: (e + one / e) / (one + one),
    "sinh": lambda e, one: (e - one / e) / (one + one),
    "tanh": lambda e, one: (e * e - one) / (e * e + one),
    "coth": lambda e, one: (e * e + one) / (e * e - one),
    "sech": lambda e, one: (e + e) / (e * e + one),
    "csch": lambda e, one: (e + e) / (e * e - one),
}
"""In e = exp(z)."""

TRIGONOMETRIC: Mapping[str, Callable[[Value, Value, Value], Value]] = {
    "cos": lambda e, one, i: (e + one / e) / (one + one),
    "sin": lambda e, one, i: (e - one / e) / (i + i),
    "tan": lambda e, one, i: (e * e - one) / (i * (e * e + one)),
    "cot": lambda e, one, i: i * (e * e + one) / (e * e - one),
    "sec": lambda e, one, i: (e + e) / (e * e + one),
    "csc": lambda e, one, i: i * (e + e) / (e * e - one),
}
"""In e = exp(i z)."""


Make = Callable[..., int]
"""`Nodes.made`."""


def inverse(name: str, f: int, made: Make) -> int:
    """The node that an inverse function of ``f`` is by definition; all values are principal ones.

    asinh f = log(f + sqrt(1 + f**2)), acosh f = log(f + sqrt(f - 1) sqrt(f + 1)),
    atanh f = (log(1 + f) - log(1 - f))/2, asin f = -i log(i f + sqrt(1 - f**2)),
    acos f = pi/2 - asin f.
    """
    one, minus, i = made("number", fmpq(1)), made("number", fmpq(-1)), made("I")
    square = made("Pow", f, fmpq(2))

    def root(node: int) -> int:
        return made("Pow", node, HALF)

    match name:
        case "asinh":
            return made("log", made("Add", f, root(made("Add", one, square))))
        case "acosh":
            factors = (root(made("Add", f, each)) for each in (minus, one))
            return made("log", made("Add", f, made("Mul", *factors)))
        case "atanh":
            negative = made("Mul", minus, f)
            ahead, behind = (made("log", made("Add", one, each)) for each in (f, negative))
            gap = made("Add", ahead, made("Mul", minus, behind))
            return made("Mul", made("number", HALF), gap)
        case "asin":
            rest = root(made("Add", one, made("Mul", minus, square)))
            turned = made("log", made("Add", made("Mul", i, f), rest))
            return made("Mul", minus, i, turned)
    quarter = made("Mul", made("number", HALF), made("pi"))
    return made("Add", quarter, made("Mul", minus, made("asin", f)))


INVERSE_OF: Mapping[str, str] = {
    "asin": "sin",
    "acos": "cos",
    "atan": "tan",
    "asinh": "sinh",
    "acosh": "cosh",
    "atanh": "tanh",
}


@dataclass(frozen=True)
class Station:
    """sn, cn, dn at an argument, and epsilon or zeta there (None where it is not wanted)."""

    m: Value
    sn: Value
    cn: Value
    dn: Value
    second: Value | None = None

    def __add__(self, other: Station) -> Station:
        """The addition theorems; epsilon and zeta have the same one."""
        one = self.sn.ring.number(1)
        below = one - self.m * self.sn**2 * other.sn**2
        sn = (self.sn * other.cn * other.dn + other.sn * self.cn * self.dn) / below
        cn = (self.cn * other.cn - self.sn * self.dn * other.sn * other.dn) / below
        dn = (self.dn * other.dn - self.m * self.sn * self.cn * other.sn * other.cn) / below
        second = None
        if self.second is not None and other.second is not None:
            second = self.second + other.second - self.m * self.sn * other.sn * sn
        return Station(self.m, sn, cn, dn, second)

    def __neg__(self) -> Station:
        """sn, epsilon and zeta are odd, cn and dn even."""
        second = None if self.second is None else -self.second
        return Station(self.m, -self.sn, self.cn, self.dn, second)

    def times(self, factor: int) -> Station:
        """The station at ``factor``, which is not 0, times the argument."""
        if factor < 0:
            return (-self).times(-factor)
        if factor == 1:
            return self
        half = self.times(factor // 2)
        return half + half + self if factor % 2 else half + half


def behind(
    m: Value, thetas: tuple[Value, Value, Value, Value], sines: tuple[Value, Value]
) -> Value:
    """Theta(u-d) from Theta(u+d), Theta(u), Theta(d), Theta(0) and sn u, sn d."""
    ahead, here, shift, zero = thetas
    one = m.ring.number(1)
    return (shift * here / zero) ** 2 * (one - m * sines[0] ** 2 * sines[1] ** 2) / ahead


SQUARES: Mapping[tuple[str, str], Callable[[Value, Value, Value], Value]] = {
    ("sn", "cn"): lambda c, m, one: one - c * c,
    ("sn", "dn"): lambda d, m, one: (one - d * d) / m,
    ("cn", "sn"): lambda s, m, one: one - s * s,
    ("cn", "dn"): lambda d, m, one: one - (one - d * d) / m,
    ("dn", "sn"): lambda s, m, one: one - m * s * s,
    ("dn", "cn"): lambda c, m, one: one - m + m * c * c,
}
"""The square of one Jacobi function in another of the same argument."""

PRODUCTS: Mapping[str, tuple[int, bool, tuple[str, str]]] = {
    "sn": (1, False, ("cn", "dn")),
    "cn": (-1, False, ("sn", "dn")),
    "dn": (-1, True, ("sn", "cn")),
}
"""The derivative in z: a sign, whether m is a factor, two functions."""
