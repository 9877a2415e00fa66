"""Statements that are nearly true: a true one with a term that is hard to see."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from verify.studies.statements.equations import (
    identity,
    logarithmic,
    travelling_wave,
    with_annihilator,
    with_source,
)
from verify.studies.statements.formulas import constant, phase
from verify.studies.statements.record import Point, Statement, Truth
from verify.studies.statements.setting import Setting
from verify.studies.statements.values import ValueMissing, values_at

TINY = (20, 60, 200)
TRUE = (with_source, with_source, with_annihilator, travelling_wave, logarithmic, identity)
TRIES = 40
DIGITS = 40
PRIME = 1009
SMALLEST = 10**-30


def perturbed(kind: str, setting: Setting, statement: Statement, term: sp.Expr) -> Statement | None:
    """``statement`` with ``term``, free of the unknown, added; None if no point shows it."""
    point = shown_at(term, setting, DIGITS)
    if point is None:
        return None
    return replace(
        statement,
        kind=kind,
        truth=Truth.FALSE,
        left=statement.left + term,
        change=term,
        ranges=tuple(setting.ranges.values()),
        counterexample=point,
    )


def shown_at(term: sp.Expr, setting: Setting, digits: int) -> Point | None:
    """An admissible point at which ``term`` is clearly not 0."""
    values = values_at(digits)
    for _ in range(TRIES):
        point = setting.point()
        try:
            size = abs(values.value(term, point))
        except ValueMissing:
            continue
        if size > values.context.mpf(10) ** (-digits / 3):
            return point
    return None


def tiny_change(setting: Setting) -> Statement | None:
    """One coefficient of the equation, or one side, times 1 + 10**-20, -60 or -200."""
    draw = setting.draw
    statement = draw.choice(TRUE)(setting)
    digits = draw.choice(TINY)
    terms = sp.Add.make_args(statement.left)
    term = draw.choice(terms)
    value = term
    if statement.unknown is not None:
        value = term.subs(statement.unknown, statement.right).doit()
    change = sp.Rational(1, 10**digits)
    point = shown_at(value, setting, DIGITS)
    if point is None:
        return None
    return replace(
        statement,
        kind="tiny change",
        truth=Truth.FALSE,
        left=sp.Add(*terms, change * term),
        counterexample=point,
        change=change * value,
        ranges=tuple(setting.ranges.values()),
    )


def hidden_term(setting: Setting) -> Statement | None:
    """A term that vanishes where one may look."""
    draw = setting.draw
    statement = draw.choice(TRUE)(setting)
    kind = draw.choice(list(HIDDEN))
    return perturbed(kind, setting, statement, HIDDEN[kind](setting))


def _at_rationals(setting: Setting) -> sp.Expr:
    """Vanishes at the multiples of 1/2, 1/3 and 1/5 up to 4."""
    v = _symbol(setting)
    q = setting.draw.choice((2, 3, 5))
    return sp.Mul(*(q * v - p for p in range(-2 * q, 2 * q + 1)))


def _at_lattice(setting: Setting) -> sp.Expr:
    """Vanishes at every rational number whose denominator divides a large one."""
    v = _symbol(setting)
    return sp.sin(sp.pi * setting.draw.choice((1, 60, PRIME, 64 * PRIME, 1000)) * v)


def _at_a_value(setting: Setting) -> sp.Expr:
    """Vanishes at one value of a symbol."""
    return _symbol(setting) - sp.Rational(setting.draw.randint(-9, 9), setting.draw.randint(1, 6))


def _on_a_curve(setting: Setting) -> sp.Expr:
    symbols = list(setting.ranges)
    if len(symbols) < 2:
        return symbols[0] ** 2 - 1
    a, b = setting.draw.sample(symbols, 2)
    return setting.draw.choice((a - b, a + b, a * b - 1, a**2 + b**2 - 1, a**2 - b**2))


def _of_one_sign(setting: Setting) -> sp.Expr:
    """Vanishes where a formula is positive."""
    s = setting.draw.choice((_symbol(setting), phase(setting)))
    forms = (sp.Abs(s) - s, sp.sqrt(sp.expand(s**2)) - s, 1 - sp.sign(s), s * sp.Abs(s) - s**2)
    return setting.draw.choice(forms)


def _small(setting: Setting) -> sp.Expr:
    """Small, though never 0."""
    v = setting.draw.choice(setting.variables)
    n = setting.draw.choice((5, 20))
    forms = (sp.exp(-n * (1 + v**2)), sp.sech(n * v), 1 - sp.tanh(n * v), sp.exp(-n * sp.cosh(v)))
    return setting.draw.choice(forms)


def _high_power(setting: Setting) -> sp.Expr:
    """Nearly 0 on most of an interval."""
    v = _symbol(setting)
    return constant(setting) * (v / 10) ** setting.draw.choice((8, 12, 20))


def _symbol(setting: Setting) -> sp.Symbol:
    return setting.draw.choice(list(setting.ranges))


HIDDEN = {
    "at rationals": _at_rationals,
    "at a lattice": _at_lattice,
    "at a value": _at_a_value,
    "on a curve": _on_a_curve,
    "of one sign": _of_one_sign,
    "small": _small,
    "high power": _high_power,
}
