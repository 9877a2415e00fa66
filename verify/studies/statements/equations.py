"""Statements that are true by construction: an equation is built from its solution."""

from __future__ import annotations

import sympy as sp

from verify.studies.statements.formulas import constant, formula, phase, piece, positive
from verify.studies.statements.paraphrase import rewritten
from verify.studies.statements.record import Statement, Truth
from verify.studies.statements.setting import Setting

HIGHEST = 3
"""The highest order of a derivative."""

LONGEST = 60
"""Operations of a source term that is still rewritten."""


def true_equation(kind: str, setting: Setting, left: sp.Expr, solution: sp.Expr) -> Statement:
    """The statement that ``solution`` makes ``left`` vanish."""
    ranges = tuple(setting.ranges.values())
    return Statement(
        kind, Truth.TRUE, left, solution, setting.variables, ranges, unknown=setting.unknown
    )


def true_equality(kind: str, setting: Setting, left: sp.Expr, right: sp.Expr) -> Statement:
    """The statement that two formulas are one function."""
    return Statement(
        kind, Truth.TRUE, left, right, setting.variables, tuple(setting.ranges.values())
    )


def random_orders(setting: Setting) -> list[sp.Symbol]:
    """The variables of a derivative, possibly none."""
    draw = setting.draw
    count = draw.choices(range(HIGHEST + 1), (3, 6, 2, 0.3))[0]
    return [draw.choice(setting.variables) for _ in range(count)]


def derivative(expression: sp.Expr, orders: list[sp.Symbol]) -> sp.Expr:
    """``expression`` differentiated in each of ``orders``."""
    return sp.diff(expression, *orders, simplify=False) if orders else expression


def coefficient(setting: Setting) -> sp.Expr:
    """A constant, a variable, or a function."""
    kind = setting.draw.random()
    if kind < 0.6:
        return constant(setting)
    if kind < 0.8:
        return constant(setting) * setting.draw.choice(setting.variables)
    return piece(setting, 1)


def with_source(setting: Setting) -> Statement:
    """A sum of products of jets, less the same sum at a formula, in other words."""
    draw, unknown = setting.draw, setting.unknown
    solution = formula(setting, draw.choice((1, 1, 1, 2, 2, 2, 3)))
    left, source = sp.S.Zero, sp.S.Zero
    for _ in range(draw.choice((1, 1, 2, 2, 3))):
        factor = coefficient(setting)
        powers = [random_orders(setting) for _ in range(draw.choice((1, 1, 1, 1, 2)))]
        left += factor * sp.Mul(*(derivative(unknown, orders) for orders in powers))
        source += factor * sp.Mul(*(derivative(solution, orders) for orders in powers))
    if not left.has(unknown):
        left, source = unknown, solution
    if source.count_ops() < LONGEST:
        source = rewritten(source, draw, draw.randint(0, 3))
    return true_equation("source", setting, left - source, rewritten(solution, draw, 1))


def with_annihilator(setting: Setting) -> Statement:
    """A linear equation whose coefficients are the solution's own derivatives."""
    draw, unknown = setting.draw, setting.unknown
    solution = formula(setting, draw.choice((1, 2, 2)))
    first, second = random_orders(setting), random_orders(setting)
    if first == second:
        second = [*second, draw.choice(setting.variables)]
    values = [derivative(solution, orders) for orders in (first, second)]
    if all(value.count_ops() < LONGEST for value in values):
        values = [rewritten(value, draw, 1) for value in values]
    left = values[1] * derivative(unknown, first) - values[0] * derivative(unknown, second)
    if not left.has(unknown):
        left = unknown.diff(setting.variables[0]) - solution.diff(setting.variables[0])
    return true_equation("annihilator", setting, left, solution)


def travelling_wave(setting: Setting) -> Statement:
    """Any function of one phase solves a transport equation."""
    draw, unknown = setting.draw, setting.unknown
    xi = phase(setting)
    s = sp.Dummy("s", real=True)
    own = {symbol: setting.ranges[symbol] for symbol in setting.parameters}
    inner = Setting(draw, (s,), setting.parameters, own, setting.modulus)
    shape = formula(inner, draw.choice((1, 2)))
    setting.modulus = inner.modulus
    setting.ranges.update(inner.ranges)
    v, w = (draw.choice(setting.variables) for _ in range(2))
    rates = [sp.diff(xi, variable) for variable in (v, w)]
    slope = sp.diff(shape, s)
    if v == w and not slope.has(sp.Derivative, sp.Subs):
        left = rates[0] * unknown.diff(v) - rates[0] ** 2 * slope.xreplace({s: xi})
    else:
        left = rates[1] * unknown.diff(v) - rates[0] * unknown.diff(w)
    solution = shape.xreplace({s: xi})
    if not left.has(unknown):
        left = unknown - rewritten(solution, draw, 2)
    return true_equation("travelling", setting, left, rewritten(solution, draw, 1))


def logarithmic(setting: Setting) -> Statement:
    """u' = (f'/f) u, with the quotient worked out."""
    draw, unknown = setting.draw, setting.unknown
    solution = sp.Mul(*(positive(setting) ** constant_power(setting) for _ in range(2)))
    solution *= sp.exp(phase(setting))
    v = draw.choice(setting.variables)
    rate = sp.expand_log(sp.log(solution), force=True).diff(v)
    return true_equation("logarithmic", setting, unknown.diff(v) - rate * unknown, solution)


def constant_power(setting: Setting) -> sp.Rational:
    """An exponent with a small denominator."""
    return sp.Rational(
        setting.draw.choice((-3, -2, -1, 1, 2, 3, 4)), setting.draw.choice((1, 2, 3))
    )


def identity(setting: Setting) -> Statement:
    """A formula and the same in other words."""
    draw = setting.draw
    left = formula(setting, draw.choice((1, 2, 3)))
    if draw.random() < 0.3:
        left = sp.diff(left, draw.choice(setting.variables))
    right = rewritten(left, draw, draw.randint(2, 5))
    return true_equality("identity", setting, left, right)
