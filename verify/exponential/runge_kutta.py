"""The exponential Runge-Kutta method ETDRK4 (Cox and Matthews, J. Comput. Phys. 176 (2002) 430)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from verify.exponential.phi import phi_functions

Complex = NDArray[np.complex128]
Nonlinearity = Callable[[Complex], Complex]


class ExponentialRungeKutta:
    """Steps of one length ``h`` for p' = L p + N(p), L diagonal; four evaluations of N a step.

    ``linear`` and p have the shape (branches, modes), N(p) the shape (modes,).
    """

    def __init__(self, linear: Complex, nonlinearity: Nonlinearity, h: float) -> None:
        self._nonlinearity = nonlinearity
        self._half, half_phi = phi_functions(linear * (h / 2), 1)
        self._inner = half_phi * (h / 2)
        self._whole, one, two, three = phi_functions(linear * h, 3)
        self._first = h * (one - 3 * two + 4 * three)
        self._middle = h * (2 * two - 4 * three)
        self._last = h * (4 * three - two)

    def step(self, p: Complex) -> Complex:
        """The solution one step later."""
        n0 = self._nonlinearity(p)
        a = self._half * p + self._inner * n0
        na = self._nonlinearity(a)
        nb = self._nonlinearity(self._half * p + self._inner * na)
        nc = self._nonlinearity(self._half * a + self._inner * (2 * nb - n0))
        return self._whole * p + self._first * n0 + self._middle * (na + nb) + self._last * nc
