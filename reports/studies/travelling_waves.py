"""Periodic travelling waves of the lattice itself, and their linear (Floquet) stability.

y_n(t) = f(n - v t) with f of period P sites solves  v^2 f''(x) = D V'(f)(x),  in Fourier modes
q = 2 pi j / P

    v^2 q^2 f_q = 4 sin^2(q/2) V'(f)_q.

The mean and the first mode are those of the wave of the reduced equation; v and the other modes
follow by Newton's method. The waves are even.

A perturbation e^{lambda t} W(x), x = n - v t, of that wave obeys

    (lambda - v d/dx)^2 W = D[ V''(f) W ],    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P}.

Truncated in j it is a matrix (Hill's method); no time step and no lattice run enters (Deconinck,
Kutz, J. Comput. Phys. 219 (2006) 296).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from longwave.derive import mkdv_normal_form
from longwave.lattice.model import Model
from longwave.scenes.starts.background_growth import multiplication
from longwave.solutions import Wave, closed_form

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MODES = 24
"""Number of the highest Fourier mode of a wave's profile."""

NEWTON_STEPS = 12

OVERSAMPLING = 8
"""Samples per mode for products, enough that V' (cubic) and V'' (quadratic) are not aliased."""


@dataclass(frozen=True)
class TravellingWave:
    """An even profile with cosine modes ``modes`` (0 .. MODES), speed and period in sites."""

    constants: Model
    modes: Array
    speed: float
    period: int
    eps: float

    @cached_property
    def _wavenumbers(self) -> Array:
        return 2.0 * np.pi * np.arange(self.modes.size) / self.period

    def strain(self, x: Array) -> Array:
        """Return the strain f(x)."""
        weights = np.where(np.arange(self.modes.size) == 0, 1.0, 2.0) * self.modes
        waves = np.cos(np.multiply.outer(x, self._wavenumbers))
        return np.asarray(np.sum(waves * weights, axis=-1))

    def velocity(self, x: Array) -> Array:
        """Return the velocity dy_n/dt = -v f'(x)."""
        weights = 2.0 * self.modes * self._wavenumbers
        waves = np.sin(np.multiply.outer(x, self._wavenumbers))
        return np.asarray(self.speed * np.sum(waves * weights, axis=-1))

    def shape_deviation(self, y: Array, t: float) -> tuple[float, float]:
        """Return a ring's root mean square deviation from the best shifted wave, and the shift.

        The shift is fitted by Gauss-Newton; ``y`` are the ring's strains at time ``t``.
        """
        n, shift = np.arange(float(y.size)), 0.0
        for _ in range(4):
            x = n - self.speed * t - shift
            slope = self.velocity(x) / self.speed
            shift += float(slope @ (y - self.strain(x)) / (slope @ slope))
        remainder = y - self.strain(n - self.speed * t - shift)
        return float(np.sqrt(np.mean(remainder**2))), shift


def travelling_wave(form: str, k: float, period: int, K2: float, K4: float) -> TravellingWave:
    """Compute the lattice's own wave next to the bare wave ``form``, with that period in sites.

    eps follows from the period. Raises ValueError if Newton's method does not converge, or if the
    profile needs more modes.

    >>> wave = travelling_wave("wave_dn", 0.5, 27, 1, 1)
    >>> round(wave.eps, 6), round(wave.speed, 8)
    (0.050978, 1.00112504)
    """
    constants = Model(K2, 0.0, K4)
    wave = Wave(closed_form(form), mkdv_normal_form(K2, K4), k=k)
    eps = float(wave.wavelength or math.nan) / period
    guess = _cosine_modes(wave, eps, period)
    modes, squared_speed = guess, constants.sound_speed() ** 2
    for _ in range(NEWTON_STEPS):
        residual, slopes = _linearised(modes, squared_speed, constants, period)
        change = np.linalg.solve(slopes, -residual)
        squared_speed += float(change[0])
        modes = modes + np.concatenate([[0.0, 0.0], change[1:]])
    residual_norm, last_modes = float(np.max(np.abs(residual))), float(np.max(np.abs(modes[-3:])))
    if not (max(residual_norm, last_modes) < 1e-12 and squared_speed > 0.0):
        raise ValueError(
            f"period must give a smooth profile, got {period} with residual {residual_norm:.1e} "
            f"and last modes {last_modes:.1e} (take a longer one)"
        )
    return TravellingWave(constants, modes, math.sqrt(squared_speed), period, eps)


def _cosine_modes(wave: Wave, eps: float, period: int) -> Array:
    """Return the cosine modes of the bare wave, centred on its crest."""
    count = OVERSAMPLING * MODES
    samples = period * np.arange(count) / count
    crest = samples[np.argmax(wave.at(samples, 0.0, eps).Y)]
    modes: Array = np.fft.rfft(eps * wave.at(samples + crest, 0.0, eps).Y).real / count
    return modes[: MODES + 1]


def profile(modes: Array) -> Array:
    """Return the profile of these modes at OVERSAMPLING * MODES even points of a period."""
    count = OVERSAMPLING * MODES
    padded = np.pad(modes, (0, count // 2 + 1 - modes.size))
    return np.fft.irfft(padded, count) * count


def _linearised(
    modes: Array, squared_speed: float, constants: Model, period: int
) -> tuple[Array, Array]:
    """Return v^2 f_q - (sin(q/2)/(q/2))^2 V'(f)_q for the modes 1 .. MODES, and its Jacobian.

    The unknowns are v^2 and the modes 2 .. MODES. The product with V''(f) couples the modes i and j
    of an even function through those of V'' at i - j and i + j.
    """
    j = np.arange(1, MODES + 1)
    q = 2.0 * np.pi * j / period
    symbol = (np.sin(0.5 * q) / (0.5 * q)) ** 2
    y = profile(modes)
    force = np.fft.rfft(y * (constants.K2 + constants.K4 * y * y)).real / y.size
    stiffness = np.fft.rfft(constants.stiffness(y)).real / y.size
    coupling = stiffness[np.abs(np.subtract.outer(j, j))] + stiffness[np.add.outer(j, j)]
    slopes = squared_speed * np.eye(MODES) - symbol[:, None] * coupling
    slopes[:, 0] = modes[1:]
    return squared_speed * modes[1:] - symbol * force[j], slopes


@dataclass(frozen=True)
class Mode:
    """A linear mode: eigenvalue ``rate`` (complex, per lattice time) at Bloch wavenumber ``kappa``.

    ``strain`` and ``velocity`` are its Fourier coefficients at the wavenumbers ``q``.
    """

    rate: complex
    kappa: float
    q: Array
    strain: Complex
    velocity: Complex

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the real parts of strain and velocity at x, scaled to a largest strain of 1."""
        waves = np.exp(1j * np.multiply.outer(x, self.q))
        y, s = waves @ self.strain, waves @ self.velocity
        scale = complex(y[np.argmax(np.abs(y))])
        return (y / scale).real, (s / scale).real


def lattice_mode(wave: TravellingWave, kappa: float) -> Mode:
    """Return the fastest growing perturbation of the wave with the Bloch wavenumber kappa.

    On the sites, W and W e^{2 pi i x} are the same perturbation. Of these copies the one with its
    mean wavenumber in -pi .. pi is returned, which the truncation does not cut.
    """
    q, matrix = _lattice_problem(wave, kappa)
    rates, vectors = np.linalg.eig(matrix)
    weights = np.abs(vectors[: q.size]) ** 2
    central = np.abs(q @ weights) <= np.pi * weights.sum(axis=0)
    best = int(np.argmax(np.where(central, rates.real, -np.inf)))
    strain, velocity = np.split(vectors[:, best], 2)
    return Mode(complex(rates[best]), kappa, q, strain, velocity)


def fastest_mode(wave: TravellingWave, wavelengths: int) -> Mode:
    """Return the fastest growing perturbation on a ring of that many wavelengths.

    Bloch wavenumbers above pi / P are skipped: they repeat those below as complex conjugates.
    """
    spacing = 2.0 * math.pi / (wavelengths * wave.period)
    kappas = [spacing * count for count in range(wavelengths // 2 + 1)]
    rates = [np.max(np.linalg.eigvals(_lattice_problem(wave, k)[1]).real) for k in kappas]
    return lattice_mode(wave, kappas[int(np.argmax(rates))])


def _lattice_problem(wave: TravellingWave, kappa: float) -> tuple[Array, Complex]:
    """Return the wavenumbers q, and the matrix of (W, (lambda - v d/dx) W) in Fourier modes."""
    j = np.arange(-MODES, MODES + 1)
    q = kappa + 2.0 * np.pi * j / wave.period
    coupling = multiplication(wave.constants.stiffness(profile(wave.modes)), j)
    drift = np.diag(1j * wave.speed * q)
    force = -4.0 * np.sin(0.5 * q)[:, None] ** 2 * coupling
    return q, np.block([[drift, np.eye(j.size)], [force, drift]])
