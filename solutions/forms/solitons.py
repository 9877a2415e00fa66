"""Solitons and kinks: on zero, on a constant, and a kink with its antikink.

A wave on a constant has a denominator ``a + b cosh(phase)``, which divided by
``cosh(phase/2)**2`` neither overflows nor cancels.
"""

import sympy as sp

from longwave.solutions.equation import DEFOCUSING_MKDV, FOCUSING_MKDV
from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference, positive
from longwave.solutions.symbols import A, kappa, tau, xi


def by_tanh(total: sp.Expr, phase: sp.Expr) -> sp.Expr:
    """Divide ``total``, ``a + b cosh(phase)``, by ``cosh(phase/2)**2``; return it in tanh.

    The result ``(a + b) + (b - a) tanh(phase/2)**2`` has no cancellation if ``|a| <= b``.

    >>> z = sp.Symbol("z")
    >>> by_tanh(3 + 5 * sp.cosh(z), z)
    2*tanh(z/2)**2 + 8
    """
    a, b = _coefficients(total, phase)
    return (a + b) + (b - a) * sp.tanh(phase / 2) ** 2


def by_sech(total: sp.Expr, phase: sp.Expr) -> sp.Expr:
    """Divide ``total``, ``a + b cosh(phase)``, by ``cosh(phase/2)**2``; return it in sech.

    The result ``2 b + (a - b) sech(phase/2)**2`` has no cancellation if ``a >= b >= 0``.

    >>> z = sp.Symbol("z")
    >>> by_sech(5 + 3 * sp.cosh(z), z)
    2*sech(z/2)**2 + 6
    """
    a, b = _coefficients(total, phase)
    return 2 * b + (a - b) * sp.sech(phase / 2) ** 2


def _coefficients(total: sp.Expr, phase: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    b = total.coeff(sp.cosh(phase))
    return total - b * sp.cosh(phase), b


def soliton_sech() -> ClosedForm:
    """Return the sech soliton on zero (K4 > 0)."""
    return ClosedForm(
        name="soliton_sech",
        title="sech soliton",
        expression=A * sp.sech(A * xi - A**3 * tau),
        equation=FOCUSING_MKDV,
        parameters=(positive(A, "the zero solution"),),
        reference=Reference("ablowitz1981solitons", "standard mKdV"),
    )


def kink() -> ClosedForm:
    """Return the kink between -A and A (K4 < 0)."""
    return ClosedForm(
        name="kink",
        title="kink",
        expression=A * sp.tanh(A * xi + 2 * A**3 * tau),
        equation=DEFOCUSING_MKDV,
        parameters=(positive(A, "the zero solution"),),
        far_fields=FarFields(-A, A),
        reference=Reference("el2017dispersive", "standard mKdV"),
    )


def soliton_background() -> ClosedForm:
    """Return the soliton on a constant background (K4 > 0); it tends to an algebraic soliton."""
    level = sp.Symbol("U_0", real=True)
    phase = kappa * (xi - (6 * level**2 + kappa**2) * tau)
    denominator = 2 * level + sp.sqrt(4 * level**2 + kappa**2) * sp.cosh(phase)
    no_width = "the constant U_0, or the Lorentzian rational_1 if U_0 < 0"
    return ClosedForm(
        name="soliton_background",
        title="soliton on a constant background",
        expression=level + kappa**2 / denominator,
        equation=FOCUSING_MKDV,
        parameters=(Parameter(level, default=sp.S.One), positive(kappa, no_width)),
        background=level,
        far_fields=FarFields(level, level),
        reference=Reference("el2017dispersive", "standard mKdV"),
        stabilise=lambda: level + kappa**2 * sp.sech(phase / 2) ** 2 / by_tanh(denominator, phase),
    )


def kink_antikink() -> ClosedForm:
    """Return a kink and an antikink (K4 < 0): a dark soliton on a constant, of any width."""
    phase = kappa * (xi + (6 * A**2 - kappa**2) * tau)
    denominator = 2 * A + sp.sqrt(4 * A**2 - kappa**2) * sp.cosh(phase)
    return ClosedForm(
        name="kink_antikink",
        title="kink and antikink",
        expression=A - kappa**2 / denominator,
        equation=DEFOCUSING_MKDV,
        parameters=(
            positive(A, "the zero solution"),
            positive(
                kappa, "the constant A", Bound(2 * A, "a kink and an antikink infinitely far apart")
            ),
        ),
        background=A,
        far_fields=FarFields(A, A),
        reference=Reference("el2017dispersive", "standard mKdV"),
        stabilise=lambda: A - kappa**2 * sp.sech(phase / 2) ** 2 / by_sech(denominator, phase),
    )
