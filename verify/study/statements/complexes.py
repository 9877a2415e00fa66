"""Complex-valued formulas: conjugates, real and imaginary parts, moduli."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from .equations import true_equality, true_equation
from .formulas import constant, formula, phase, positive
from .near import shown_at
from .record import Statement, Truth
from .rewriting import rewritten
from .setting import Setting


def _pairs(setting: Setting) -> dict[str, tuple[sp.Expr, sp.Expr, bool]]:
    """Two formulas each, and whether they are equal."""
    s, p, f = phase(setting), positive(setting), formula(setting, 1)
    e, z = sp.exp(sp.I * s), f + sp.I * s
    return {
        "re of a phase": (sp.re(f * e), f * sp.cos(s), True),
        "im of a phase": (sp.im(f * e), f * sp.sin(s), True),
        "im, wrong": (sp.im(f * e), f * sp.cos(s), False),
        "conjugate": (sp.conjugate(f * e), f / e, True),
        "conjugate, forgotten": (sp.conjugate(f * e), f * e, False),
        "square of a modulus": (sp.Abs(z) ** 2, f**2 + s**2, True),
        "square of a modulus, wrong": (sp.Abs(z) ** 2, sp.expand(z**2), False),
        "modulus": (sp.Abs(p * e), p, True),
        "modulus, wrong": (sp.Abs(p * (1 + e)), 2 * p, False),
        "product with the conjugate": (z * sp.conjugate(z), f**2 + s**2, True),
        "polar": (sp.sqrt(p) * sp.sqrt(-p), sp.I * p, True),
        "polar, wrong": (sp.sqrt(-p) * sp.sqrt(-p), p, False),
        "hyperbolic": (
            sp.cosh(sp.I * s + p),
            sp.cosh(p) * sp.cos(s) + sp.I * sp.sinh(p) * sp.sin(s),
            True,
        ),
        "Moebius": ((1 + sp.I * s) / (1 - sp.I * s), sp.exp(2 * sp.I * sp.atan(s)), True),
        "log of a phase": (sp.re(sp.log(p * e)), sp.log(p), True),
    }


def conjugates(setting: Setting) -> Statement | None:
    """An identity of complex-valued formulas, true or false."""
    draw = setting.draw
    pairs = _pairs(setting)
    name = draw.choice(list(pairs))
    left, right, holds = pairs[name]
    if left == right or (left - right).has(sp.nan, sp.zoo, sp.oo):
        return None
    point = None if holds else shown_at(left - right, setting, 40)
    if not holds and point is None:
        return None
    kind = f"complex: {name}"
    if draw.random() < 0.5:
        made = true_equality(kind, setting, left, right)
    else:
        made = true_equation(kind, setting, setting.unknown - left, right)
    return made if holds else replace(made, truth=Truth.FALSE, counterexample=point)


def plane_wave(setting: Setting) -> Statement:
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
    made = true_equation("plane wave", setting, left, rewritten(solution, draw, 1))
    if holds:
        return made
    term = (1 + sp.I) * constant(setting) * unknown / 10 ** draw.choice((0, 0, 40))
    point = setting.point()
    return replace(made, truth=Truth.FALSE, left=left + term, counterexample=point)
