"""Strain and velocity on a ring of real circumference at one time, sampled.

Such a ring holds one lattice for each x mod 1, and they do not feel each other.
A wave that is hardly longer than the distance of sites has, by the place of its crest between two
sites, a little more or less energy, which each of the lattices keeps for ever: its waves are a
little larger and faster. In the frame of the wave such a difference turns its phase once a site
(the wave numbers near 2 pi). Steps that do not resolve that average it, whatever their length, and
all waves run alike: a run with a shorter step does not show it. `energy_spread` does.
"""

import math
from dataclasses import dataclass

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.model import Model

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

TAIL = 8
"""The spectrum's tail is its last 1/TAIL."""


def forward(values: Array) -> Complex:
    """Fourier coefficients 0 .. M/2 of a real periodic function, divided by M."""
    modes: Complex = ducc0.fft.r2c(values, inorm=2, nthreads=1)
    return modes


def backward(modes: Complex, count: int, out: Array | None = None) -> Array:
    """The real function with the coefficients ``modes`` at ``count`` points."""
    values: Array = ducc0.fft.c2r(modes, lastsize=count, forward=False, out=out, nthreads=1)
    return values


@dataclass(frozen=True)
class RingState:
    """Samples of strain and velocity at x = left + j L/M, j = 0 .. M - 1, at time ``t``."""

    t: float
    left: float
    circumference: float
    y: Array
    s: Array

    @property
    def points(self) -> Array:
        """The sample points."""
        steps = np.arange(self.y.size, dtype=np.float64)
        points: Array = self.left + self.circumference / self.y.size * steps
        return points

    def strain(self, x: ArrayLike) -> Array:
        """Strain at any real positions (trigonometric interpolation to 1e-12)."""
        return self._at(self.y, x)

    def velocity(self, x: ArrayLike) -> Array:
        """Velocity at any real positions."""
        return self._at(self.s, x)

    def tail(self) -> float:
        """Sum of the moduli in the last 1/TAIL of the strain's spectrum.

        It bounds what these modes add to the strain anywhere. What a finer sampling would resolve
        beyond them is smaller, for spectra that fall.
        """
        return spectrum_tail(forward(self.y))

    def _at(self, samples: Array, x: ArrayLike) -> Array:
        modes = forward(samples)
        modes[1 : (samples.size + 1) // 2] *= 2.0
        phase = (2.0 * math.pi / self.circumference) * (np.asarray(x, dtype=np.float64) - self.left)
        grid = np.concatenate([np.zeros(modes.size - 1), modes]).astype(np.complex128)
        values = ducc0.nufft.u2nu(
            grid=grid[:-1] if grid.size % 2 else grid,
            coord=np.mod(phase, 2.0 * math.pi)[:, None],
            forward=False,
            epsilon=1e-12,
            periodicity=2.0 * math.pi,
        )
        real: Array = np.ascontiguousarray(values.real, dtype=np.float64)
        return real

    def resampled(self, count: int) -> "RingState":
        """The same function at ``count`` points."""
        y, s = (_resample(values, count) for values in (self.y, self.s))
        return RingState(self.t, self.left, self.circumference, y, s)


def spectrum_tail(modes: Complex) -> float:
    """Twice the sum of the moduli in the last 1/TAIL of a real function's coefficients."""
    return 2.0 * float(np.sum(np.abs(modes[-(modes.size // TAIL) :])))


def _resample(values: Array, count: int) -> Array:
    modes = np.zeros(count // 2 + 1, dtype=np.complex128)
    source = forward(values)
    kept = min(modes.size, source.size) - 1
    modes[:kept] = source[:kept]
    return backward(modes, count)


DENSITY = 4.5
"""Points per site that hold the energy's waves of numbers near 2 pi: 2 for the strain, as many
again for the cubic part of the force, and some."""

CREST_REACH = 4.0
"""Sites over which the energy of a crest is summed: the waves that matter are no longer."""

TURNED = 1.0
"""Longest step, in units of the time in which a wave of number 2 pi turns by one radian, that shows
how the lattices differ."""

ALIKE = 0.2
"""Share of the tolerance that they may differ by, unshown. Over a time in which the nonlinear part
turns the phase of a typical wave by one, their strains part by 0.02 to 0.4 times the spread of
their energies, in units of the largest strain: measured on 30 scenes of all waves, a |y| from 0.3
to 0.63, as `searches/estimates.py` draws them."""

SEAM = 6.0
"""Distance from the seam, in units of CREST_REACH, at which it is not felt."""


def telling_step(speed: float) -> float:
    """The longest step that shows how the lattices of a ring differ that moves at ``speed``."""
    return TURNED / (2.0 * math.pi * speed)


def energy_spread(model: Model, state: RingState, seam: float) -> float:
    """By how much the energies of a crest differ between the lattices of a ring, relatively.

    ``state`` needs ``DENSITY`` points a site; it is not the wave's within ``seam`` of its ends.

    >>> def spread(width):
    ...     x = 120.0 * (np.arange(600) / 600 - 0.5)
    ...     y = 1.0 / np.cosh(x / width)
    ...     state = RingState(0.0, -60.0, 120.0, y, y * np.tanh(x / width) / width)
    ...     return energy_spread(Model(1.0, 0.0, 1.0), state, 1.0)
    >>> [f"{spread(width):.0e}" for width in (1.5, 2.0, 3.0)]
    ['2e-04', '3e-06', '7e-10']
    """
    count, length = state.y.size, state.circumference
    k = (2.0 * math.pi / length) * np.arange(count // 2 + 1, dtype=np.float64)
    strain = state.y - float(np.mean(state.y))
    modes = forward(_energy(model, state, strain, k))
    near = np.zeros(count, dtype=np.complex128)
    near[: k.size] = 2.0 * modes * np.exp(-0.5 * (CREST_REACH * (k - 2.0 * math.pi)) ** 2)
    harmonic = np.abs(np.fft.ifft(near, norm="forward"))
    whole = forward(model.K2 * strain**2) * np.exp(-0.5 * (CREST_REACH * k) ** 2)
    largest = float(np.max(backward(whole, count)))
    place = np.abs(np.arange(count) / count - 0.5) * length
    inside = place < 0.5 * length - seam - SEAM * CREST_REACH
    if not largest > 0.0 or not np.any(inside):
        return 0.0
    return float(np.max(harmonic[inside])) / largest


def _energy(model: Model, state: RingState, strain: Array, k: Array) -> Array:
    """The energy of each site beyond that of the mean strain, whose linear part is conserved."""
    mean = float(np.mean(state.y))
    lift = 2.0 * np.sin(0.5 * k)
    inverse = np.zeros_like(k)
    np.divide(1.0, lift, out=inverse, where=(k > 0.0) & (k < math.pi))
    beyond = k >= math.pi
    inverse[beyond] = lift[beyond] / (lift[beyond] ** 2 + CREST_REACH**-2)
    velocity = backward(-1j * inverse * forward(state.s), state.y.size)
    K3, K4 = model.K3, model.K4
    quadratic = 0.5 * (model.K2 + 2.0 * K3 * mean + 3.0 * K4 * mean**2)
    potential = quadratic + strain * ((K3 + 3.0 * K4 * mean) / 3.0 + 0.25 * K4 * strain)
    return potential * strain**2 + 0.5 * velocity**2
