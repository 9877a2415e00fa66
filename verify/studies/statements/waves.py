"""The catalogue's closed forms, shifted, scaled, mirrored; and other known solutions."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from solutions import closed_form
from solutions.functions import jacobi
from solutions.record import ClosedForm
from solutions.symbols import tau, xi

from .formulas import number
from .labels import with_counterexample
from .record import Range, Statement, Truth
from .setting import Setting

SMALL_FORMS = ("kink", "soliton_sech", "wave_cn", "wave_dn", "wave_sn", "rational_1")


def catalogue_form(setting: Setting) -> Statement | None:
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
    variables = (Range(xi), Range(tau))
    made = Statement(
        "catalogue",
        Truth.TRUE if holds else Truth.FALSE,
        form.equation.residual(unknown),
        solution,
        (xi, tau),
        (*variables, *ranges),
        unknown=unknown,
    )
    return made if holds else with_counterexample(made, draw)


def _ranges(form: ClosedForm) -> list[Range] | None:
    """The ranges of a form's parameters; None if one depends on another."""
    found = []
    for parameter in form.parameters:
        ends = [
            None if bound is None or bound.value in (sp.oo, -sp.oo) else bound.value
            for bound in (parameter.lower, parameter.upper)
        ]
        if not all(end is None or end.is_Rational for end in ends):
            return None
        found.append(Range(parameter.symbol, *ends))
    return found


def known_solution(setting: Setting) -> Statement | None:
    """A textbook solution of a textbook equation, or the same with one number changed."""
    draw = setting.draw
    x, t = sp.symbols("x t", real=True)
    a, b = sp.symbols("a b", positive=True)
    time = draw.choice((t, sp.Symbol("t", positive=True)))
    u = sp.Function("u")(x, time)
    left, solution = draw.choice(_textbook(x, time, a, b, u))
    rate = draw.choice((sp.S.One, sp.S.One, sp.Rational(101, 100), 1 + sp.Rational(1, 10**60)))
    left = left + (rate - 1) * u
    variables = (Range(x), Range(time, sp.S.Zero if time.is_positive else None))
    ranges = (*variables, Range(a, sp.S.Zero), Range(b, sp.S.Zero))
    used = solution.free_symbols | {x, time}
    made = Statement(
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
    change = (rate - 1) * solution
    return with_counterexample(replace(made, truth=Truth.FALSE, change=change), draw)


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
