"""Double or double-double: which arithmetic a wave needs, and why."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import sympy as sp

__all__ = ["PRECISIONS", "HardRange", "Precision", "check_precision"]

Precision = Literal["double", "double-double"]
PRECISIONS: tuple[Precision, ...] = ("double", "double-double")

COMPARISON_DIGITS = 40


@dataclass(frozen=True)
class HardRange:
    """Where double precision loses the 1e-13 promised: a condition on the parameters.

    >>> k = sp.Symbol("k")
    >>> hard = HardRange(k > sp.Rational(9, 10), "the denominator is of order 1 - k**2")
    >>> hard.precision({k: sp.Rational(1, 2)}), hard.precision({k: sp.Rational(99, 100)})
    ('double', 'double-double')
    """

    condition: sp.Basic
    reason: str

    def precision(self, parameters: Mapping[sp.Symbol, sp.Expr]) -> Precision:
        """The arithmetic needed at these exact parameter values."""
        numbers = {symbol: sp.N(value, COMPARISON_DIGITS) for symbol, value in parameters.items()}
        return "double-double" if self.condition.subs(numbers) == sp.true else "double"


def check_precision(precision: object) -> Precision:
    """``precision`` if it is one; a ValueError names both if it is not."""
    for known in PRECISIONS:
        if precision == known:
            return known
    raise ValueError(
        f"precision must be 'double' or 'double-double', got {precision!r} "
        "(leave it out to have what the wave needs)"
    )
