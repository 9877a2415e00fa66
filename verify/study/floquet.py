"""Linear (Floquet) stability of travelling waves as a matrix eigenproblem: Hill's method.

A perturbation e^{lambda t} W(x), x = n - v t, of the lattice's wave f obeys

    (lambda - v d/dx)^2 W = D[ V''(f) W ],    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P},

and one of the mKdV wave U0(xi - V tau), in the normal form,

    lambda W = V W' - W''' - 6 s (U0^2 W)'.

Truncated in j, both are matrices; no time step and no lattice run enters (Deconinck, Kutz,
J. Comput. Phys. 219 (2006) 296).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verify.study.travelling import MODES, TravellingWave, profile

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Mode:
    """An eigenvalue ``rate`` (complex, per lattice time) at Bloch wavenumber ``kappa``.

    ``strain`` and ``velocity`` are its Fourier coefficients at the wavenumbers ``q``.
    """

    rate: complex
    kappa: float
    q: Array
    strain: Complex
    velocity: Complex

    def at(self, x: Array) -> tuple[Array, Array]:
        """Real parts of strain and velocity at x, the largest strain being 1."""
        waves = np.exp(1j * np.multiply.outer(x, self.q))
        y, s = waves @ self.strain, waves @ self.velocity
        scale = complex(y[np.argmax(np.abs(y))])
        return (y / scale).real, (s / scale).real


def lattice_mode(wave: TravellingWave, kappa: float) -> Mode:
    """The fastest growing perturbation of the lattice's wave with the Bloch wavenumber kappa.

    On the sites, W and W e^{2 pi i x} are the same perturbation; of such copies the one whose mean
    wavenumber lies in -pi .. pi is taken, which the truncation leaves whole.
    """
    q, matrix = _lattice_problem(wave, kappa)
    rates, vectors = np.linalg.eig(matrix)
    weights = np.abs(vectors[: q.size]) ** 2
    central = np.abs(q @ weights) <= np.pi * weights.sum(axis=0)
    best = int(np.argmax(np.where(central, rates.real, -np.inf)))
    strain, velocity = np.split(vectors[:, best], 2)
    return Mode(complex(rates[best]), kappa, q, strain, velocity)


def fastest_mode(wave: TravellingWave, wavelengths: int) -> Mode:
    """The fastest growing perturbation on a ring of that many wavelengths.

    Bloch wavenumbers above pi / P are left out: they repeat those below as complex conjugates.
    """
    spacing = 2.0 * math.pi / (wavelengths * wave.period)
    kappas = [spacing * count for count in range(wavelengths // 2 + 1)]
    rates = [np.max(np.linalg.eigvals(_lattice_problem(wave, k)[1]).real) for k in kappas]
    return lattice_mode(wave, kappas[int(np.argmax(rates))])


def mkdv_rate(U: Array, wavelength: float, speed: float, s: int, kappa: float) -> float:
    """Largest growth rate (per tau) of the mKdV wave with samples ``U`` over one wavelength."""
    j = np.arange(-MODES, MODES + 1)
    q = kappa + 2.0 * np.pi * j / wavelength
    potential = 6.0 * s * _toeplitz(U * U, j)
    matrix = np.diag(1j * (speed * q + q**3)) - 1j * q[:, None] * potential
    return float(np.max(np.linalg.eigvals(matrix).real))


def horizon(rate: float, tolerance: float, rounding: float) -> float:
    """Time until a perturbation as small as ``rounding`` has grown to ``tolerance`` at ``rate``.

    A run about an unstable wave is trustworthy up to then, however small its step.

    >>> round(horizon(0.001, 1e-4, 1e-16))
    27631
    """
    return math.log(tolerance / rounding) / rate if rate > 0 else math.inf


def _lattice_problem(wave: TravellingWave, kappa: float) -> tuple[Array, Complex]:
    """Wavenumbers q, and the matrix of (W, (lambda - v d/dx) W) in their Fourier modes."""
    j = np.arange(-MODES, MODES + 1)
    q = kappa + 2.0 * np.pi * j / wave.period
    coupling = _toeplitz(wave.constants.stiffness(profile(wave.modes)), j)
    drift = np.diag(1j * wave.speed * q)
    bend = -4.0 * np.sin(0.5 * q)[:, None] ** 2 * coupling
    return q, np.block([[drift, np.eye(j.size)], [bend, drift]])


def _toeplitz(samples: Array, j: NDArray[np.int64]) -> Complex:
    """The matrix of multiplication by a periodic function, by its samples over one period."""
    modes = np.fft.fft(samples) / samples.size
    found: Complex = modes[np.subtract.outer(j, j) % samples.size]
    return found
