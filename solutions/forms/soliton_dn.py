"""The algebraic soliton on the dn wave, as printed in the paper's eqs. (23) to (25) (K4 > 0).

The integral in theta is replaced by a closed form; a test compares it with the printed one.
``E`` is the Jacobi epsilon function (``E' = dn**2``). In floating point, the wave is evaluated
with ``cos f = (1 - theta**2)/(1 + theta**2)`` and ``sin f = 2 theta/(1 + theta**2)``.
"""

from collections.abc import Callable

import sympy as sp

from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.forms import bare_waves
from longwave.solutions.functions import jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_sn
from longwave.solutions.record import ClosedForm, FarFields, Reference
from longwave.solutions.symbols import complementary_modulus, k, tau, xi

_y, _slope, _theta, _cos, _sin = sp.symbols("y slope theta cos_f sin_f", real=True)
_FUNCTIONS = (jacobi_sn, jacobi_cn, jacobi_dn, jacobi_epsilon)
_lambda = (1 + complementary_modulus) / 2


def integrand(u: sp.Expr) -> sp.Expr:
    """Return the integrand of the printed integral in theta_dn."""
    return jacobi_dn(u, k**2) ** 2 / (jacobi_dn(u, k**2) ** 2 + complementary_modulus) ** 2


def integral(u: sp.Expr) -> sp.Expr:
    """Return the integral of ``integrand`` from 0 to ``u``, in closed form."""
    z = sp.Dummy("z", real=True)
    y = jacobi_dn(z, k**2)
    periodic = y * sp.diff(y, z) / (complementary_modulus * (y**2 + complementary_modulus))
    linear = z + jacobi_epsilon(z, k**2) / complementary_modulus
    return ((linear + periodic) / (2 * (1 + complementary_modulus) ** 2)).subs(z, u)


def _stable_integral(u: sp.Expr) -> sp.Expr:
    """Return ``integral`` with E by ``shifted_area`` and divisions by k' cancelled."""
    s, c, d, kp, E = sp.symbols("s c d k_prime E", positive=True)
    z = sp.Dummy("z", real=True)
    functions = {f(z, k**2): v for f, v in zip(_FUNCTIONS, (s, c, d, E), strict=True)}
    symbolic = integral(z).xreplace(functions).subs(complementary_modulus, kp)
    slope = sp.diff(symbolic, E)
    linear = symbolic.subs({s: 0, E: 0})
    periodic = sp.factor(sp.cancel((symbolic - linear).subs(E, k**2 * s * c / d)))
    total = slope * E + linear + periodic
    to_functions = {symbol: function for function, symbol in functions.items()}
    to_functions[E] = bare_waves.shifted_area(z)
    return total.subs(to_functions).subs(kp, complementary_modulus).subs(z, u)


def theta(integral: Callable[[sp.Expr], sp.Expr] = integral) -> sp.Expr:
    """Return theta_dn in xi, tau and k, the paper's eq. (25), with its integral by ``integral``."""
    weight = bare_waves.DN_WAVE**2 + complementary_modulus
    return -4 * _lambda * weight * (integral(bare_waves.DN_PHASE) - tau)


def _fraction() -> tuple[sp.Expr, sp.Expr]:
    """Return numerator and denominator of the fraction added to Y_dn, in y, y' and theta."""
    numerator = (1 - _theta**2) * (_y**2 + complementary_modulus)
    return numerator, (1 + _theta**2) * _y - _theta * _slope / _lambda


def _divide(quadratic: sp.Expr) -> sp.Expr:
    """Divide a quadratic in theta by ``1 + theta**2``; return it in terms of cos f and sin f."""
    halves = {0: (1 + _cos) / 2, 1: _sin / 2, 2: (1 - _cos) / 2}
    polynomial = sp.Poly(quadratic, _theta)
    return sp.expand(sum(c * halves[power] for (power,), c in polynomial.terms()))


def _assemble(numerator: sp.Expr, denominator: sp.Expr, angle: sp.Expr) -> sp.Expr:
    values = {
        _cos: (1 - angle**2) / (1 + angle**2),
        _sin: 2 * angle / (1 + angle**2),
        _theta: angle,
        _slope: sp.diff(bare_waves.DN_WAVE, xi),
        _y: bare_waves.DN_WAVE,
    }
    return (_y + numerator / denominator).xreplace(values)


def _stable() -> sp.Expr:
    numerator, denominator = _fraction()
    return _assemble(_divide(numerator), _divide(denominator), theta(_stable_integral))


def soliton_dn() -> ClosedForm:
    """Return the algebraic soliton on the dnoidal wave (K4 > 0)."""
    far_field = -jacobi_dn(bare_waves.DN_PHASE + bare_waves.QUARTER_PERIOD, k**2)
    return ClosedForm(
        name="soliton_dn",
        title="algebraic soliton on the dnoidal wave",
        expression=lambda: _assemble(*_fraction(), theta()),
        equation=FOCUSING_MKDV,
        parameters=(
            bare_waves.modulus("the algebraic soliton rational_1", "the double-pole soliton"),
        ),
        background=bare_waves.DN_WAVE,
        far_fields=FarFields(far_field, far_field),
        reference=Reference("chen2018rogue", "alg-decaying solitons on dn-wave background"),
        period=2 * bare_waves.QUARTER_PERIOD,
        stabilise=_stable,
    )
