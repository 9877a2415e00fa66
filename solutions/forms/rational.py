"""The rational solutions of every order; the first three as printed in the literature.

``U_j = (-1)**j [1 - 2 (arg f_j)_x]`` with ``f_j = A + i B`` from
``solutions.forms.tau_polynomials`` and ``x = xi - 6 tau``.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import sympy as sp
from flint import fmpq_mpoly

from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.forms.tau_polynomials import SPACE_TIME, RationalTau, rational_tau
from longwave.solutions.record import ClosedForm, FarFields, Parameter, Reference
from longwave.solutions.symbols import shift_symbol, tau, xi

CO_MOVING: sp.Expr = xi - 6 * tau


def horner_form(order: int, free: tuple[int, ...] = ()) -> sp.Expr:
    """Return ``(-1)**j [1 - 2 (A B_x - A_x B)/(A**2 + B**2)]``, j = ``order``, in Horner form.

    ``free`` lists the indices 5, 7, ... of the shifts tau_5, tau_7, ... that are symbols.
    """
    family = rational_tau(order, free)
    symbols = family.symbols
    parts = [sp.horner(_to_sympy(part, *symbols), *symbols) for part in _parts(family)]
    wave = _wave(order, *parts)
    return wave.subs(dict(zip(SPACE_TIME, (CO_MOVING, tau), strict=True)), simultaneous=True)


def rational(order: int, free: Iterable[int] = ()) -> ClosedForm:
    """Return the rational solution of an order; ``free`` lists its shifts by index, 5 for tau_5.

    Its peak is ``2 order + 1`` at the origin on the background ``(-1)**order``, if all shifts are
    0. Source: the paper's Ref. ankiewicz2018rogue. Raises ValueError as ``rational_tau`` does.

    >>> rational(3, free=[5]).parameters[0].name
    'tau_5'
    """
    shifts = tuple(sorted(free))
    family = rational_tau(order, shifts)
    symbols = (CO_MOVING, tau, *family.symbols[2:])
    level = sp.Integer((-1) ** order)
    form = ClosedForm(
        name=f"rational_{order}",
        title=f"rational solution of order {order}",
        expression=_wave(order, *(_to_sympy(part, *symbols) for part in _parts(family))),
        equation=FOCUSING_MKDV,
        parameters=tuple(Parameter(shift_symbol(i), default=sp.S.Zero) for i in shifts),
        background=level,
        far_fields=FarFields(level, level),
        reference=Reference("ankiewicz2018rogue", "standard mKdV"),
        stabilise=lambda: horner_form(order, shifts),
        evaluator=lambda values: _evaluator(family, values),
    )
    return form.with_pickle_call(rational, order, shifts)


def _evaluator(family: RationalTau, shifts: Mapping[sp.Symbol, sp.Expr]) -> Any:
    from longwave.solutions.run.rational_evaluator import RationalEvaluator  # needs a compiler

    return RationalEvaluator(family, shifts)


def _parts(family: RationalTau) -> list[fmpq_mpoly]:
    """Return the polynomials A and B of ``family`` and their derivatives A_x and B_x."""
    return [family.A, family.B, family.A.derivative("x"), family.B.derivative("x")]


def _wave(order: int, A: sp.Expr, B: sp.Expr, A_x: sp.Expr, B_x: sp.Expr) -> sp.Expr:
    return (-1) ** order * (1 - 2 * (A * B_x - A_x * B) / (A**2 + B**2))


def _to_sympy(polynomial: fmpq_mpoly, *generators: sp.Expr) -> sp.Expr:
    """Convert a FLINT polynomial to an expanded SymPy expression in ``generators``."""
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


def _second(aT: sp.Expr, bX: sp.Expr) -> sp.Expr:
    G_2 = 3 - (6 * aT + bX) * ((6 * aT + bX) ** 3 + 6 * (22 * aT + bX))
    mixed = (
        243 * (2 * aT) ** 4 * (aT + bX)
        + bX * (3 * bX**4 - 2 * bX**2 + 51)
        + 72 * aT**2 * bX * (5 * bX**2 - 9)
        + 108 * aT**3 * (15 * bX**2 - 13)
        + 3 * aT * (15 * bX**4 - 30 * bX**2 + 139)
    )
    D_2 = 12 * aT * mixed + bX**6 + 3 * bX**4 + 27 * bX**2 + 9
    return 12 * G_2 / D_2 + 1


def _third(bX: sp.Expr, cT: sp.Expr) -> sp.Expr:
    z = (2 * bX - cT) / 4
    G_3 = 675 + 4 * (
        800 * cT**3 * z
        + 150 * cT**2 * (16 * z**4 - 8 * z**2 + 5)
        + 120 * cT * z * (-16 * z**4 + 40 * z**2 + 15)
        + z**2 * (8 * z**2 * (32 * z**6 + 120 * z**4 + 420 * z**2 - 225) - 675)
    )
    D_3 = 2025 + 8 * (
        800 * cT**4
        - 800 * cT**3 * z * (-3 + 4 * z**2)
        + 30 * cT**2 * (165 - 180 * z**2 + 240 * z**4 + 64 * z**6)
        + 10 * cT * z * (-675 + 32 * z**2 * (45 - 27 * z**2 + 8 * z**6))
        + z**2 * (6075 + 2 * z**2 * (3375 + 16 * z**2 * (585 + 135 * z**2 + 24 * z**4 + 16 * z**6)))
    )
    return 24 * G_3 / D_3 - 1


def _as_published(order: int, title: str, expression: sp.Expr, label: str) -> ClosedForm:
    """Return the rational solution of an order without shifts, in the formula of its source."""
    reference = Reference("ankiewicz2018rogue", label)
    return replace(rational(order), title=title, expression=expression, reference=reference)


def rational_1() -> ClosedForm:
    """Return the first-order rational solution: a Lorentzian travelling wave on -1 (K4 > 0)."""
    return _as_published(
        1,
        "first-order rational solution (Lorentzian)",
        4 / (1 + 4 * CO_MOVING**2) - 1,
        "Sec: Local waves on constant back",
    )


def rational_2() -> ClosedForm:
    """Return the second-order rational solution Y2, as in the paper's eqs. (12) and (13) (K4 > 0).

    In the letters of the paper's eq. (14), ``b X`` is ``2 xi`` and ``a T`` is ``-2 tau``, because
    ``b = sqrt(24 K4/K2) = 2 sqrt(6 K4/K2)`` and ``a = b**3 gamma_3/4`` with ``gamma_3`` minus the
    dispersive coefficient.
    """
    expression = _second(aT=-2 * tau, bX=2 * xi)
    return _as_published(2, "second-order rational solution", expression, "mKdV 2-order soln")


def rational_3() -> ClosedForm:
    """Return the third-order rational solution Y3, as in the paper's eqs. (17) and (18) (K4 > 0).

    In the paper's letters, ``b X`` is ``2 xi`` and ``c T`` is ``24 tau``, because
    ``c = -3 b**3 gamma_3`` is 24 times the rate of tau; hence ``z = (2 b X - c T)/4 = xi - 6 tau``.
    """
    expression = _third(bX=2 * xi, cT=24 * tau)
    return _as_published(3, "third-order rational solution", expression, "third-order soln of mKdV")
