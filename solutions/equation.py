"""Equations that closed forms solve, in normal form: one record for each choice of signs."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from longwave.derive.algebra.exact_numbers import instance
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.solutions.symbols import s, tau, xi, zeta
from longwave.support.user_files import shown


class _LeftSide(NamedTuple):
    """Left-hand side of a normal form.

    ``terms`` returns the terms in U and its xi derivatives d(1), d(2), ...; ``U_tau``, times i if
    U ``is_complex``, is added to them. If ``has_across``, the sum is differentiated in xi, and
    ``3 s U_zetazeta`` is added.
    ``order`` is the order of the highest xi derivative: slow times are ``T = eps**order t``.
    """

    terms: Callable[..., sp.Expr]
    order: int = 3
    has_across: bool = False
    is_complex: bool = False


_LEFT_SIDES: Mapping[str, _LeftSide] = {
    "KdV": _LeftSide(lambda U, d, s, r: 6 * U * d(1) + d(3)),
    "mKdV": _LeftSide(lambda U, d, s, r: 6 * s * U**2 * d(1) + d(3)),
    "Gardner": _LeftSide(lambda U, d, s, r: 6 * U * d(1) + d(3) + 6 * s * U**2 * d(1)),
    "Kawahara": _LeftSide(lambda U, d, s, r: 6 * U * d(1) + s * d(3) - d(5), 5),
    "modified Kawahara": _LeftSide(lambda U, d, s, r: 6 * r * U**2 * d(1) + s * d(3) - d(5), 5),
    "KdV-Burgers": _LeftSide(lambda U, d, s, r: 6 * U * d(1) + s * d(3) - d(2)),
    "mKdV-Burgers": _LeftSide(lambda U, d, s, r: 6 * r * U**2 * d(1) + s * d(3) - d(2)),
    "KP": _LeftSide(lambda U, d, s, r: 6 * U * d(1) + d(3), has_across=True),
    "NLS": _LeftSide(
        lambda U, d, s, r: d(2) + 2 * s * sp.Abs(U) ** 2 * U, order=2, is_complex=True
    ),
}
"""Name of an equation in `derive.normal_form.NORMAL_EQUATIONS` -> its left-hand side."""


@dataclass(frozen=True)
class Equation:
    """A normal form with its signs; mKdV by default.

    ``normal`` is its name in `derive.normal_form.NORMAL_EQUATIONS`, where it is written out; the
    paper's eq. (1) is mKdV. ``s`` is its sign, or the symbol ``s`` if solutions hold for either;
    ``r`` is the second sign of an equation with two.

    >>> from sympy import tanh
    >>> DEFOCUSING_MKDV.residual(tanh(xi + 2 * tau)).simplify()
    0
    """

    name: str
    s: int | sp.Symbol = 1
    normal: str = "mKdV"
    r: int = 1
    xi: sp.Symbol = xi
    tau: sp.Symbol = tau

    def __post_init__(self) -> None:
        instance("name", self.name, str, "such as 'focusing mKdV'")
        if self.s not in (1, -1, s):
            raise ValueError(f"s must be 1 or -1, got {shown(self.s)} (1 is the focusing equation)")
        if self.r not in (1, -1):
            raise ValueError(f"r must be 1 or -1, got {shown(self.r)} (1 is the focusing equation)")
        if self.normal not in _LEFT_SIDES:
            known = ", ".join(_LEFT_SIDES)
            raise ValueError(f"normal must be an equation, got {shown(self.normal)} ({known})")

    def _repr_latex_(self) -> str:
        equation = NORMAL_EQUATIONS[self.normal].latex
        for letter in "sr":
            value = getattr(self, letter)
            if value in (1, -1):
                sign = "+" if value > 0 else "-"
                equation = re.sub(rf"\+ (\d*) ?{letter} ", rf"{sign} \1 ", equation)
        return rf"$\displaystyle {equation}$".replace("  ", " ")

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """Variables ``xi`` and ``tau``, with ``zeta`` between them if the equation has it."""
        return (xi, zeta, tau) if self.has_across else (xi, tau)

    @property
    def free_sign(self) -> tuple[sp.Symbol, ...]:
        """The symbol ``s`` if either sign is allowed, else empty."""
        return (s,) if self.s == s else ()

    @property
    def has_across(self) -> bool:
        """Whether the equation has a transverse variable, zeta."""
        return _LEFT_SIDES[self.normal].has_across

    @property
    def is_complex(self) -> bool:
        """Whether the unknown is complex."""
        return _LEFT_SIDES[self.normal].is_complex

    @property
    def order(self) -> int:
        """Order of the highest xi derivative; slow times are ``T = eps**order t``."""
        return _LEFT_SIDES[self.normal].order

    def residual(self, U: sp.Expr) -> sp.Expr:
        """Return the left-hand side of the equation at ``U``, unsimplified."""
        terms = _LEFT_SIDES[self.normal].terms(U, lambda n: sp.diff(U, xi, n), self.s, self.r)
        left_side = (sp.I if self.is_complex else 1) * sp.diff(U, tau) + terms
        if not self.has_across:
            return left_side
        return sp.diff(left_side, xi) + 3 * self.s * sp.diff(U, zeta, 2)


FOCUSING_MKDV = Equation("focusing mKdV", +1)
DEFOCUSING_MKDV = Equation("defocusing mKdV", -1)
KDV = Equation("KdV", normal="KdV")
FOCUSING_GARDNER = Equation("focusing Gardner", +1, "Gardner")
DEFOCUSING_GARDNER = Equation("defocusing Gardner", -1, "Gardner")
KAWAHARA = Equation("Kawahara", +1, "Kawahara")
MODIFIED_KAWAHARA = Equation("modified Kawahara", +1, "modified Kawahara", +1)
KDV_BURGERS = Equation("KdV-Burgers", +1, "KdV-Burgers")
MKDV_BURGERS = Equation("mKdV-Burgers", +1, "mKdV-Burgers", -1)
KP = Equation("KP-I and KP-II", s, "KP")
KP_1 = Equation("KP-I", -1, "KP")
NLS = Equation("NLS", s, "NLS")
FOCUSING_NLS = Equation("focusing NLS", +1, "NLS")
DEFOCUSING_NLS = Equation("defocusing NLS", -1, "NLS")
