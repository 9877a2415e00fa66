"""Waves of NLS on a plane wave (s = 1): Peregrine's, second order, Akhmediev, Kuznetsov and Ma.

The background is ``A exp(2 i A**2 tau)``, with ``x = A xi`` and ``t = A**2 tau``. The two breathers
have one parameter a, below and above 1/2; both tend to Peregrine's wave at 1/2.
"""

import sympy as sp

from longwave.solutions.equation import FOCUSING_NLS
from longwave.solutions.forms.nls_waves import AMPLITUDE, plane_wave
from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference
from longwave.solutions.symbols import A, tau, xi

_x: sp.Expr = A * xi
_t: sp.Expr = A**2 * tau
_BACKGROUND: sp.Expr = A * plane_wave(2 * A**2)
_a = sp.Symbol("a", positive=True)
_HALF = sp.Rational(1, 2)
_SOURCE = Reference("N. Akhmediev and V. I. Korneev, Theor. Math. Phys. 69 (1986) 1089")


def _on_plane_wave(
    name: str,
    title: str,
    parameters: tuple[Parameter, ...],
    reference: Reference,
    change: sp.Expr,
    stable: sp.Expr | None = None,
    period: sp.Expr | None = None,
) -> ClosedForm:
    """Return the plane wave times ``1 + change``; ``stable`` is ``change`` without cancellation."""
    bounded = _BACKGROUND * (1 + (change if stable is None else stable))
    far_field = _BACKGROUND if period is None else bounded
    return ClosedForm(
        name=name,
        title=title,
        expression=_BACKGROUND * (1 + change),
        equation=FOCUSING_NLS,
        parameters=(*parameters, AMPLITUDE),
        background=_BACKGROUND,
        far_fields=FarFields(far_field, far_field),
        reference=reference,
        period=period,
        stabilise=lambda: bounded,
    )


def nls_peregrine() -> ClosedForm:
    """Return Peregrine's wave, whose peak is three times as high as the plane wave."""
    return _on_plane_wave(
        "nls_peregrine",
        "Peregrine wave",
        (),
        Reference("D. H. Peregrine, J. Austral. Math. Soc. B 25 (1983) 16"),
        -4 * (1 + 4 * sp.I * _t) / (1 + 4 * _x**2 + 16 * _t**2),
    )


def nls_rogue_2() -> ClosedForm:
    """Return the second-order rational wave, whose peak is five times as high as the plane wave."""
    t = 2 * _t
    square, offset = _x**2 + t**2, sp.Rational(3, 4)
    real = (square + offset) * (_x**2 + 5 * t**2 + offset) - offset
    imaginary = t * (t**2 - 3 * _x**2 + 2 * square**2 - sp.Rational(15, 8))
    positive_part = sp.Rational(3, 64) * (12 * _x**2 + 44 * t**2 + 1)
    return _on_plane_wave(
        "nls_rogue_2",
        "rogue wave of second order",
        (),
        Reference("N. Akhmediev et al., Phys. Rev. E 80 (2009) 026601"),
        -(real + sp.I * imaginary) / (square**3 / 3 + (_x**2 - 3 * t**2) ** 2 / 4 + positive_part),
    )


def nls_akhmediev() -> ClosedForm:
    """Return Akhmediev's breather: periodic in xi, it grows out of the plane wave and decays once.

    The floating-point form is divided by the hyperbolic cosine, so that nothing cancels near
    Peregrine's wave.
    """
    root, wavenumber = sp.sqrt(2 * _a), 2 * sp.sqrt(1 - 2 * _a)
    growth = root * wavenumber
    z, angle = 2 * growth * _t, wavenumber * _x
    t, s = sp.tanh(z / 2), sp.sech(z / 2)
    nearby_part = 1 - root + 2 * root * sp.sin(angle / 2) ** 2
    return _on_plane_wave(
        "nls_akhmediev",
        "Akhmediev breather",
        (Parameter(_a, Bound(sp.S.Zero, "the plane wave"), Bound(_HALF, "the Peregrine wave")),),
        _SOURCE,
        (2 * (1 - 2 * _a) * sp.cosh(z) + sp.I * growth * sp.sinh(z))
        / (root * sp.cos(angle) - sp.cosh(z)),
        -2 * ((1 - 2 * _a) * (1 + t**2) + sp.I * growth * t) / (2 * t**2 + nearby_part * s**2),
        period=2 * sp.pi / (wavenumber * A),
    )


def nls_kuznetsov_ma() -> ClosedForm:
    """Return the breather of Kuznetsov and Ma: localised in xi and periodic in time."""
    root, width = sp.sqrt(2 * _a), 2 * sp.sqrt(2 * _a - 1)
    frequency = root * width
    angle, z = 2 * frequency * _t, width * _x
    t, s = sp.tanh(z / 2), sp.sech(z / 2)
    height = 2 * (1 - 2 * _a) * sp.cos(angle) - sp.I * frequency * sp.sin(angle)
    nearby_part = root - 1 + 2 * sp.sin(angle / 2) ** 2
    return _on_plane_wave(
        "nls_kuznetsov_ma",
        "Kuznetsov-Ma breather",
        (Parameter(_a, Bound(_HALF, "the Peregrine wave")),),
        _SOURCE,
        height / (root * sp.cosh(z) - sp.cos(angle)),
        height * s**2 / (2 * root * t**2 + nearby_part * s**2),
    )
