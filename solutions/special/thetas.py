"""Jacobi's zeta, eta (H) and theta (Theta) as SymPy functions of (z, m), m = k**2.

H(z) = theta_1(pi z / (2 K), q) and Theta(z) = theta_4(pi z / (2 K), q), not normalised, as in the
paper's eqs. (19) and (20), so H = sqrt(k) sn Theta.
"""

from __future__ import annotations

from sympy import Expr, S, elliptic_e, elliptic_k, sqrt, tanh

from solutions.special.elliptic import jacobi_cn, jacobi_dn
from solutions.special.function import JacobiFunction


class _RealBelowOne(JacobiFunction):
    """Functions that are real for real z and m < 1."""

    def _eval_is_extended_real(self) -> bool | None:
        z, m = self.args
        return True if z.is_real and m.is_nonnegative and (1 - m).is_positive else None

    def _eval_is_finite(self) -> bool | None:
        return self._eval_is_extended_real()


class jacobi_zeta(_RealBelowOne):
    """Jacobi's zeta Z(z | m) = Theta'(z) / Theta(z) = epsilon(z) - z E / K, of period 2 K.

    Defined below the paper's eq. (20).

    >>> from sympy import symbols
    >>> z, m = symbols("z m")
    >>> jacobi_zeta(z, m).diff(z)
    -elliptic_e(m)/elliptic_k(m) + jacobi_dn(z, m)**2
    """

    parity = -1
    latex_symbol = r"\mathrm{Z}"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return S.Zero

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr:
        return tanh(z)

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return jacobi_dn(z, m) ** 2 - elliptic_e(m) / elliptic_k(m)


class _ThetaFunction(_RealBelowOne):
    """H and Theta: no elementary value at m = 1, where the nome is 1."""

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> None:
        return None


class jacobi_eta(_ThetaFunction):
    """Jacobi's H(z | m) = theta_1(pi z / (2 K), q), the paper's eq. (20)."""

    parity = -1
    latex_symbol = "H"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return S.Zero

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        factor = sqrt(sqrt(m)) * jacobi_cn(z, m) * jacobi_dn(z, m)
        return self * jacobi_zeta(z, m) + factor * jacobi_theta(z, m)


class jacobi_theta(_ThetaFunction):
    """Jacobi's Theta(z | m) = theta_4(pi z / (2 K), q), the paper's eq. (20).

    Theta(0) is left as it is.

    >>> from sympy import symbols
    >>> z, m = symbols("z m")
    >>> jacobi_theta(-z, m).diff(z)
    jacobi_theta(z, m)*jacobi_zeta(z, m)
    """

    parity = 1
    latex_symbol = r"\Theta"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return S.One

    @classmethod
    def _at_origin(cls, m: Expr) -> None:
        return None

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return self * jacobi_zeta(z, m)
