"""Formulas with a denominator that is 0 everywhere, or that only looks so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import sympy as sp

from solutions.functions import jacobi

from .equations import identity, true_equality, true_equation, with_source
from .formulas import formula, phase, polynomial, positive
from .record import Statement, Truth
from .setting import Setting

Zero = Callable[[sp.Expr, sp.Expr, sp.Expr], sp.Expr]
sn, cn = jacobi.jacobi_sn, jacobi.jacobi_cn
m = sp.Rational(1, 3)

ZEROS: tuple[Zero, ...] = (
    lambda s, p, v: sp.sin(s) ** 2 + sp.cos(s) ** 2 - 1,
    lambda s, p, v: sp.cosh(s) ** 2 - sp.sinh(s) ** 2 - 1,
    lambda s, p, v: sp.sqrt(sp.expand(p**2)) - p,
    lambda s, p, v: sp.expand((s + 1) ** 2) - (s + 1) ** 2,
    lambda s, p, v: sp.tanh(s) - sp.sinh(s) / sp.cosh(s),
    lambda s, p, v: sp.exp(s) - sp.cosh(s) - sp.sinh(s),
    lambda s, p, v: sn(v, m) ** 2 + cn(v, m) ** 2 - 1,
    lambda s, p, v: sp.sqrt(p) ** 2 - p + sp.tan(s) - sp.sin(s) / sp.cos(s),
    lambda s, p, v: sp.sqrt(3 + 2 * sp.sqrt(2)) - 1 - sp.sqrt(2),
    lambda s, p, v: sp.Abs(sp.expand(p * (1 + p))) - p - p**2,
)
"""0 in other words, of a real s, a positive p and a variable v."""


def _zero(setting: Setting) -> sp.Expr:
    made = setting.draw.choice(ZEROS)
    found = made(phase(setting), positive(setting), setting.variables[0])
    return found if found != 0 else _zero(setting)


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
