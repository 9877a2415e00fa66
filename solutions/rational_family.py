"""The rational solutions of every order.

``U_j = (-1)**j [1 - 2 (arg f_j)_x]`` with ``f_j = A + i B`` from ``solutions.tau_polynomials``
and ``x = xi - 6 tau``.
"""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

import sympy as sp
from flint import fmpq_mpoly

from solutions.equation import FOCUSING_MKDV
from solutions.parameter import Parameter
from solutions.record import ClosedForm, FarFields, Reference
from solutions.symbols import shift_symbol, tau, xi
from solutions.tau_polynomials import SPACE_TIME, RationalTau, rational_tau

__all__ = ["CO_MOVING", "horner_form", "rational", "rational_evaluator", "rational_tau"]

CO_MOVING: sp.Expr = xi - 6 * tau


def horner_form(order: int, free: tuple[int, ...] = ()) -> sp.Expr:
    """``(-1)**j [1 - 2 (A B_x - A_x B)/(A**2 + B**2)]``, each polynomial in Horner form."""
    family = rational_tau(order, free)
    parts = [
        sp.horner(_to_sympy(part, *family.symbols), *family.symbols) for part in _parts(family)
    ]
    wave = _wave(order, *parts)
    return wave.subs(dict(zip(SPACE_TIME, (CO_MOVING, tau), strict=True)), simultaneous=True)


def rational(order: int, free: Iterable[int] = ()) -> ClosedForm:
    """The rational solution of any order; ``free`` lists the shifts tau_5, ... left as parameters.

    Peak ``2 order + 1`` at the origin on the background ``(-1)**order`` (with all shifts zero).
    Source: the paper's Ref. ankiewicz2018rogue. Raises ValueError as ``rational_tau`` does.

    >>> rational(3, free=[5]).parameters[0].name
    'tau_5'
    """
    shifts = tuple(sorted(free))
    family = rational_tau(order, shifts)
    symbols = (CO_MOVING, tau, *family.symbols[2:])
    level = sp.Integer((-1) ** order)
    return ClosedForm(
        name=f"rational_{order}",
        title=f"rational solution of order {order}",
        expression=_wave(order, *(_to_sympy(part, *symbols) for part in _parts(family))),
        equation=FOCUSING_MKDV,
        parameters=tuple(Parameter(shift_symbol(i), default=sp.S.Zero) for i in shifts),
        background=level,
        far_fields=FarFields(level, level),
        reference=Reference("ankiewicz2018rogue", "standard mKdV"),
        stabilise=lambda: horner_form(order, shifts),
        evaluator=rational_evaluator(order, shifts),
    )


def rational_evaluator(
    order: int, free: tuple[int, ...] = ()
) -> Callable[[Mapping[sp.Symbol, sp.Expr]], Any]:
    """What makes a solution's evaluator from exact values of its shifts.

    It is imported at first use, so that reading the formulas needs no compiler.
    """

    def evaluator(shifts: Mapping[sp.Symbol, sp.Expr]) -> Any:
        module = import_module("solutions.rational_evaluator")
        return module.RationalEvaluator(rational_tau(order, free), shifts)

    return evaluator


def _parts(family: RationalTau) -> list[fmpq_mpoly]:
    """A, B, A_x and B_x."""
    return [family.A, family.B, family.A.derivative("x"), family.B.derivative("x")]


def _wave(order: int, A: sp.Expr, B: sp.Expr, A_x: sp.Expr, B_x: sp.Expr) -> sp.Expr:
    return (-1) ** order * (1 - 2 * (A * B_x - A_x * B) / (A**2 + B**2))


def _to_sympy(polynomial: fmpq_mpoly, *generators: sp.Expr) -> sp.Expr:
    """The expanded polynomial in these generators."""
    powers = [[sp.S.One] for _ in generators]
    for row, generator, degree in zip(powers, generators, polynomial.degrees(), strict=True):
        row.extend(generator**n for n in range(1, degree + 1))
    terms = (
        sp.Mul(
            sp.Rational(int(c.p), int(c.q)),
            *(row[n] for row, n in zip(powers, exponents, strict=True)),
        )
        for exponents, c in polynomial.terms()
    )
    return sp.Add(*terms)
