"""Linear phases ``p x + q t + r`` in double-double, at arrays of points."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from solutions.jit import njit
from solutions.special.doubledouble import Pair, add, multiply, split

__all__ = ["LinearPhase"]

Array = NDArray[np.float64]


@njit(cache=True, nogil=True)
def _fill(p: Pair, q: Pair, r: Pair, x: Array, t: Array, high: Array, low: Array) -> None:
    for i in range(x.size):
        moving = add(multiply(p, (x[i], 0.0)), multiply(q, (t[i], 0.0)))
        high[i], low[i] = add(moving, r)


class LinearPhase:
    """``p x + q t + r`` with double-double coefficients made from exact or long numbers.

    >>> from fractions import Fraction
    >>> phase = LinearPhase(Fraction(1, 3), Fraction(-1, 3), 0)
    >>> high, low = phase(np.array([1e6]), np.array([1e6]))
    >>> print(high[0], low[0])
    0.0 0.0
    """

    def __init__(self, p: Any, q: Any, r: Any) -> None:
        self._coefficients = (split(p), split(q), split(r))

    def zero(self, t: float) -> float | None:
        """The x at which the phase vanishes at time t, None if it does not depend on x.

        >>> LinearPhase(2, -6, 3).zero(1.0)
        1.5
        """
        (p, _), (q, _), (r, _) = self._coefficients
        return None if p == 0 else -(q * t + r) / p

    def __call__(self, x: Array, t: Array) -> tuple[Array, Array]:
        """High and low part at the points (x, t), two flat arrays of one size."""
        high, low = np.empty_like(x), np.empty_like(x)
        _fill(*self._coefficients, x, t, high, low)
        return high, low
