"""Waves of the Gardner and Kawahara equations, and of modified Kawahara: solitons and a front.

Divided by ``cosh(phase/2)**2`` a denominator ``a + b cosh(phase)`` neither overflows nor cancels
(`solutions.forms.solitons`).
"""

import sympy as sp

from longwave.solutions.equation import (
    DEFOCUSING_GARDNER,
    FOCUSING_GARDNER,
    KAWAHARA,
    MODIFIED_KAWAHARA,
    Equation,
)
from longwave.solutions.forms.solitons import by_sech, by_tanh
from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference
from longwave.solutions.symbols import A, kappa, tau, xi

__all__ = [
    "gardner_kink",
    "gardner_negative_soliton",
    "gardner_soliton",
    "gardner_table_soliton",
    "kawahara_soliton",
    "modified_kawahara_soliton",
]

_PHASE: sp.Expr = kappa * (xi - kappa**2 * tau)
_SOURCE = Reference("J. W. Miles, Tellus 31 (1979) 456")


def _on_zero(
    name: str,
    title: str,
    equation: Equation,
    parameters: tuple[Parameter, ...],
    reference: Reference,
    expression: sp.Expr,
    stable: sp.Expr | None = None,
) -> ClosedForm:
    """A soliton on zero."""
    return ClosedForm(
        name=name,
        title=title,
        expression=expression,
        equation=equation,
        parameters=parameters,
        background=sp.S.Zero,
        far_fields=FarFields(sp.S.Zero, sp.S.Zero),
        reference=reference,
        stabilise=None if stable is None else lambda: stable,
    )


def gardner_soliton() -> ClosedForm:
    """The positive soliton (s = 1)."""
    divisor = 1 + sp.sqrt(1 + kappa**2) * sp.cosh(_PHASE)
    return _on_zero(
        "gardner_soliton",
        "Gardner soliton",
        FOCUSING_GARDNER,
        (Parameter(kappa, lower=Bound(sp.S.Zero, "the zero solution")),),
        _SOURCE,
        kappa**2 / divisor,
        kappa**2 * sp.sech(_PHASE / 2) ** 2 / by_tanh(divisor, _PHASE),
    )


def gardner_negative_soliton() -> ClosedForm:
    """The negative soliton (s = 1), at least 2 deep; algebraic as its width grows."""
    divisor = -1 + sp.sqrt(1 + kappa**2) * sp.cosh(_PHASE)
    return _on_zero(
        "gardner_negative_soliton",
        "negative Gardner soliton",
        FOCUSING_GARDNER,
        (Parameter(kappa, lower=Bound(sp.S.Zero, "the algebraic soliton")),),
        _SOURCE,
        -(kappa**2) / divisor,
        -(kappa**2) * sp.sech(_PHASE / 2) ** 2 / by_tanh(divisor, _PHASE),
    )


def gardner_table_soliton() -> ClosedForm:
    """The soliton with s = -1: lower than 1, a table with steep ends as kappa goes to 1."""
    divisor = 1 + sp.sqrt((1 - kappa) * (1 + kappa)) * sp.cosh(_PHASE)
    return _on_zero(
        "gardner_table_soliton",
        "Gardner table soliton",
        DEFOCUSING_GARDNER,
        (
            Parameter(
                kappa,
                lower=Bound(sp.S.Zero, "the zero solution"),
                upper=Bound(sp.S.One, "two fronts infinitely far apart"),
            ),
        ),
        _SOURCE,
        kappa**2 / divisor,
        kappa**2 * sp.sech(_PHASE / 2) ** 2 / by_sech(divisor, _PHASE),
    )


def gardner_kink() -> ClosedForm:
    """The front from 1/2 + A down to 1/2 - A (s = -1); by default into what is at rest."""
    half = sp.Rational(1, 2)
    speed = sp.Rational(3, 2) - 2 * A**2
    return ClosedForm(
        name="gardner_kink",
        title="Gardner front",
        expression=half - A * sp.tanh(A * (xi - speed * tau)),
        equation=DEFOCUSING_GARDNER,
        parameters=(Parameter(A, lower=Bound(sp.S.Zero, "the constant 1/2"), default=half),),
        background=sp.S.Zero,
        far_fields=FarFields(half + A, half - A),
        reference=_SOURCE,
    )


def kawahara_soliton() -> ClosedForm:
    """The sech**4 soliton (s = 1): the only one of this shape."""
    phase = (xi - sp.Rational(36, 169) * tau) / sp.sqrt(52)
    return _on_zero(
        "kawahara_soliton",
        "Kawahara soliton",
        KAWAHARA,
        (),
        Reference("Y. Yamamoto and E. I. Takizawa, J. Phys. Soc. Jpn. 50 (1981) 1421"),
        sp.Rational(35, 338) * sp.sech(phase) ** 4,
    )


def modified_kawahara_soliton() -> ClosedForm:
    """The sech**2 soliton (r = s = 1): the only one of this shape."""
    phase = (xi - sp.Rational(4, 25) * tau) / sp.sqrt(20)
    return _on_zero(
        "modified_kawahara_soliton",
        "modified Kawahara soliton",
        MODIFIED_KAWAHARA,
        (),
        Reference("A. H. Khater et al., Appl. Math. Comput. 141 (2003) 421"),
        sp.sqrt(sp.Rational(3, 20)) * sp.sech(phase) ** 2,
    )
