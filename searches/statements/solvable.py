"""Statements that are true by construction: equations built from their solutions, and known ones.

The closed forms of the catalogue are shifted, scaled and mirrored; other solutions are those of
textbooks.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from longwave.solutions import closed_form
from longwave.solutions.functions import jacobi
from longwave.solutions.record import ClosedForm
from longwave.solutions.symbols import tau, xi
from searches.statements.formulas import (
    constant,
    formula,
    number,
    phase,
    piece,
    positive,
    rewritten,
)
from searches.statements.random_statement import RandomStatement, Setting, SymbolRange
from searches.texts.text_statement import Truth

HIGHEST = 3
"""The highest order of a derivative."""

LONGEST = 60
"""Operations of a source term that is still rewritten."""


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


def with_source(setting: Setting) -> RandomStatement:
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
    return setting.equation("source", left - source, rewritten(solution, draw, 1))


def with_annihilator(setting: Setting) -> RandomStatement:
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
    return setting.equation("annihilator", left, solution)


def travelling_wave(setting: Setting) -> RandomStatement:
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
    return setting.equation("travelling", left, rewritten(solution, draw, 1))


def logarithmic(setting: Setting) -> RandomStatement:
    """u' = (f'/f) u, with the quotient worked out."""
    draw, unknown = setting.draw, setting.unknown
    solution = sp.Mul(*(positive(setting) ** constant_power(setting) for _ in range(2)))
    solution *= sp.exp(phase(setting))
    v = draw.choice(setting.variables)
    rate = sp.expand_log(sp.log(solution), force=True).diff(v)
    return setting.equation("logarithmic", unknown.diff(v) - rate * unknown, solution)


def constant_power(setting: Setting) -> sp.Rational:
    """An exponent with a small denominator."""
    return sp.Rational(
        setting.draw.choice((-3, -2, -1, 1, 2, 3, 4)), setting.draw.choice((1, 2, 3))
    )


def identity(setting: Setting) -> RandomStatement:
    """A formula and the same in other words."""
    draw = setting.draw
    left = formula(setting, draw.choice((1, 2, 3)))
    if draw.random() < 0.3:
        left = sp.diff(left, draw.choice(setting.variables))
    right = rewritten(left, draw, draw.randint(2, 5))
    return setting.equality("identity", left, right)


SMALL_FORMS = ("kink", "soliton_sech", "wave_cn", "wave_dn", "wave_sn", "rational_1")


def catalogue_form(setting: Setting) -> RandomStatement | None:
    """A closed form of mKdV under one of the equation's symmetries, or under none of them."""
    draw = setting.draw
    form = closed_form(draw.choice(SMALL_FORMS))
    ranges = _ranges(form)
    if ranges is None:
        return None
    scale, shift = draw.choice((sp.S.One, sp.Rational(2, 3), sp.Integer(-2))), number(setting)
    power = draw.choice((3, 3, 3, 2))
    moved = {xi: scale * (xi + shift), tau: scale**power * (tau - shift)}
    solution = scale * form.expression.xreplace(moved)
    unknown = sp.Function("U")(xi, tau)
    holds = power == 3 or scale == 1
    variables = (SymbolRange(xi), SymbolRange(tau))
    return RandomStatement(
        "catalogue",
        Truth.TRUE if holds else Truth.FALSE,
        form.equation.residual(unknown),
        solution,
        (xi, tau),
        (*variables, *ranges),
        unknown=unknown,
    )


def _ranges(form: ClosedForm) -> list[SymbolRange] | None:
    """The ranges of a form's parameters; None if one depends on another."""
    found = []
    for parameter in form.parameters:
        ends = [
            None if bound is None or bound.value in (sp.oo, -sp.oo) else bound.value
            for bound in (parameter.lower, parameter.upper)
        ]
        if not all(end is None or end.is_Rational for end in ends):
            return None
        found.append(SymbolRange(parameter.symbol, *ends))
    return found


def known_solution(setting: Setting) -> RandomStatement | None:
    """A textbook solution of a textbook equation, or the same with one number changed."""
    draw = setting.draw
    x, t = sp.symbols("x t", real=True)
    a, b = sp.symbols("a b", positive=True)
    time = draw.choice((t, sp.Symbol("t", positive=True)))
    u = sp.Function("u")(x, time)
    left, solution = draw.choice(_textbook(x, time, a, b, u))
    rate = draw.choice((sp.S.One, sp.S.One, sp.Rational(101, 100), 1 + sp.Rational(1, 10**60)))
    left = left + (rate - 1) * u
    variables = (SymbolRange(x), SymbolRange(time, sp.S.Zero if time.is_positive else None))
    ranges = (*variables, SymbolRange(a, sp.S.Zero), SymbolRange(b, sp.S.Zero))
    used = solution.free_symbols | {x, time}
    made = RandomStatement(
        "textbook",
        Truth.TRUE,
        left,
        solution,
        (x, time),
        tuple(r for r in ranges if r.symbol in used),
        unknown=u,
    )
    if rate == 1:
        return made
    return replace(made, truth=Truth.FALSE)


def _textbook(
    x: sp.Symbol, t: sp.Symbol, a: sp.Symbol, b: sp.Symbol, u: sp.Expr
) -> list[tuple[sp.Expr, sp.Expr]]:
    kdv = u.diff(t) + 6 * u * u.diff(x) + u.diff(x, 3)
    burgers = u.diff(t) + u * u.diff(x) - u.diff(x, 2)
    heat = u.diff(t) - u.diff(x, 2)
    waves = u.diff(t, 2) - a**2 * u.diff(x, 2)
    m = sp.Rational(1, 2)
    return [
        (heat, sp.exp(-(x**2) / (4 * t)) / sp.sqrt(t)),
        (heat, x * sp.exp(-(x**2) / (4 * t)) / t ** sp.Rational(3, 2)),
        (heat, sp.exp(-(a**2) * t) * sp.sin(a * x + b)),
        (kdv, 2 * a**2 * sp.sech(a * (x - 4 * a**2 * t) + b) ** 2),
        (kdv, 2 * m * jacobi.jacobi_cn(x - (8 * m - 4) * t, m) ** 2),
        (kdv, x / (6 * t)),
        (kdv, -2 / x**2),
        (burgers, 2 * a * (1 - sp.tanh(a * (x - 2 * a * t)))),
        (burgers, x / (t + a)),
        (burgers, -2 * a * sp.sinh(a * x) / (sp.cosh(a * x) + b * sp.exp(-(a**2) * t))),
        (waves, sp.tanh(x - a * t) + sp.atan((x + a * t) ** 2)),
        (u.diff(x) ** 2 + u.diff(t) ** 2 - 1, sp.sqrt(x**2 + t**2)),
        (u.diff(x, 2) + u.diff(t, 2), sp.log(x**2 + t**2)),
        (u.diff(x, 2) + u.diff(t, 2), sp.exp(x) * sp.sin(t) + sp.atan(t / x)),
        (x * u.diff(x) + t * u.diff(t) - u / 2, sp.sqrt(x**2 + t**2) ** sp.Rational(1, 2)),
    ]
