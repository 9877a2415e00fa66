"""Shocks of the KdV and mKdV equations with a Burgers term: steady fronts with losses."""

import sympy as sp

from longwave.solutions.equation import KDV_BURGERS, MKDV_BURGERS
from longwave.solutions.record import ClosedForm, FarFields, Reference, positive, real
from longwave.solutions.symbols import kappa, tau, xi

_level = sp.Symbol("U_0", real=True)
_SIXTH = sp.Rational(1, 6)


def kdv_burgers_shock() -> ClosedForm:
    """Return the shock from U_0 + 2/25 down to U_0 (s = 1); only this height has a closed form."""
    front = sp.tanh((xi - (6 * _level + sp.Rational(6, 25)) * tau) / 10)
    return ClosedForm(
        name="kdv_burgers_shock",
        title="KdV-Burgers shock",
        expression=_level + (1 - front) * (3 + front) / 50,
        equation=KDV_BURGERS,
        parameters=(real(_level),),
        far_fields=FarFields(_level + sp.Rational(2, 25), _level),
        reference=Reference("A. Jeffrey and S. Xu, Wave Motion 11 (1989) 559"),
    )


def mkdv_burgers_shock() -> ClosedForm:
    """Return the undercompressive shock from 1/6 - kappa up to 1/6 + kappa (s = 1, r = -1)."""
    front = sp.tanh(kappa * (xi + (2 * kappa**2 + _SIXTH) * tau))
    return ClosedForm(
        name="mkdv_burgers_shock",
        title="mKdV-Burgers shock",
        expression=_SIXTH + kappa * front,
        equation=MKDV_BURGERS,
        parameters=(positive(kappa, "the constant 1/6", default=_SIXTH),),
        far_fields=FarFields(_SIXTH - kappa, _SIXTH + kappa),
        reference=Reference("G. A. El, M. A. Hoefer and M. Shearer, SIAM Rev. 59 (2017) 3"),
    )
