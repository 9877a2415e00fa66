"""How a closed form's variables depend on the caller's, in numbers of many digits."""

from typing import Any

import sympy as sp

from solutions.linear_phase import LinearPhase
from solutions.program import constant_context

__all__ = ["Variables", "long_number"]


def long_number(exact: sp.Expr) -> Any:
    """An exact SymPy number as an mpf of the constants' precision."""
    return constant_context.mpf(exact._to_mpmath(constant_context.prec))


class Variables:
    """``xi = a x + d t`` and ``tau = b t``."""

    def __init__(self, a: Any, b: Any, d: Any = 0) -> None:
        self.a, self.b, self.d = a, b, d

    def phase(self, p: Any, q: Any, r: Any) -> LinearPhase:
        """``p xi + q tau + r`` in the caller's variables."""
        return LinearPhase(p * self.a, p * self.d + q * self.b, r)
