"""Identities that hold for some signs only, or up to a branch.

Roots, logarithms, moduli and inverse functions; conjugates, real and imaginary parts; numbers
written with nested roots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import sympy as sp

from searches.statements.formulas import (
    constant,
    formula,
    number,
    phase,
    positive,
    rewritten,
)
from searches.statements.random_statement import Point, RandomStatement, Setting
from searches.texts.text_statement import Truth

Sides = Callable[[sp.Expr, sp.Expr], tuple[sp.Expr, sp.Expr]]


@dataclass(frozen=True)
class Branch:
    """Two formulas in s and r, and the pairs of signs for which they are equal.

    A sign 0 stands for "both"; what is not listed is false.
    """

    sides: Sides
    signs: frozenset[tuple[int, int]]


ANY = (-1, 0, 1)
POSITIVE = frozenset((1, r) for r in ANY)
NEGATIVE = frozenset((-1, r) for r in ANY)
ALWAYS = frozenset((s, r) for s in ANY for r in ANY)
ONE_POSITIVE = frozenset((s, r) for s, r in ALWAYS if 1 in (s, r))
third, quarter = sp.Rational(1, 3), sp.Rational(1, 4)


def _hidden(power: sp.Expr) -> sp.Expr:
    """A power that SymPy does not take the root of at once."""
    return sp.expand(power)


BRANCHES = {
    "root of a square": Branch(lambda s, r: (sp.sqrt(_hidden(s**2)), s), POSITIVE),
    "root of a square, minus": Branch(lambda s, r: (sp.sqrt(_hidden(s**2)), -s), NEGATIVE),
    "root of a square, modulus": Branch(lambda s, r: (sp.sqrt(_hidden(s**2)), sp.Abs(s)), ALWAYS),
    "root of a product": Branch(
        lambda s, r: (sp.sqrt(_hidden(s * r)), sp.sqrt(s) * sp.sqrt(r)), ONE_POSITIVE
    ),
    "root of a quotient": Branch(
        lambda s, r: (sp.sqrt(s / r), sp.sqrt(s) / sp.sqrt(r)),
        frozenset({(1, 1), (0, 1), (-1, 1), (-1, -1)}),
    ),
    "cube root of a square": Branch(
        lambda s, r: (_hidden(s**2) ** third, s ** (2 * third)), POSITIVE
    ),
    "cube root of a cube": Branch(lambda s, r: (_hidden(s**3) ** third, s), POSITIVE),
    "fourth root": Branch(lambda s, r: (_hidden(s**4) ** quarter, sp.Abs(s)), ALWAYS),
    "fourth root of a square": Branch(
        lambda s, r: (_hidden(s**2) ** quarter, sp.sqrt(s)), POSITIVE
    ),
    "fourth root, modulus": Branch(
        lambda s, r: (_hidden(s**2) ** quarter, sp.sqrt(sp.Abs(s))), ALWAYS
    ),
    "log of a product": Branch(
        lambda s, r: (sp.log(_hidden(s * r)), sp.log(s) + sp.log(r)), ONE_POSITIVE
    ),
    "log of a square": Branch(lambda s, r: (sp.log(_hidden(s**2)), 2 * sp.log(s)), POSITIVE),
    "log of a square, minus": Branch(
        lambda s, r: (sp.log(_hidden(s**2)), 2 * sp.log(-s)), NEGATIVE
    ),
    "log of a square, modulus": Branch(
        lambda s, r: (sp.log(_hidden(s**2)), 2 * sp.log(sp.Abs(s))), ALWAYS
    ),
    "sign": Branch(lambda s, r: (s * sp.sign(s), sp.sqrt(_hidden(s**2))), ALWAYS),
    "sign is 1": Branch(lambda s, r: (sp.Abs(s) / s + r, 1 + r), POSITIVE),
    "product of moduli": Branch(
        lambda s, r: (sp.Abs(_hidden(s * r)), sp.Abs(s) * sp.Abs(r)), ALWAYS
    ),
    "modulus of a product": Branch(
        lambda s, r: (sp.Abs(_hidden(s * r)), s * r), frozenset({(1, 1), (-1, -1)})
    ),
    "atan of the inverse": Branch(lambda s, r: (sp.atan(s) + sp.atan(1 / s), sp.pi / 2), POSITIVE),
    "root of I s": Branch(
        lambda s, r: (sp.sqrt(_hidden(sp.I * s)), (1 + sp.I) / sp.sqrt(2) * sp.sqrt(s)), POSITIVE
    ),
    "nested root": Branch(
        lambda s, r: (sp.sqrt(_hidden((sp.sqrt(s) + 1) ** 2)), 1 + sp.sqrt(s)), ALWAYS
    ),
    "root of sech": Branch(lambda s, r: (sp.sqrt(1 - sp.tanh(s) ** 2), sp.sech(s)), ALWAYS),
    "root of cosh": Branch(lambda s, r: (sp.sqrt(sp.cosh(s) ** 2 - 1), sp.sinh(s)), POSITIVE),
    "root of an exponential": Branch(
        lambda s, r: (sp.sqrt(sp.cosh(2 * s) + sp.sinh(2 * s)), sp.exp(s)), ALWAYS
    ),
    "asinh": Branch(lambda s, r: (sp.asinh(sp.sinh(s, evaluate=False), evaluate=False), s), ALWAYS),
    "acosh": Branch(lambda s, r: (sp.acosh(sp.cosh(s)), s), POSITIVE),
    "slope of a modulus": Branch(lambda s, r: (s * sp.Abs(s), s**2), POSITIVE),
}
INTERVALS = {
    "root of cos": (lambda s: (sp.sqrt(1 - sp.sin(s) ** 2), sp.cos(s)), -1.57, 1.57),
    "root of sin": (lambda s: (sp.sqrt(1 - sp.cos(s) ** 2), sp.sin(s)), 0.0, 3.14),
    "half angle": (lambda s: (sp.sqrt(2 + 2 * sp.cos(s)), 2 * sp.cos(s / 2)), -3.14, 3.14),
    "atan of tan": (lambda s: (sp.atan(sp.tan(s)), s), -1.57, 1.57),
    "asin of sin": (lambda s: (sp.asin(sp.sin(s)), s), -1.57, 1.57),
    "root of a phase": (lambda s: (sp.sqrt(sp.exp(sp.I * s)), sp.exp(sp.I * s / 2)), -3.14, 3.14),
    "1 - s": (lambda s: (sp.sqrt(sp.expand((1 - s) ** 2)), 1 - s), -100.0, 1.0),
    "1 - s**2": (lambda s: (sp.sqrt(sp.expand((1 - s**2) ** 2)), 1 - s**2), -1.0, 1.0),
    "s - 2": (lambda s: (sp.log(sp.expand((s - 2) ** 2)) / 2, sp.log(s - 2)), 2.0, 100.0),
}
"""Two sides, and the ends between which they are equal (a little within, where they are
irrational)."""

SLIVERS: tuple[
    tuple[Callable[[sp.Expr], tuple[sp.Expr, sp.Expr]], sp.Rational | None, sp.Rational | None], ...
] = (
    (lambda s: (sp.sqrt(sp.expand(s**2)), s), sp.S.Zero, None),
    (lambda s: (sp.Abs(s) * (1 + s**2), s * (1 + s**2)), sp.S.Zero, None),
    (lambda s: (sp.sqrt(sp.expand((1 - s) ** 2)), 1 - s), None, sp.S.One),
    (lambda s: (sp.sqrt(sp.expand((1 - s**2) ** 2)), 1 - s**2), -sp.S.One, sp.S.One),
    (lambda s: (sp.log(sp.expand((s - 2) ** 2)) / 2, sp.log(s - 2)), sp.Integer(2), None),
    (
        lambda s: (sp.Abs(sp.expand((s - 1) * (s - 2))), sp.expand((s - 1) * (s - 2))),
        sp.Integer(2),
        None,
    ),
    (lambda s: (sp.conjugate(sp.elliptic_k(s)), sp.elliptic_k(s)), None, sp.S.One),
    (lambda s: (sp.Abs(sp.elliptic_k(s)), sp.elliptic_k(s)), None, sp.S.One),
    (lambda s: (sp.sqrt(1 - s) * sp.sqrt(-s), sp.sqrt(sp.expand(s**2 - s))), None, sp.S.One),
    (lambda s: (sp.atan(s) + sp.atan(1 / s), sp.pi / 2), sp.S.Zero, None),
)
"""Identities between the two ends, and false right beyond either of them."""


def by_sign(setting: Setting) -> RandomStatement | None:
    """An identity of `BRANCHES` for formulas whose signs are known."""
    name = setting.draw.choice(list(BRANCHES))
    branch = BRANCHES[name]
    s, sign = _signed(setting)
    r, other = _signed(setting)
    left, right = branch.sides(s, r)
    return _labelled(name, setting, left, right, (sign, other) in branch.signs)


def by_interval(setting: Setting) -> RandomStatement | None:
    """An identity of `INTERVALS` within its ends, or beyond one of them."""
    draw = setting.draw
    name = draw.choice(list(INTERVALS))
    sides, low, high = INTERVALS[name]
    within = draw.random() < 0.5
    ends = sorted(draw.uniform(low, high) for _ in range(2))
    if not within:
        ends = [ends[0], high + draw.uniform(0.1, 1)] if draw.random() < 0.5 else [low - 1, ends[1]]
    least, largest = (sp.Rational(round(end * 1000), 1000) for end in ends)
    if least == largest:
        return None
    left, right = sides(setting.narrow(least, largest))
    return _labelled(name, setting, left, right, within)


def by_sliver(setting: Setting) -> RandomStatement | None:
    """An identity that fails on a part of the domain that no sample meets."""
    draw = setting.draw
    sides, low, high = draw.choice(SLIVERS)
    width = sp.Rational(1, 10 ** draw.choice((12, 30)))
    above = low is None or (high is not None and draw.random() < 0.5)
    ends = (low, high + width) if above else (low - width, high)
    symbol = setting.narrow(*ends)
    left, right = sides(symbol)
    beyond = ends[1] - width / 3 if above else ends[0] + width / 3
    return _labelled("sliver", setting, left, right, False, {symbol: beyond})


def _signed(setting: Setting) -> tuple[sp.Expr, int]:
    """A formula with its sign; 0 if it has both."""
    draw = setting.draw
    sign = draw.choice((-1, 0, 1))
    if sign == 0:
        free = setting.with_both_signs()
        return (draw.choice(free), 0) if free else (sp.Integer(1) * _mixed(setting), 0)
    symbols = setting.of_sign(sign)
    if symbols and draw.random() < 0.6:
        found = draw.choice(symbols)
        return (found, sign) if draw.random() < 0.7 else (found * positive(setting), sign)
    return sign * positive(setting), sign


def _mixed(setting: Setting) -> sp.Expr:
    """A formula that changes its sign within the ranges."""
    made = setting.ranges[setting.variables[0]]
    return made.symbol - made.number(setting.draw)


def _labelled(
    name: str,
    setting: Setting,
    left: sp.Expr,
    right: sp.Expr,
    holds: bool,
    beyond: Mapping[sp.Symbol, sp.Rational] | None = None,
) -> RandomStatement | None:
    """The identity as an equality or as an equation; None if a false one shows at no point."""
    draw = setting.draw
    if left == right or (left - right).has(sp.nan, sp.zoo, sp.oo):
        return None
    point = None if beyond is None else {**setting.point(), **beyond}
    factor = draw.choice(
        (sp.S.One, number(setting), 1 + phase(setting) ** 2, sp.exp(phase(setting)))
    )
    return _stated(f"branch: {name}", setting, left * factor, right * factor, holds, point)


def _stated(
    kind: str,
    setting: Setting,
    left: sp.Expr,
    right: sp.Expr,
    holds: bool,
    counterexample: Point | None = None,
) -> RandomStatement:
    """Return the identity as an equality or as an equation."""
    if setting.draw.random() < 0.5:
        made = setting.equality(kind, left, right)
    else:
        made = setting.equation(kind, setting.unknown - left, right)
    if holds:
        return made
    return replace(made, truth=Truth.FALSE, counterexample=counterexample)


ComplexSides = Callable[[sp.Expr, sp.Expr, sp.Expr], tuple[sp.Expr, sp.Expr]]


def _turned(s: sp.Expr) -> sp.Expr:
    return sp.exp(sp.I * s)


PAIRS: dict[str, tuple[ComplexSides, bool]] = {
    "re of a phase": (lambda s, p, f: (sp.re(f * _turned(s)), f * sp.cos(s)), True),
    "im of a phase": (lambda s, p, f: (sp.im(f * _turned(s)), f * sp.sin(s)), True),
    "im, wrong": (lambda s, p, f: (sp.im(f * _turned(s)), f * sp.cos(s)), False),
    "conjugate": (lambda s, p, f: (sp.conjugate(f * _turned(s)), f / _turned(s)), True),
    "conjugate, forgotten": (
        lambda s, p, f: (sp.conjugate(f * _turned(s)), f * _turned(s)),
        False,
    ),
    "square of a modulus": (lambda s, p, f: (sp.Abs(f + sp.I * s) ** 2, f**2 + s**2), True),
    "square of a modulus, wrong": (
        lambda s, p, f: (sp.Abs(f + sp.I * s) ** 2, sp.expand((f + sp.I * s) ** 2)),
        False,
    ),
    "modulus": (lambda s, p, f: (sp.Abs(p * _turned(s)), p), True),
    "modulus, wrong": (lambda s, p, f: (sp.Abs(p * (1 + _turned(s))), 2 * p), False),
    "product with the conjugate": (
        lambda s, p, f: ((f + sp.I * s) * sp.conjugate(f + sp.I * s), f**2 + s**2),
        True,
    ),
    "polar": (lambda s, p, f: (sp.sqrt(p) * sp.sqrt(-p), sp.I * p), True),
    "polar, wrong": (lambda s, p, f: (sp.sqrt(-p) * sp.sqrt(-p), p), False),
    "hyperbolic": (
        lambda s, p, f: (
            sp.cosh(sp.I * s + p),
            sp.cosh(p) * sp.cos(s) + sp.I * sp.sinh(p) * sp.sin(s),
        ),
        True,
    ),
    "Moebius": (
        lambda s, p, f: ((1 + sp.I * s) / (1 - sp.I * s), sp.exp(2 * sp.I * sp.atan(s))),
        True,
    ),
    "log of a phase": (lambda s, p, f: (sp.re(sp.log(p * _turned(s))), sp.log(p)), True),
}
"""Two formulas each of a real s, a positive p and a real f, and whether they are equal."""


def conjugates(setting: Setting) -> RandomStatement | None:
    """An identity of complex-valued formulas, true or false."""
    draw = setting.draw
    name = draw.choice(list(PAIRS))
    sides, holds = PAIRS[name]
    left, right = sides(phase(setting), positive(setting), formula(setting, 1))
    if left == right or (left - right).has(sp.nan, sp.zoo, sp.oo):
        return None
    return _stated(f"complex: {name}", setting, left, right, holds)


def plane_wave(setting: Setting) -> RandomStatement | None:
    """A linear equation with complex coefficients and its plane wave."""
    draw, unknown = setting.draw, setting.unknown
    v, w = draw.choice(setting.variables), setting.variables[-1]
    n, k = draw.choice((1, 2, 3)), constant(setting)
    solution = (
        constant(setting) * sp.exp(sp.I * k * v) * (1 if v == w else sp.exp(sp.I**n * k**n * w))
    )
    left = unknown.diff(v, n) - (sp.I * k) ** n * unknown
    if v != w:
        left = sp.diff(unknown, w) - sp.diff(unknown, v, n) * sp.I**n * k**n / (sp.I * k) ** n
    holds = draw.random() < 0.6
    made = setting.equation("plane wave", left, rewritten(solution, draw, 1))
    if holds:
        return made
    factor = (1 + sp.I) * constant(setting) / 10 ** draw.choice((0, 0, 40))
    return replace(made, truth=Truth.FALSE, left=left + factor * unknown)


def _square_root(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = p + q * root
    return sp.sqrt(sp.expand(value**2)), value if sp.N(value) > 0 else -value


def _cube_root(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = abs(p) + abs(q) * root
    return sp.expand(value**3) ** sp.Rational(1, 3), value


def _gaussian_root(p: sp.Rational, q: sp.Rational, _: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = abs(p) + q * sp.I
    return sp.sqrt(sp.expand(value**2)), value


def _rationalised(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    return 1 / (p + q * root), (p - q * root) / (p**2 - q**2 * root**2)


def _sum_of_roots(p: sp.Rational, q: sp.Rational, _: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    a, b = abs(p) + 1, abs(q) + 2
    return sp.sqrt(a) + sp.sqrt(b), sp.sqrt(a + b + 2 * sp.sqrt(a * b))


ROOTS = (_square_root, _cube_root, _gaussian_root, _rationalised, _sum_of_roots)


def nested_roots(setting: Setting) -> RandomStatement | None:
    """u_v = value f_v with value f for u, the two values in different words."""
    draw = setting.draw
    p, q = number(setting), number(setting)
    left, right = draw.choice(ROOTS)(p, q, sp.sqrt(draw.choice((2, 3, 5, 6))))
    if left.has(sp.zoo, sp.nan):
        return None
    change = draw.choice((0, 0, sp.Rational(1, 10**30), sp.Rational(1, 10**90), -2 * right))
    f, v = formula(setting, draw.choice((1, 2))), draw.choice(setting.variables)
    f = f if f.has(v) else f + constant(setting) * v
    slope = f.diff(v)
    equation = setting.unknown.diff(v) - left * slope
    made = setting.equation("nested roots", equation, (right + change) * f)
    return made if change == 0 else replace(made, truth=Truth.FALSE)
