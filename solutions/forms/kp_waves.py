"""Waves of KP: the line soliton, and the lump of KP-I."""

import sympy as sp

from longwave.solutions.equation import KP, KP_1
from longwave.solutions.record import ClosedForm, Reference, positive, real
from longwave.solutions.symbols import kappa, s, tau, xi, zeta

_q = sp.Symbol("q", real=True)


def kp_line_soliton() -> ClosedForm:
    """Return the line soliton, constant along ``xi + q zeta = const``; s may be 1 or -1."""
    phase = kappa * (xi + _q * zeta - (4 * kappa**2 + 3 * s * _q**2) * tau)
    return ClosedForm(
        name="kp_line_soliton",
        title="KP line soliton",
        expression=2 * kappa**2 * sp.sech(phase) ** 2,
        potential=2 * kappa * sp.tanh(phase),
        equation=KP,
        parameters=(positive(kappa, "the zero solution"), real(_q)),
        reference=Reference(
            "B. B. Kadomtsev and V. I. Petviashvili, Sov. Phys. Dokl. 15 (1970) 539"
        ),
    )


def kp_lump() -> ClosedForm:
    """Return the lump of KP-I, of height 4 kappa**2; oblique if q is not 0."""
    along = xi + _q * zeta - 3 * (kappa**2 - _q**2) * tau
    across = kappa * (zeta + 6 * _q * tau)
    square = across**2 + 1 / kappa**2
    return ClosedForm(
        name="kp_lump",
        title="KP-I lump",
        expression=4 * (square - along**2) / (square + along**2) ** 2,
        potential=4 * along / (square + along**2),
        equation=KP_1,
        parameters=(positive(kappa, "the zero solution"), real(_q)),
        reference=Reference("S. V. Manakov et al., Phys. Lett. A 63 (1977) 205"),
    )
