"""Equations in which the unknown stands inside a function, a derivative or a modulus.

Where a prover cannot take such an equation it must say so, and not read it as another one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import sympy as sp

from verify.studies.statements.equations import true_equation
from verify.studies.statements.formulas import formula, number, phase
from verify.studies.statements.labels import with_counterexample
from verify.studies.statements.record import Statement, Truth
from verify.studies.statements.setting import Setting

Wrap = Callable[[sp.Expr, sp.Symbol], sp.Expr]

WRAPS: dict[str, Wrap] = {
    "derivative of a square": lambda u, v: sp.Derivative(u**2, v),
    "derivative of a product": lambda u, v: sp.Derivative(v * u, v),
    "derivative twice": lambda u, v: sp.Derivative(u * sp.Derivative(u, v), v),
    "sine": lambda u, v: sp.sin(u),
    "exponential": lambda u, v: sp.exp(u),
    "quotient": lambda u, v: v / u,
    "root": lambda u, v: sp.sqrt(u),
    "modulus": lambda u, v: sp.Abs(u),
    "square of a modulus": lambda u, v: sp.Abs(u) ** 2 * u,
    "conjugate": lambda u, v: u * sp.conjugate(u),
    "real part": lambda u, v: sp.re(u),
    "gamma": lambda u, v: sp.gamma(u),
    "floor": lambda u, v: sp.floor(u) + u,
    "value at 0": lambda u, v: 2 * u + sp.Subs(u, v, 0),
}
READABLE = tuple(WRAPS)[:11]
"""Those that SymPy can differentiate and write out at a formula."""


def wrapped(setting: Setting) -> Statement | None:
    """w(u) = w(f) for u = f, or w(u) = w(f) read as u = w(f): true and false."""
    draw, unknown = setting.draw, setting.unknown
    name, v = draw.choice(READABLE), draw.choice(setting.variables)
    solution = formula(setting, 1)
    if draw.random() < 0.3:
        solution *= sp.exp(sp.I * phase(setting))
    left, right = WRAPS[name](unknown, v), WRAPS[name](solution, v).doit()
    if right.has(sp.nan, sp.zoo, sp.oo, sp.Derivative):
        return None
    made = true_equation(f"wrapped: {name}", setting, left - right, solution)
    if draw.random() < 0.5:
        return made
    changed = draw.choice((left - solution, left - number(setting) * right))
    return with_counterexample(replace(made, truth=Truth.FALSE, left=changed), draw)


def opaque(setting: Setting) -> Statement | None:
    """A false equation in something else than jets, with what would solve it if it were u."""
    draw, unknown = setting.draw, setting.unknown
    name = draw.choice(tuple(WRAPS)[len(READABLE) :])
    v = draw.choice(setting.variables)
    solution = draw.choice((v, formula(setting, 1)))
    factor = draw.choice((sp.S.One, sp.Derivative(unknown, v), unknown))
    left = WRAPS[name](unknown, v) * factor - factor.subs(unknown, solution).doit() * solution
    made = true_equation(f"opaque: {name}", setting, left, solution)
    return with_counterexample(replace(made, truth=Truth.FALSE), draw)
