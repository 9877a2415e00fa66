"""What the Jacobi functions of (z, m) have in common as SymPy functions.

Convention: SymPy, mpmath and SciPy take the parameter `m`; the papers take the modulus `k`, with
`m = k**2`.  LaTeX prints f(z; k) where m is literally a square k**2 and f(z | m) otherwise.
"""

from __future__ import annotations

from typing import Any, ClassVar

from mpmath import MPContext
from sympy import Expr, Function, Pow, S
from sympy.core.function import ArgumentIndexError

from solutions.special.mp import IMPLEMENTATIONS

_CONTEXT = MPContext()


class ParameterDerivativeError(ArgumentIndexError):
    """The derivative of a Jacobi function with respect to its parameter m was asked for."""

    def __init__(self, function: Function, argindex: int) -> None:
        super().__init__(function, argindex)

    def __str__(self) -> str:
        function, argindex = self.args
        return (
            f"argindex of {function} must be 1 (the argument z), got {argindex}"
            " (derivatives in the parameter m are not defined here; keep m constant)"
        )


class JacobiFunction(Function):
    """Base of sn, cn, dn, epsilon, zeta, eta and theta of (z, m), with m = k**2.

    A subclass says its parity, its LaTeX symbol and its derivative, and its values at m = 0,
    m = 1 and z = 0.  Derivatives are with respect to z; `fdiff(2)` raises
    `ParameterDerivativeError`, which `diff` turns into an unevaluated `Derivative`.
    """

    nargs = 2
    parity: ClassVar[int]
    latex_symbol: ClassVar[str]

    @classmethod
    def eval(cls, z: Expr, m: Expr) -> Expr | None:
        """Return the elementary value at m = 0, m = 1 and z = 0, and move a sign out of z."""
        if m.is_zero:
            return cls._at_parameter_zero(z)
        if m is S.One:
            return cls._at_parameter_one(z)
        if z.is_zero:
            return cls._at_origin(m)
        if z.could_extract_minus_sign():
            return cls.parity * cls(-z, m)
        return None

    @classmethod
    def _at_parameter_zero(cls, z: Expr) -> Expr:
        raise NotImplementedError

    @classmethod
    def _at_parameter_one(cls, z: Expr) -> Expr | None:
        raise NotImplementedError

    @classmethod
    def _at_origin(cls, m: Expr) -> Expr | None:
        return S.Zero

    def _z_derivative(self, z: Expr, m: Expr) -> Expr:
        raise NotImplementedError

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in z.

        Raises:
            ParameterDerivativeError: for `argindex` other than 1.
        """
        if argindex != 1:
            raise ParameterDerivativeError(self, argindex)
        return self._z_derivative(*self.args)

    def _eval_evalf(self, prec: int) -> Expr | None:
        try:
            z, m = self._mpmath_arguments(prec)
        except ValueError:
            return None
        with _CONTEXT.workprec(prec + 10):
            value = IMPLEMENTATIONS[self.func.__name__](_CONTEXT, z, m)
        return Expr._from_mpmath(value, prec)

    def _mpmath_arguments(self, prec: int) -> list[Any]:
        """Return z and m with bits added for a large z, a small m and a small 1 - m."""
        z, m = self.args
        context = _CONTEXT
        coarse = [context.convert(x._to_mpmath(prec + 10)) for x in (z, m, 1 - m)]
        sizes = [context.mag(x) if x else 0 for x in coarse]
        extra = 20 + max(0, sizes[0]) + max(0, -sizes[1]) + max(0, -sizes[2])
        return [context.convert(x._to_mpmath(prec + extra)) for x in (z, m)]

    def _eval_conjugate(self) -> Expr:
        z, m = self.args
        return self.func(z.conjugate(), m.conjugate())

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        z, m = self.args
        power = "" if exp is None else f"^{{{exp}}}"
        if isinstance(m, Pow) and m.exp == 2:
            second = f"; {printer._print(m.base)}"
        else:
            second = rf" \mid {printer._print(m)}"
        return rf"{self.latex_symbol}{power}\left({printer._print(z)}{second}\right)"

    def _numpycode(self, printer: Any) -> str:
        name = printer._module_format(f"solutions.special.numpy_functions.{self.func.__name__}")
        return f"{name}({', '.join(printer._print(x) for x in self.args)})"
