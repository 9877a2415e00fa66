"""Waves of the Gardner, Kawahara and modified Kawahara equations: solitons and a front.

A denominator ``a + b cosh(phase)`` divided by ``cosh(phase/2)**2`` neither overflows nor cancels
(`solutions.forms.solitons`).
"""

import sympy as sp

from longwave.solutions import equation
from longwave.solutions.forms.solitons import by_sech, by_tanh
from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference, positive
from longwave.solutions.symbols import A, kappa, tau, xi

_PHASE: sp.Expr = kappa * (xi - kappa**2 * tau)
_SOURCE = Reference("J. W. Miles, Tellus 31 (1979) 456")


def _soliton(name: str, title: str, parameter: Parameter, sign: int) -> ClosedForm:
    """Return ``sign kappa**2 / (sign + sqrt(1 + s kappa**2) cosh(phase))``.

    The equation has s = -1 if kappa has an upper bound, else s = 1.
    """
    is_bounded = parameter.upper is not None
    root = sp.sqrt((1 - kappa) * (1 + kappa) if is_bounded else 1 + kappa**2)
    divisor = sign + root * sp.cosh(_PHASE)
    bounded = (by_sech if is_bounded else by_tanh)(divisor, _PHASE)
    return ClosedForm(
        name=name,
        title=title,
        expression=sign * kappa**2 / divisor,
        equation=equation.DEFOCUSING_GARDNER if is_bounded else equation.FOCUSING_GARDNER,
        parameters=(parameter,),
        reference=_SOURCE,
        stabilise=lambda: sign * kappa**2 * sp.sech(_PHASE / 2) ** 2 / bounded,
    )


def gardner_soliton() -> ClosedForm:
    """Return the positive Gardner soliton (s = 1)."""
    parameter = positive(kappa, "the zero solution")
    return _soliton("gardner_soliton", "Gardner soliton", parameter, 1)


def gardner_negative_soliton() -> ClosedForm:
    """Return the negative soliton (s = 1), at least 2 deep; it tends to an algebraic soliton."""
    parameter = positive(kappa, "the algebraic soliton")
    return _soliton("gardner_negative_soliton", "negative Gardner soliton", parameter, -1)


def gardner_table_soliton() -> ClosedForm:
    """Return the table soliton (s = -1): below 1, and a plateau with steep ends as kappa -> 1."""
    upper = Bound(sp.S.One, "two fronts infinitely far apart")
    parameter = Parameter(kappa, Bound(sp.S.Zero, "the zero solution"), upper)
    return _soliton("gardner_table_soliton", "Gardner table soliton", parameter, 1)


def gardner_kink() -> ClosedForm:
    """Return the front from 1/2 + A down to 1/2 - A (s = -1); by default into a medium at rest."""
    half = sp.Rational(1, 2)
    speed = sp.Rational(3, 2) - 2 * A**2
    return ClosedForm(
        name="gardner_kink",
        title="Gardner front",
        expression=half - A * sp.tanh(A * (xi - speed * tau)),
        equation=equation.DEFOCUSING_GARDNER,
        parameters=(positive(A, "the constant 1/2", default=half),),
        far_fields=FarFields(half + A, half - A),
        reference=_SOURCE,
    )


def kawahara_soliton() -> ClosedForm:
    """Return the sech**4 soliton (s = 1), which exists with one amplitude only."""
    phase = (xi - sp.Rational(36, 169) * tau) / sp.sqrt(52)
    return ClosedForm(
        name="kawahara_soliton",
        title="Kawahara soliton",
        expression=sp.Rational(35, 338) * sp.sech(phase) ** 4,
        equation=equation.KAWAHARA,
        parameters=(),
        reference=Reference("Y. Yamamoto and E. I. Takizawa, J. Phys. Soc. Jpn. 50 (1981) 1421"),
    )


def modified_kawahara_soliton() -> ClosedForm:
    """Return the sech**2 soliton (r = s = 1), which exists with one amplitude only."""
    phase = (xi - sp.Rational(4, 25) * tau) / sp.sqrt(20)
    return ClosedForm(
        name="modified_kawahara_soliton",
        title="modified Kawahara soliton",
        expression=sp.sqrt(sp.Rational(3, 20)) * sp.sech(phase) ** 2,
        equation=equation.MODIFIED_KAWAHARA,
        parameters=(),
        reference=Reference("A. H. Khater et al., Appl. Math. Comput. 141 (2003) 421"),
    )
