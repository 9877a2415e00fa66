"""Formulas with a denominator that is 0 everywhere, or that only looks so."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from solutions import special

from .equations import identity, true_equality, true_equation, with_source
from .formulas import formula, phase, polynomial, positive
from .record import Statement, Truth
from .setting import Setting


def _zero(setting: Setting) -> sp.Expr:
    """0 in other words."""
    draw = setting.draw
    s, p = phase(setting), positive(setting)
    m = sp.Rational(1, 3)
    sn, cn = special.jacobi_sn(setting.variables[0], m), special.jacobi_cn(setting.variables[0], m)
    forms = [
        sp.sin(s) ** 2 + sp.cos(s) ** 2 - 1,
        sp.cosh(s) ** 2 - sp.sinh(s) ** 2 - 1,
        sp.sqrt(sp.expand(p**2)) - p,
        sp.expand((s + 1) ** 2) - (s + 1) ** 2,
        sp.tanh(s) - sp.sinh(s) / sp.cosh(s),
        sp.exp(s) - sp.cosh(s) - sp.sinh(s),
        sn**2 + cn**2 - 1,
        sp.sqrt(p) ** 2 - p + sp.tan(s) - sp.sin(s) / sp.cos(s),
        sp.sqrt(3 + 2 * sp.sqrt(2)) - 1 - sp.sqrt(2),
        sp.Abs(p) - p,
    ]
    found = [form for form in forms if form != 0]
    return draw.choice(found)


def nowhere_defined(setting: Setting) -> Statement | None:
    """A formula that is divided by 0 everywhere."""
    draw = setting.draw
    zero = _zero(setting)
    over = zero ** draw.choice((-1, -1, -2)) * draw.choice((sp.S.One, polynomial(setting), zero**2))
    made = draw.choice((with_source, identity))(setting)
    if made.unknown is not None:
        made = replace(made, right=made.right + over)
    else:
        made = replace(made, left=made.left + over, right=made.right + over)
    whole = made.right if made.unknown is not None else made.left
    if not whole.has(1 / zero):
        return None
    return replace(
        made, kind="nowhere defined", truth=Truth.VOID, ranges=tuple(setting.ranges.values())
    )


def nearly_nowhere(setting: Setting) -> Statement:
    """Division by a number that is nearly 0 but is none."""
    draw = setting.draw
    tiny = sp.Rational(1, 10 ** draw.choice((10, 60)))
    below = _zero(setting) + tiny
    f, v = formula(setting, 1), draw.choice(setting.variables)
    left = setting.unknown.diff(v) - f.diff(v) / tiny
    made = true_equation("nearly nowhere", setting, left, f / below)
    if draw.random() < 0.5:
        made = true_equality("nearly nowhere", setting, f / below, f / tiny)
    return made
