"""The elliptic functions sn, cn, dn and Jacobi's epsilon as SymPy functions of (z, m)."""

from __future__ import annotations

from sympy import Expr, S, cos, sech, sin, tanh

from solutions.special.function import JacobiFunction


class _RealOnTheLine(JacobiFunction):
    """Functions that are real for every real z and every real m."""

    def _eval_is_extended_real(self) -> bool | None:
        z, m = self.args
        return True if z.is_real and m.is_real else None

    def _eval_is_finite(self) -> bool | None:
        return self._eval_is_extended_real()


class jacobi_sn(_RealOnTheLine):
    r"""Jacobi's sn(z | m), m = k**2.

    >>> from sympy import symbols, latex
    >>> z, k = symbols("z k")
    >>> jacobi_sn(z, k**2).diff(z)
    jacobi_cn(z, k**2)*jacobi_dn(z, k**2)
    >>> print(latex(jacobi_sn(z, k**2) ** 2))
    \operatorname{sn}^{2}\left(z; k\right)
    >>> jacobi_sn(1, 0.25).n(20)
    0.82263557812986235968
    """

    parity = -1
    latex_symbol = r"\operatorname{sn}"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return sin(z)

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr:
        return tanh(z)

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return jacobi_cn(z, m) * jacobi_dn(z, m)


class jacobi_cn(_RealOnTheLine):
    """Jacobi's cn(z | m), m = k**2."""

    parity = 1
    latex_symbol = r"\operatorname{cn}"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return cos(z)

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr:
        return sech(z)

    @classmethod
    def _at_origin(cls, m: Expr) -> Expr:
        return S.One

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return -jacobi_sn(z, m) * jacobi_dn(z, m)


class jacobi_dn(_RealOnTheLine):
    """Jacobi's dn(z | m), m = k**2.

    >>> from sympy import symbols
    >>> z, m = symbols("z m")
    >>> jacobi_dn(z, m).diff(z)
    -m*jacobi_cn(z, m)*jacobi_sn(z, m)
    """

    parity = 1
    latex_symbol = r"\operatorname{dn}"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return S.One

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr:
        return sech(z)

    @classmethod
    def _at_origin(cls, m: Expr) -> Expr:
        return S.One

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return -m * jacobi_sn(z, m) * jacobi_cn(z, m)


class jacobi_epsilon(_RealOnTheLine):
    """Jacobi's epsilon: the integral of dn(s | m)**2 over s from 0 to z (E of the amplitude)."""

    parity = -1
    latex_symbol = r"\mathcal{E}"

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        return z

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr:
        return tanh(z)

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        return jacobi_dn(z, m) ** 2
