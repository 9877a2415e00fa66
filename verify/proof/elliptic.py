"""Jacobi functions of integer combinations of arguments, by their addition theorems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp

from solutions.special import jacobi_cn, jacobi_dn, jacobi_sn

from .generator import Generator, Unsupported

if TYPE_CHECKING:
    from .translation import Translation


@dataclass(frozen=True)
class Point:
    """sn, cn, dn and the second-kind function (epsilon or zeta, which add alike) at one argument.

    The entries are images: rational expressions in generators.
    """

    m: sp.Expr
    sn: sp.Expr
    cn: sp.Expr
    dn: sp.Expr

    def __add__(self, other: Point) -> Point:
        below = 1 - self.m * self.sn**2 * other.sn**2
        return Point(
            self.m,
            (self.sn * other.cn * other.dn + other.sn * self.cn * self.dn) / below,
            (self.cn * other.cn - self.sn * self.dn * other.sn * other.dn) / below,
            (self.dn * other.dn - self.m * self.sn * self.cn * other.sn * other.cn) / below,
        )

    def __neg__(self) -> Point:
        return Point(self.m, -self.sn, self.cn, self.dn)


def origin(m: sp.Expr) -> Point:
    """The point of argument 0."""
    return Point(m, sp.S.Zero, sp.S.One, sp.S.One)


def multiple(point: Point, factor: int) -> Point:
    """The point of ``factor`` times the argument."""
    if factor < 0:
        return -multiple(point, -factor)
    if factor == 0:
        return origin(point.m)
    if factor == 1:
        return point
    half = multiple(point, factor // 2)
    return half + half + point if factor % 2 else half + half


def base_point(translation: Translation, argument: sp.Expr, m: sp.Expr) -> Point:
    """The point of a basis argument: new generators k sn, k cn and dn, or a known value.

    With ``S = k sn`` and ``C = k cn``, the relations S**2 + C**2 = k**2 and S**2 + dn**2 = 1
    are monic in each; the function that occurs most is the one they are solved for last.
    """
    parameter = translation.image(m)
    if argument == sp.elliptic_k(m):
        check_parameter(translation, argument, m)
        return Point(parameter, sp.S.One, sp.S.Zero, translation.image(sp.sqrt(1 - m)))
    modulus = translation.image(sp.sqrt(m))
    S, C, D = _generators(translation, argument, m, modulus, parameter)
    return Point(parameter, S / modulus, C / modulus, D)


def check_parameter(translation: Translation, expression: sp.Expr, m: sp.Expr) -> None:
    """Raise Unsupported unless m < 1 is shown: above, sqrt(1 - m) and K may belong to two branches."""
    if not translation.rewriting.signs.is_positive(1 - m):
        raise Unsupported(f"{m} is not shown to be below 1 on the domain, which {expression} needs")


def _generators(
    translation: Translation,
    argument: sp.Expr,
    m: sp.Expr,
    modulus: sp.Expr,
    parameter: sp.Expr,
) -> list[sp.Symbol]:
    functions = [jacobi_sn, jacobi_cn, jacobi_dn]
    meanings = [sp.sqrt(m) * jacobi_sn(argument, m), sp.sqrt(m) * jacobi_cn(argument, m)]
    meanings.append(jacobi_dn(argument, m))
    known = [translation.generators.known(meaning) for meaning in meanings]
    if None not in known:
        return [symbol for symbol in known if symbol is not None]
    S, C, D = symbols = [translation.generators.symbol(f"{f.__name__[-2:]}") for f in functions]
    rates = translation.derivatives(argument)
    products = [C * D, -S * D, -S * C]
    base = max(range(3), key=lambda i: translation.kernels.count[functions[i], m])
    levels = [sp.S.Zero, parameter, sp.S.One]  # S**2 = 0 + S**2, k**2 - C**2, 1 - D**2
    for i in sorted(range(3), key=lambda i: i != base):
        value = _square(i, base, symbols[base], levels)
        slopes = {v: rate * products[i] for v, rate in rates.items()}
        translation.generators.add(
            Generator(symbols[i], meanings[i], slopes, 0 if i == base else 2, value)
        )
    return symbols


def _square(i: int, base: int, symbol: sp.Symbol, levels: list[sp.Expr]) -> sp.Expr:
    """The square of function ``i`` of (S, C, D) in the square of function ``base``."""
    if i == base:
        return sp.S.Zero
    sine = symbol**2 if base == 0 else levels[base] - symbol**2
    return sine if i == 0 else levels[i] - sine


def point(translation: Translation, argument: sp.Expr, m: sp.Expr) -> Point:
    """The point of any argument met by the translation."""
    kernels = translation.kernels
    variable, constant = kernels.parts(argument)
    total: Point | None = None
    for lattice, part in ((kernels.moving(m), variable), (kernels.fixed(m), constant)):
        if part == 0:
            continue
        for basis_argument, factor in zip(lattice.basis, lattice.coordinates(part), strict=True):
            if factor:
                step = multiple(base_point(translation, basis_argument, m), factor)
                total = step if total is None else total + step
    return origin(translation.image(m)) if total is None else total
