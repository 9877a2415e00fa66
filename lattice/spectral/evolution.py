"""The strain lattice on a ring of real circumference, by exponential integration in Fourier space.

If y(x, t) is L-periodic in the real variable x and obeys y_tt = D V'(y) with D f(x) = f(x + 1) - 2
f(x) + f(x - 1), then y_n(t) = y(n, t) obeys the lattice equation at every integer n: a ring of any
real circumference L is an exact quasi-periodic solution of the infinite lattice. y is sampled at M
points of spacing L/M; shifts are Fourier multipliers.

In the frame that moves at c the characteristic variables

    p_-+ = s -+ i w y,    p_-+' = i (c k -+ w) p_-+ + N,    w = 2 sqrt(K2 + b) |sin(k/2)|

hold the right- and left-going waves. The linear part about the background, b = mean of V''(y) - K2,
is integrated exactly; N = D (V'(y) - (K2 + b) y) is the rest of the force.

Where w = 0 there is no force: for the mean and, on circumferences that are whole numbers, for
wavenumbers 2 pi m, which are constant on each lattice. There s is constant and y grows linearly:
p_- holds y - s t and p_+ holds s, each carried along with the frame. The entry of mode 0 holds the
time t; the means are stored separately.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.spectral.absorber import ABSORBER_STRENGTH, LeftAbsorber, ShortAbsorber
from longwave.lattice.spectral.exponential import ExponentialAdams
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, spectrum_tails, values_of
from longwave.support.compiled.jit import complexes, doubles, njit
from longwave.support.real_arrays import Array, Complex

if TYPE_CHECKING:
    from longwave.lattice.model import Model
    from longwave.support.checkpoint import Memory

STEPS_PER_CHECK = 16
"""Number of steps between two checks of the spectrum's tail."""

STILL_FREQUENCY = 1e-7
"""Frequency up to which a mode counts as still: it changes in a time t by less than (1e-7 t)^2."""


class SamplingError(ArithmeticError):
    """The spectrum's tail exceeds its bound: the ring needs more points."""


class RunawayError(FloatingPointError):
    """The fields grew without bound before the time ``t``, or a force became undefined."""

    def __init__(self, t: float, message: str = "") -> None:
        super().__init__(message or f"blow-up: the fields grew without bound before t = {t:g}")
        self.t = t


class NotHyperbolicError(RunawayError):
    """Waves do not exist about some strain at time ``t``: K2 + 2 K3 y + 3 K4 y^2 <= 0."""

    def __init__(self, t: float, site: float) -> None:
        text = f"blow-up: a bond is stretched to where waves grow at t = {t:g}, site {round(site)}"
        super().__init__(t, text)


@njit(cache=True, examples=[(complexes(2), doubles(1), complexes(1))], fastmath={"contract"})
def _strain_modes(p: Complex, inverse: Array, out: Complex) -> None:
    """Compute the modes of y = (p_+ - p_-)/(2 i w) into ``out``; ``inverse`` is 1/(2 w)."""
    for k in range(1, p.shape[1]):
        difference = p[1, k] - p[0, k]
        out[k] = complex(difference.imag * inverse[k], -difference.real * inverse[k])


@njit(cache=True, examples=[(doubles(1), 0.0, 0.0, 0.0)], fastmath={"contract"})
def _residual_force(y: Array, b: float, K3: float, K4: float) -> None:
    """Replace y by V'(y) - (K2 + b) y, in place."""
    for i in range(y.size):
        y[i] *= y[i] * (K3 + K4 * y[i]) - b


@njit(cache=True, examples=[(complexes(1), doubles(1))])
def _bend(force: Complex, symbol: Array) -> None:
    """Multiply the force's modes by the symbol of D, in place."""
    for k in range(force.size):
        force[k] *= symbol[k]


class SpectralRing:
    """A strain ring that is advanced in steps of ``step``; `at` returns it at a given time.

    At the start and every ``STEPS_PER_CHECK`` steps the strain is checked. NotHyperbolicError is
    raised when waves do not exist about some strain, SamplingError when the spectrum's tail exceeds
    ``tail``, and RunawayError when the tail exceeds the largest initial strain. ``dealias`` drops
    the upper half of the force's modes (exact for a cubic force); without it the tail bounds the
    aliasing. Left-going waves of wavenumbers below ``absorbed`` are absorbed at the seam, and
    right-going ones of wavenumbers above ``short`` (`ShortAbsorber`), with ``strength``; 0 absorbs
    none. ``strain`` holds the smallest and the largest strain met.
    """

    def __init__(
        self,
        model: Model,
        state: FieldRing,
        step: float,
        tail: float = math.inf,
        dealias: bool = False,
        absorbed: float = 0.0,
        strength: float = ABSORBER_STRENGTH,
        short: float = 0.0,
    ) -> None:
        self._model, self._start, self._bound = model, state, tail
        (count,), (length,) = state.counts, state.circumferences
        k = 2.0 * math.pi / length * np.arange(count // 2 + 1)
        self._amplitude = float(np.max(np.abs(state.f)))
        self.strain = (math.inf, -math.inf)
        stiffness = float(np.mean(self._checked_stiffness(state.f[0], state.t)))
        self._b = stiffness - model.K2
        self._w = 2.0 * math.sqrt(stiffness) * np.abs(np.sin(k / 2.0))
        self._symbol = -4.0 * np.sin(k / 2.0) ** 2
        if dealias:
            self._symbol[k.size // 2 :] = 0.0
        still = self._w <= STILL_FREQUENCY
        self._still_modes = np.flatnonzero(still)[1:]
        self._symbol[still] = 0.0
        self._inverse = np.zeros_like(k)
        np.divide(0.5, self._w, out=self._inverse, where=~still)
        self._modes = np.empty(k.size, dtype=np.complex128)
        self._values = np.empty(count)
        y, s = modes_of(state.f[0]), modes_of(state.v[0])
        self._mean, self._drift = float(y[0].real), float(s[0].real)
        p = np.stack([s - 1j * self._w * y, s + 1j * self._w * y])
        p[:, still] = y[still], s[still]
        p[:, 0] = 0.0
        speed = model.sound_speed()
        turn = np.where(still, 0.0, self._w)
        linear = 1j * np.stack([speed * k - turn, speed * k + turn])
        self._check(p, state.t)
        self.integrator = ExponentialAdams(linear, self._nonlinearity, p, step)
        self._absorber = None
        if absorbed > 0.0:
            self._absorber = LeftAbsorber(state, p, self._w, speed, step, absorbed, strength)
        self._short = None
        if 0.0 < short < min(math.pi, k[-1]):
            turning = np.where(still, 0.0, self._w)
            self._short = ShortAbsorber(state, turning, speed, step, short, strength)

    def at(self, t: float, pause: Callable[[], None] = lambda: None) -> FieldRing:
        """Advance to time ``t``, not before the last one, and return the ring there.

        The ring's points move at c. ``pause`` is called after each check of the tail.
        """
        duration = t - self._start.t
        integrator = self.integrator
        for _ in range(integrator.whole_steps(duration)):
            integrator.step()
            self._absorb()
            if integrator.steps % STEPS_PER_CHECK == 0:
                self._check(integrator.p, self._start.t + integrator.steps * integrator.h)
                pause()
        p = integrator.solution_at(duration)
        self._check(p, t)
        return self._state(p, t)

    def memory(self) -> Memory:
        """Return the data from which `recall` resumes at a pause."""
        level = self._absorber.level if self._absorber else 0.0
        data = {"mean": self._mean, "strain": self.strain, "level": level}
        return data | {"integrator": self.integrator.memory()}

    def recall(self, memory: Memory) -> None:
        """Restore the ring from the `memory` of one with the same arguments."""
        self._mean, self.strain = memory["mean"], memory["strain"]
        if self._absorber:
            self._absorber.level = memory["level"]
        self.integrator.recall(memory["integrator"])

    def _state(self, p: Complex, t: float) -> FieldRing:
        start = self._start
        y = values_of(self._strain(p), self._values.size)
        velocity = 0.5 * (p[0] + p[1])
        velocity[self._still_modes] = p[1, self._still_modes]
        velocity[0] = self._drift
        s = values_of(velocity, self._values.size)
        return FieldRing(t, (self._left(t),), start.circumferences, y[None], s[None])

    def _left(self, t: float) -> float:
        return self._start.left[0] + self._model.sound_speed() * (t - self._start.t)

    def _absorb(self) -> None:
        absorber = self._absorber
        if absorber and absorber.every and self.integrator.steps % absorber.every == 0:
            self._mean += absorber.absorb(self.integrator.p)
        if self._short and self.integrator.steps % self._short.every == 0:
            self._short.absorb(self.integrator.p)

    def _check(self, p: Complex, t: float) -> None:
        """Raise one of the class's errors if the strain or its spectrum is no longer sound."""
        modes = self._strain(p)
        tail = spectrum_tails(modes[None], self._start.counts)
        self._checked_stiffness(values_of(modes, self._values.size, self._values), t)
        if not tail <= self._amplitude:
            raise RunawayError(t)
        if tail > self._bound:
            raise SamplingError(
                f"the spectrum's tail is {tail:.2g} at t = {t:g} (take more points)"
            )

    def _checked_stiffness(self, y: Array, t: float) -> Array:
        """Return the stiffness about the strains ``y``; raise NotHyperbolicError if it is <= 0."""
        with np.errstate(over="ignore", invalid="ignore"):
            stiffness = self._model.stiffness(y)
        least, most = self.strain
        self.strain = min(least, float(np.min(y))), max(most, float(np.max(y)))
        worst = int(np.argmin(stiffness))
        if stiffness[worst] <= 0:
            length = self._start.circumferences[0]
            raise NotHyperbolicError(t, self._left(t) + worst * length / y.size)
        return stiffness

    def _strain(self, p: Complex) -> Complex:
        t, still = p[0, 0].real, self._still_modes
        _strain_modes(p, self._inverse, self._modes)
        self._modes[still] = p[0, still] + t * p[1, still]
        self._modes[0] = self._mean + self._drift * t
        return self._modes

    def _nonlinearity(self, p: Complex) -> Complex:
        y = values_of(self._strain(p), self._values.size, self._values)
        _residual_force(y, self._b, self._model.K3, self._model.K4)
        force = modes_of(y)
        _bend(force, self._symbol)
        force[0] = 1.0
        return force
