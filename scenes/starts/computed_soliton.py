"""Numerical soliton of a reduced equation that has none in closed form.

A wave ``Y = V(X - v T)`` of ``Y_T = F_X``, F = linear terms and one power of Y, has ``(v + l(k)) V
= P(V)`` in Fourier modes, where l comes from the linear terms and P from the power. Petviashvili's
iteration multiplies ``P(V)/(v + l)`` by the power of ``<V, (v + l) V> / <V, P(V)>`` that keeps the
size of V bounded.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import Reduction
from longwave.scenes.starts.damped_soliton import DecayingWave
from longwave.scenes.starts.fourier_interval import FourierInterval
from longwave.scenes.starts.jet_coefficients import with_numbers
from longwave.support.real_arrays import Array

DECAY_EXPONENT = 36.0
"""Exponent of decay: the interval ends where the wave has fallen by exp(-DECAY_EXPONENT)."""

LEAST_DECAY = 1e-6
"""Least decay rate of the flanks of a localised wave, in units of the fastest rate."""

POINTS = 1024
"""Number of points of the Fourier series on the interval of X."""

CONVERGED_CHANGE = 1e-14
"""Change of the modes in one step, relative to the largest mode, below which the iteration ends."""

MAX_ITERATIONS = 1000
"""Maximum number of iterations."""


class ComputedSoliton(DecayingWave):
    """Soliton of given ``speed`` in X/T of a reduction's equation; implements `JetWave`.

    The equation must be a conservation law with one power of Y and even dispersion in its flux.
    Raises ValueError for other equations and for a speed that linear waves have.
    """

    def __init__(self, reduction: Reduction, speed: float) -> None:
        self.speed = speed
        flux = reduction.pde.flow.antiderivative()
        if flux is None:
            raise ValueError(
                f"the reduced equation must be a conservation law, got {reduction.pde.text()} "
                "(take another wave)"
            )
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
        """Return the interval of X; its length follows from the wave's slowest decay."""
        orders = range(max(linear), -1, -1)
        roots = np.roots([linear.get(n, 0.0) + self.speed * (n == 0) for n in orders])
        slowest = float(np.min(np.abs(roots.real)))
        if slowest < LEAST_DECAY * float(np.max(np.abs(roots))):
            raise ValueError(
                f"speed must not be that of a linear wave, got {self.speed} (take another sign)"
            )
        return -DECAY_EXPONENT / slowest, DECAY_EXPONENT / slowest

    def _iterated(self) -> NDArray[np.complex128]:
        """Return the modes of the soliton; ValueError if the iteration does not converge."""
        space, degree = self._space, self._degree
        width = space.length / DECAY_EXPONENT / 2.0
        V = space.modes(np.exp(-((space.X / width) ** 2)))
        for _ in range(MAX_ITERATIONS):
            force = space.modes(-self._factor * space.values(V) ** degree)
            ratio = float(np.vdot(V, self._inertia * V).real / np.vdot(V, force).real)
            sign = np.sign(ratio) if degree % 2 == 0 else 1.0
            if ratio < 0.0 and degree % 2:
                raise ValueError(
                    f"the nonlinearity must focus at speed {self.speed}, got the other sign "
                    "(change the sign of the speed)"
                )
            V, before = sign * abs(ratio) ** (degree / (degree - 1)) * force / self._inertia, V
            if float(np.max(np.abs(V - before)) / np.max(np.abs(V))) < CONVERGED_CHANGE:
                return V
        raise ValueError(
            f"speed must be one at which the iteration converges, got {self.speed} (try another)"
        )

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Return Y and its X-derivatives up to order ``highest``, (highest + 1, *points)."""
        return self._space.jets(self._modes, np.asarray(X) - self.speed * T, highest)

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """Return W with ``W_X = Y``."""
        return self._space.antiderivative(self._modes, np.asarray(X) - self.speed * T)
