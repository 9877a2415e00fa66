"""The soliton of a reduced equation that has none in closed form.

A wave ``Y = V(X - v T)`` of ``Y_T = F_X``, F = linear terms and one power of Y, has
``(v + l(k)) V = P(V)`` in Fourier's modes.  Petviashvili's iteration multiplies ``P(V)/(v + l)`` by
the power of ``<V, (v + l) V> / <V, P(V)>`` that keeps the size of V from running away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import Reduction
from longwave.lattice.state import Array
from longwave.scenes.starts.fourier_interval import FourierInterval
from longwave.scenes.starts.jet_coefficients import with_numbers
from longwave.solutions import WaveValues

TAIL = 36.0
"""The interval ends where the wave has fallen by exp(-TAIL)."""

RUNNING = 1e-6
"""A tail that falls so slowly, in units of the fastest, is a wave that runs."""

POINTS = 1024
"""Of the interval."""

CONVERGED = 1e-14
"""Change of the modes in a step, in units of the largest."""

MOST_STEPS = 1000


class ComputedSoliton:
    """The soliton of ``Y_T = F_0``, the equation of a reduction with numbers, with one speed in X.

    It has jets and antiderivative as closed forms have.  Raises ValueError for an equation with
    other terms, and for a speed at which waves of some length run.
    """

    constant_background = 0.0

    def __init__(self, reduction: Reduction, speed: float) -> None:
        self.speed = speed
        flux = reduction.pde.flow.antiderivative()
        if flux is None:
            raise ValueError("the reduced equation must be a conservation law, got another")
        terms = with_numbers(flux, reduction.values({}))
        powers = [(value, f) for value, f in terms.terms if f and f[0][1] > 1]
        linear = terms.linear
        if len(powers) != 1 or len(powers[0][1]) != 1 or powers[0][1][0][0] or {*linear} & {1, 3}:
            raise ValueError(
                "the reduced equation must have one power of Y and even dispersion in its flux, "
                f"got {reduction.pde.text()} (solitons of other equations are not computed)"
            )
        (self._factor, ((_, self._degree),)) = powers[0]
        self._space = FourierInterval(self._interval(linear), POINTS)
        k = self._space.k
        self._inertia = speed + sum(value * (1j * k) ** n for n, value in linear.items()).real
        self._modes = self._iterated()

    def _interval(self, linear: dict[int, float]) -> tuple[float, float]:
        """As long as the slowest decay of the tail asks for."""
        highest = max(linear)
        roots = np.roots(
            [linear.get(n, 0.0) + self.speed * (n == 0) for n in range(highest, -1, -1)]
        )
        slowest = float(np.min(np.abs(roots.real)))
        if slowest < RUNNING * float(np.max(np.abs(roots))):
            raise ValueError(
                f"speed must be that of no wave of small amplitude, got {self.speed} (take another "
                "sign)"
            )
        return -TAIL / slowest, TAIL / slowest

    def _iterated(self) -> NDArray[np.complex128]:
        space, degree = self._space, self._degree
        width = space.length / TAIL / 2.0
        V = space.modes(np.exp(-((space.X / width) ** 2)))
        for _ in range(MOST_STEPS):
            force = space.modes(-self._factor * space.values(V) ** degree)
            share = float(np.vdot(V, self._inertia * V).real / np.vdot(V, force).real)
            sign = np.sign(share) if degree % 2 == 0 else 1.0
            if share < 0.0 and degree % 2:
                raise ValueError("the nonlinearity must focus at this speed, got the other sign")
            found = sign * abs(share) ** (degree / (degree - 1)) * force / self._inertia
            change = float(np.max(np.abs(found - V)) / np.max(np.abs(found)))
            V = found
            if change < CONVERGED:
                return V
        raise ValueError(f"speed must be one at which the soliton is found, got {self.speed}")

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Y, Y_X, Y_XX, ...: an array (highest + 1, *points)."""
        return self._space.jets(self._modes, np.asarray(X) - self.speed * T, highest)

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W with ``W_X = Y``."""
        return self._space.antiderivative(self._modes, np.asarray(X) - self.speed * T)

    def background(self, X: ArrayLike, T: float) -> WaveValues:
        """None: the soliton deviates from 0."""
        return WaveValues(*np.zeros((3, *np.shape(X))))
