"""Roots, logarithms, moduli and inverse functions: identities that hold for some signs only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import sympy as sp

from verify.studies.statements.equations import true_equality, true_equation
from verify.studies.statements.formulas import number, phase, positive
from verify.studies.statements.near import shown_at
from verify.studies.statements.record import Statement, Truth
from verify.studies.statements.setting import Setting, ranged

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


def by_sign(setting: Setting) -> Statement | None:
    """An identity of `BRANCHES` for formulas whose signs are known."""
    name = setting.draw.choice(list(BRANCHES))
    branch = BRANCHES[name]
    s, sign = _signed(setting)
    r, other = _signed(setting)
    left, right = branch.sides(s, r)
    return _labelled(name, setting, left, right, (sign, other) in branch.signs)


def by_interval(setting: Setting) -> Statement | None:
    """An identity of `INTERVALS` within its ends, or beyond one of them."""
    draw = setting.draw
    name = draw.choice(list(INTERVALS))
    sides, low, high = INTERVALS[name]
    within = draw.random() < 0.5
    ends = sorted(draw.uniform(low, high) for _ in range(2))
    if not within:
        ends = [ends[0], high + draw.uniform(0.1, 1)] if draw.random() < 0.5 else [low - 1, ends[1]]
    place = setting.variables[0]
    made = ranged(place.name, *(sp.Rational(round(end * 1000), 1000) for end in ends))
    if made.low == made.high:
        return None
    del setting.ranges[place]
    setting.ranges[made.symbol] = made
    setting.variables = (made.symbol, *setting.variables[1:])
    left, right = sides(made.symbol)
    return _labelled(name, setting, left, right, within)


def by_sliver(setting: Setting) -> Statement | None:
    """An identity that fails on a part of the domain that no sample meets."""
    draw = setting.draw
    sides, low, high = draw.choice(SLIVERS)
    width = sp.Rational(1, 10 ** draw.choice((12, 30)))
    place = setting.variables[0]
    above = low is None or (high is not None and draw.random() < 0.5)
    ends = (low, high + width) if above else (low - width, high)
    made = ranged(place.name, *ends)
    del setting.ranges[place]
    setting.ranges[made.symbol] = made
    setting.variables = (made.symbol, *setting.variables[1:])
    left, right = sides(made.symbol)
    beyond = ends[1] - width / 3 if above else ends[0] + width / 3
    return _labelled("sliver", setting, left, right, False, {made.symbol: beyond})


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
) -> Statement | None:
    """The identity as an equality or as an equation; None if a false one shows at no point."""
    draw = setting.draw
    if left == right or (left - right).has(sp.nan, sp.zoo, sp.oo):
        return None
    if beyond is None:
        point = None if holds else shown_at(left - right, setting, 60)
    else:
        point = {**setting.point(), **beyond}
    if not holds and point is None:
        return None
    factor = draw.choice(
        (sp.S.One, number(setting), 1 + phase(setting) ** 2, sp.exp(phase(setting)))
    )
    left, right = left * factor, right * factor
    if draw.random() < 0.5:
        made = true_equality(f"branch: {name}", setting, left, right)
    else:
        made = true_equation(f"branch: {name}", setting, setting.unknown - left, right)
    if holds:
        return made
    return replace(made, truth=Truth.FALSE, counterexample=point)
