"""Waves of NLS that keep their shape: plane wave, bright and dark soliton, dn and cn wave."""

import sympy as sp

from longwave.solutions.equation import DEFOCUSING_NLS, FOCUSING_NLS, NLS
from longwave.solutions.forms.bare_waves import QUARTER_PERIOD, modulus
from longwave.solutions.functions import jacobi_cn, jacobi_dn
from longwave.solutions.record import ClosedForm, FarFields, Reference, positive, real
from longwave.solutions.symbols import A, k, kappa, s, tau, xi

AMPLITUDE = positive(A, "the zero solution", default=sp.S.One)

_speed, _wavenumber = sp.symbols("v q", real=True)
_SOURCE = Reference("V. E. Zakharov and A. B. Shabat, Sov. Phys. JETP 34 (1972) 62")


def plane_wave(frequency: sp.Expr, wavenumber: sp.Expr = sp.S.Zero) -> sp.Expr:
    """Return ``exp(i (wavenumber xi + frequency tau))``."""
    return sp.exp(sp.I * (wavenumber * xi + frequency * tau))


def nls_plane() -> ClosedForm:
    """Return the plane wave of amplitude A and wavenumber q; s may be 1 or -1."""
    wave = A * plane_wave(2 * s * A**2 - _wavenumber**2, _wavenumber)
    parameters = (AMPLITUDE, real(_wavenumber))
    return ClosedForm(
        name="nls_plane",
        title="plane wave",
        expression=wave,
        equation=NLS,
        parameters=parameters,
        background=wave,
        far_fields=FarFields(wave, wave),
        reference=_SOURCE,
    )


def nls_bright() -> ClosedForm:
    """Return the bright soliton of amplitude A and speed v (s = 1)."""
    wave = A * sp.sech(A * (xi - _speed * tau)) * plane_wave(A**2 - _speed**2 / 4, _speed / 2)
    return ClosedForm(
        name="nls_bright",
        title="bright soliton",
        expression=wave,
        equation=FOCUSING_NLS,
        parameters=(AMPLITUDE, real(_speed)),
        reference=_SOURCE,
    )


def nls_dark() -> ClosedForm:
    """Return the dark soliton of speed v, black if v = 0, on sqrt(kappa**2 + v**2/4) (s = -1)."""
    carrier = plane_wave(-2 * (kappa**2 + _speed**2 / 4))
    imaginary = sp.I * _speed / 2
    ends = (carrier * (side * kappa + imaginary) for side in (-1, 1))
    return ClosedForm(
        name="nls_dark",
        title="dark soliton",
        equation=DEFOCUSING_NLS,
        parameters=(positive(kappa, "the plane wave", default=sp.S.One), real(_speed)),
        expression=carrier * (kappa * sp.tanh(kappa * (xi - _speed * tau)) + imaginary),
        far_fields=FarFields(*ends),
        reference=_SOURCE,
    )


def nls_dn() -> ClosedForm:
    """Return the dn wave of amplitude A (s = 1)."""
    wave = A * jacobi_dn(A * xi, k**2) * plane_wave(A**2 * (2 - k**2))
    return _periodic("nls_dn", "dn wave", "the plane wave", wave, 2 * QUARTER_PERIOD / A)


def nls_cn() -> ClosedForm:
    """Return the cn wave of amplitude k A (s = 1)."""
    wave = k * A * jacobi_cn(A * xi, k**2) * plane_wave(A**2 * (2 * k**2 - 1))
    return _periodic("nls_cn", "cn wave", "the zero solution", wave, 4 * QUARTER_PERIOD / A)


def _periodic(name: str, title: str, at_zero: str, wave: sp.Expr, period: sp.Expr) -> ClosedForm:
    return ClosedForm(
        name=name,
        title=title,
        expression=wave,
        equation=FOCUSING_NLS,
        parameters=(modulus(at_zero, "the bright soliton"), AMPLITUDE),
        far_fields=FarFields(wave, wave),
        reference=_SOURCE,
        period=period,
    )
