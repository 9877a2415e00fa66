"""The rogue wave on the cn wave of the paper's eqs. (26) to (28), in real and imaginary parts.

The integral in theta is replaced by a closed form in real parts; a test compares it with the
printed one. With N, M, S the printed combinations ``(1 + theta**2) y - theta y'/lambda`` and so
on, the denominator ``G_2 = (1 - 2 k**2) |N|**2 + |M|**2 + |S|**2`` cancels as k goes to 1. Because
``N**2 = M**2 + S**2``, it is also ``2 k'**2 |N|**2 + 4 Im(M conj S)**2/(|M|**2+|S|**2+|N|**2)``, a
sum of squares, which is evaluated in floating point after division by ``1 + |theta|**2``. Likewise
theta is evaluated without the poles of its integral, which cancel identically.
"""

import sympy as sp

from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.forms.bare_waves import (
    CN_PHASE,
    CN_WAVE,
    QUARTER_PERIOD,
    modulus,
    shifted_area,
)
from longwave.solutions.functions import jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_sn
from longwave.solutions.record import ClosedForm, FarFields, Reference
from longwave.solutions.symbols import complementary_modulus, k, tau, xi

_y, _slope, _kp = sp.symbols("y slope k_prime", real=True)
_theta_re, _theta_im = sp.symbols("theta_re theta_im", real=True)
_theta = _theta_re + sp.I * _theta_im
_lambda = (k + sp.I * _kp) / 2
_weight = _y**2 + sp.I * k * _kp
_inverse_lambda = 2 * (k - sp.I * _kp)  # lambda has modulus 1/2

Parts = tuple[sp.Expr, sp.Expr]
"""Real and imaginary part."""


def integrand(u: sp.Expr) -> sp.Expr:
    """Return the (complex) integrand of the printed integral in theta_cn."""
    y = k * jacobi_cn(u, k**2)
    return y**2 / (y**2 + sp.I * k * complementary_modulus) ** 2


def integral(u: sp.Expr) -> Parts:
    """Return real and imaginary part of the integral of ``integrand`` from 0 to ``u``."""
    z = sp.Dummy("z", real=True)
    square = k**2 * complementary_modulus**2
    speed = 2 * k**2 - 1
    y, pole = _pole(z)
    real = speed * z / 2 - _area(z) - (speed / 2 + y**2) * pole
    fourth = (z - pole) / 2 + speed / (4 * square) * (_area(z) + y**2 * pole)
    return real.subs(z, u), (-2 * k * complementary_modulus * fourth).subs(z, u)


def _pole(z: sp.Symbol) -> Parts:
    """Return ``y = k cn`` and ``y y'/Q`` with ``Q = y**4 + k**2 k'**2``."""
    y = k * jacobi_cn(z, k**2)
    return y, y * sp.diff(y, z) / (y**4 + k**2 * complementary_modulus**2)


def _area(z: sp.Symbol) -> sp.Expr:
    """Return the integral of ``y**2 = (k cn)**2`` from 0 to z."""
    return jacobi_epsilon(z, k**2) - complementary_modulus**2 * z


def theta() -> Parts:
    """Return real and imaginary part of theta_cn in xi, tau and k: the paper's eq. (28)."""
    real, imaginary = sp.symbols("integral_re integral_im", real=True)
    printed = -4 * _lambda * _weight * (real + sp.I * imaginary)
    integral_re, integral_im = integral(CN_PHASE)
    values = _background_values() | {real: integral_re - tau, imaginary: integral_im}
    theta_re, theta_im = (part.xreplace(values) for part in _parts(printed))
    return theta_re, theta_im


def _stable_theta() -> Parts:
    """Return ``theta`` with the poles ``Q = 0`` divided out, and epsilon by ``shifted_area``.

    In the printed form terms of order 1 cancel to k'**2 as k goes to 1; here nothing cancels.
    """
    kp, square = complementary_modulus, CN_WAVE**2
    sn, cn, dn = (f(CN_PHASE, k**2) for f in (jacobi_sn, jacobi_cn, jacobi_dn))
    area = shifted_area(CN_PHASE)
    real = square * ((area - CN_PHASE) / k + 2 * k * tau) - k * (area + 2 * kp**2 * tau)
    imaginary = square * (area / kp + 2 * kp * tau) + kp * (area - CN_PHASE + 2 * k**2 * tau)
    return real - k * sn * cn / dn, imaginary


def _background_values() -> dict[sp.Expr, sp.Expr]:
    return {_y: CN_WAVE, _slope: sp.diff(CN_WAVE, xi), _kp: complementary_modulus}


def _parts(polynomial: sp.Expr) -> Parts:
    """Return real and imaginary part of a polynomial in real symbols and I."""
    expanded = sp.Poly(sp.expand(polynomial), sp.I)
    powers = {power: coefficient for (power,), coefficient in expanded.terms()}
    return sp.factor(powers.get(0, sp.S.Zero)), sp.factor(powers.get(1, sp.S.Zero))


def _combinations(one: sp.Expr, theta: sp.Expr, square: sp.Expr) -> list[Parts]:
    """Return N, M, S of the printed formula, given the values of 1, theta and theta**2.

    The three values may have a common factor.
    """
    N = (one + square) * _y - _inverse_lambda * theta * _slope
    M = (one - square) * _weight
    S = _inverse_lambda / 2 * (one + square) * _slope - 2 * theta * _y
    return [_parts(combination) for combination in (N, M, S)]


def _squared(z: Parts) -> sp.Expr:
    return z[0] ** 2 + z[1] ** 2


def _in_xi_tau(fraction: sp.Expr, theta: Parts, weights: dict[sp.Expr, sp.Expr]) -> sp.Expr:
    """Return ``y + fraction`` in xi, tau and k, with the value ``theta`` of theta substituted.

    ``weights`` maps symbols of the fraction to their formulas in theta.
    """
    angles = {_theta_re: theta[0], _theta_im: theta[1]}
    inner = {symbol: value.xreplace(angles) for symbol, value in weights.items()}
    return (_y + fraction).xreplace(inner | angles | _background_values())


def _printed() -> sp.Expr:
    N, M, S = _combinations(sp.S.One, _theta, _theta**2)
    G_1 = 4 * k * _kp * (M[1] * N[0] - M[0] * N[1])
    G_2 = (1 - 2 * k**2) * _squared(N) + _squared(M) + _squared(S)
    return _in_xi_tau(G_1 / G_2, theta(), {})


def _stable() -> sp.Expr:
    """Return the wave over a sum of squares, all divided by powers of ``1 + |theta|**2``.

    ``w_i`` are 1, theta and theta**2 after that division. ``n_i`` are theta's coordinates on the
    unit sphere, in which the imaginary parts in G_1 and G_2 are polynomials. As k goes to 1 the
    polynomials' terms cancel in 20 digits. ``y'**2 = (k**2 - y**2) (y**2 + k'**2)`` turns them into
    sums of products of ``small_factor``, which can vanish, and ``large_factor``, which cannot.
    """
    one, re, im, square_re, square_im = w = sp.symbols("w_:5", real=True)
    n = sp.symbols("n_:3", real=True)
    N, M, S = _combinations(one, re + sp.I * im, square_re + sp.I * square_im)
    sn, dn = (f(CN_PHASE, k**2) for f in (jacobi_sn, jacobi_dn))
    small_factor = dn * _y * n[2] - k * _kp * sn * n[0]
    large_factor = k * (dn + sn * _y * n[1])
    mixed = _kp * _y * n[0] - k * sn * dn * (_y**2 - _kp**2) * n[2]
    G_1 = 4 * k * _kp * (large_factor * mixed - (_y**4 + k**2 * _kp**2) * small_factor * n[1]) / dn
    G_2 = 2 * _kp**2 * _squared(N) + 4 * (small_factor * large_factor) ** 2 / (
        _squared(M) + _squared(S) + _squared(N)
    )
    size = _theta_re**2 + _theta_im**2
    difference = (_theta_re - _theta_im) * (_theta_re + _theta_im)
    divided = (sp.S.One, _theta_re, _theta_im, difference, 2 * _theta_re * _theta_im)
    sphere = (1 - size, 2 * _theta_re, 2 * _theta_im)
    values = zip(w + n, divided + sphere, strict=True)
    weights = {symbol: value / (1 + size) for symbol, value in values}
    return _in_xi_tau(G_1 / G_2, _stable_theta(), weights)


def rogue_cn() -> ClosedForm:
    """Return the rogue wave on the cnoidal wave (K4 > 0)."""
    far_field = -CN_WAVE
    return ClosedForm(
        name="rogue_cn",
        title="rogue wave on the cnoidal wave",
        expression=_printed,
        equation=FOCUSING_MKDV,
        parameters=(modulus("the zero solution", "the triple-pole soliton"),),
        background=CN_WAVE,
        far_fields=FarFields(far_field, far_field),
        reference=Reference("chen2018rogue", "rogue-wave on cn-wave"),
        period=4 * QUARTER_PERIOD,
        stabilise=_stable,
    )
