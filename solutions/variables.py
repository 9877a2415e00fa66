"""How a closed form's variables depend on the caller's."""

from dataclasses import dataclass
from typing import Any

import sympy as sp

from solutions.linear_phase import LinearPhase
from solutions.program import long_number

__all__ = ["Variables"]


@dataclass(frozen=True)
class Variables:
    """``xi = a x + d t`` and ``tau = b t`` with exact a, b, d."""

    a: sp.Expr
    b: sp.Expr
    d: sp.Expr = sp.S.Zero

    def phase(self, p: Any, q: Any, r: Any) -> LinearPhase:
        """``p xi + q tau + r`` in the caller's variables; p, q, r are long numbers.

        Raises OverflowError for a coefficient out of a double's range.
        """
        a, b, d = (long_number(rate) for rate in (self.a, self.b, self.d))
        return LinearPhase(p * a, p * d + q * b, r)
