"""sn, cn, dn, Jacobi's epsilon and zeta, H and Theta as SymPy functions of (z, m).

Convention: SymPy, mpmath and SciPy take the parameter `m`; the papers take the modulus `k`, with
`m = k**2`.  LaTeX prints f(z; k) if m is literally a square k**2, and f(z | m) otherwise.

H(z) = theta_1(pi z / (2 K), q) and Theta(z) = theta_4(pi z / (2 K), q), not normalised, as in the
paper's eqs. (19) and (20), so H = sqrt(k) sn Theta.
"""

from collections.abc import Callable
from typing import Any, ClassVar

from mpmath import MPContext
from sympy import Expr, Function, Pow, S, cos, elliptic_e, elliptic_k, sech, sin, sqrt, tanh
from sympy.core.function import ArgumentIndexError

from longwave.solutions.functions.multiprecision import IMPLEMENTATIONS

_CONTEXT = MPContext()


class ParameterDerivativeError(ArgumentIndexError):
    """Error for a derivative of a Jacobi function in its parameter m, which is not implemented."""

    def __str__(self) -> str:
        function, argindex = self.args
        return (
            f"argindex of {function} must be 1 (the argument z), got {argindex}"
            " (derivatives in the parameter m are not defined here; keep m constant)"
        )


class JacobiFunction(Function):
    """Base of sn, cn, dn, epsilon, zeta, eta and theta of (z, m), with m = k**2.

    A subclass defines its parity, its LaTeX symbol, and its values at m = 0, m = 1 and z = 0;
    `_DERIVATIVES` has its derivative in z.  `fdiff(2)` raises `ParameterDerivativeError`, which
    `diff` turns into an unevaluated `Derivative`.
    """

    nargs = 2
    parity: ClassVar[int]
    latex_symbol: ClassVar[str]
    at_parameter_zero: ClassVar[Any]
    at_parameter_one: ClassVar[Any]
    at_origin: ClassVar[Expr | None] = S.Zero
    """Value at z = 0; None leaves the function unevaluated there."""

    @classmethod
    def eval(cls, z: Expr, m: Expr) -> Expr | None:
        """Return the elementary value at m = 0, m = 1 and z = 0; extract a minus sign from z."""
        if m.is_zero:
            return cls._value(cls.at_parameter_zero, z)
        if m is S.One:
            return cls._value(cls.at_parameter_one, z)
        if z.is_zero:
            return cls.at_origin
        if z.could_extract_minus_sign():
            return cls.parity * cls(-z, m)
        return None

    @staticmethod
    def _value(limit: Any, z: Expr) -> Expr | None:
        return limit(z) if callable(limit) else limit

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in z. Raises ParameterDerivativeError for one in m."""
        if argindex != 1:
            raise ParameterDerivativeError(self, argindex)
        return _DERIVATIVES[self.func](*self.args)

    def _eval_evalf(self, prec: int) -> Expr | None:
        try:
            z, m = self._mpmath_arguments(prec)
        except ValueError:
            return None
        with _CONTEXT.workprec(prec + 10):
            value = IMPLEMENTATIONS[self.func.__name__](_CONTEXT, z, m)
        return Expr._from_mpmath(value, prec)

    def _mpmath_arguments(self, prec: int) -> list[Any]:
        """Return z and m with extra bits for a large z, a small m and a small 1 - m."""
        z, m = self.args
        coarse = [_CONTEXT.convert(x._to_mpmath(prec + 10)) for x in (z, m, 1 - m)]
        sizes = [_CONTEXT.mag(x) if x else 0 for x in coarse]
        extra = 20 + max(0, sizes[0]) + max(0, -sizes[1]) + max(0, -sizes[2])
        return [_CONTEXT.convert(x._to_mpmath(prec + extra)) for x in (z, m)]

    def _eval_conjugate(self) -> Expr:
        z, m = self.args
        return self.func(z.conjugate(), m.conjugate())

    def _eval_is_finite(self) -> bool | None:
        return self._eval_is_extended_real()

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        z, m = self.args
        power = "" if exp is None else f"^{{{exp}}}"
        if isinstance(m, Pow) and m.exp == 2:
            second = f"; {printer._print(m.base)}"
        else:
            second = rf" \mid {printer._print(m)}"
        return rf"{self.latex_symbol}{power}\left({printer._print(z)}{second}\right)"

    def _numpycode(self, printer: Any) -> str:
        module = "longwave.solutions.functions.numpy_values"
        name = printer._module_format(f"{module}.{self.func.__name__}")
        return f"{name}({', '.join(printer._print(x) for x in self.args)})"


class _RealOnTheLine(JacobiFunction):
    """Base of the functions that are real for every real z and every real m."""

    def _eval_is_extended_real(self) -> bool | None:
        z, m = self.args
        return True if z.is_real and m.is_real else None


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
    at_parameter_zero, at_parameter_one = sin, tanh


class jacobi_cn(_RealOnTheLine):
    """Jacobi's cn(z | m), m = k**2."""

    parity = 1
    latex_symbol = r"\operatorname{cn}"
    at_parameter_zero, at_parameter_one = cos, sech
    at_origin = S.One


class jacobi_dn(_RealOnTheLine):
    """Jacobi's dn(z | m), m = k**2.

    >>> from sympy import symbols
    >>> z, m = symbols("z m")
    >>> jacobi_dn(z, m).diff(z)
    -m*jacobi_cn(z, m)*jacobi_sn(z, m)
    """

    parity = 1
    latex_symbol = r"\operatorname{dn}"
    at_parameter_zero, at_parameter_one = S.One, sech
    at_origin = S.One


class jacobi_epsilon(_RealOnTheLine):
    """Jacobi's epsilon: the integral of dn(s | m)**2 over s from 0 to z (E of the amplitude)."""

    parity = -1
    latex_symbol = r"\mathcal{E}"
    at_parameter_zero, at_parameter_one = S.IdentityFunction, tanh


class _RealBelowOne(JacobiFunction):
    """Base of the functions that are real for real z and 0 <= m < 1."""

    def _eval_is_extended_real(self) -> bool | None:
        z, m = self.args
        return True if z.is_real and m.is_nonnegative and (1 - m).is_positive else None


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
    at_parameter_zero, at_parameter_one = S.Zero, tanh


class jacobi_eta(_RealBelowOne):
    """Jacobi's H(z | m) = theta_1(pi z / (2 K), q), the paper's eq. (20)."""

    parity = -1
    latex_symbol = "H"
    at_parameter_zero, at_parameter_one = S.Zero, None


class jacobi_theta(_RealBelowOne):
    """Jacobi's Theta(z | m) = theta_4(pi z / (2 K), q), the paper's eq. (20).

    Theta(0) is left unevaluated.

    >>> from sympy import symbols
    >>> z, m = symbols("z m")
    >>> jacobi_theta(-z, m).diff(z)
    jacobi_theta(z, m)*jacobi_zeta(z, m)
    """

    parity = 1
    latex_symbol = r"\Theta"
    at_parameter_zero, at_parameter_one = S.One, None
    at_origin = None


_DERIVATIVES: dict[type[JacobiFunction], Callable[[Expr, Expr], Expr]] = {
    jacobi_sn: lambda z, m: jacobi_cn(z, m) * jacobi_dn(z, m),
    jacobi_cn: lambda z, m: -jacobi_sn(z, m) * jacobi_dn(z, m),
    jacobi_dn: lambda z, m: -m * jacobi_sn(z, m) * jacobi_cn(z, m),
    jacobi_epsilon: lambda z, m: jacobi_dn(z, m) ** 2,
    jacobi_zeta: lambda z, m: jacobi_dn(z, m) ** 2 - elliptic_e(m) / elliptic_k(m),
    jacobi_eta: lambda z, m: (
        jacobi_eta(z, m) * jacobi_zeta(z, m)
        + sqrt(sqrt(m)) * jacobi_cn(z, m) * jacobi_dn(z, m) * jacobi_theta(z, m)
    ),
    jacobi_theta: lambda z, m: jacobi_theta(z, m) * jacobi_zeta(z, m),
}
"""Function -> its derivative in z, as a function of z and m."""
