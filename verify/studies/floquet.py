"""Linear (Floquet) stability of the lattice's travelling waves: Hill's method.

A perturbation e^{lambda t} W(x), x = n - v t, of the lattice's wave f obeys

    (lambda - v d/dx)^2 W = D[ V''(f) W ],    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P}.

Truncated in j it is a matrix; no time step and no lattice run enters (Deconinck, Kutz,
J. Comput. Phys. 219 (2006) 296).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verify.comparison.hill import multiplication
from verify.studies.travelling import MODES, TravellingWave, profile

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


def _lattice_problem(wave: TravellingWave, kappa: float) -> tuple[Array, Complex]:
    """Wavenumbers q, and the matrix of (W, (lambda - v d/dx) W) in their Fourier modes."""
    j = np.arange(-MODES, MODES + 1)
    q = kappa + 2.0 * np.pi * j / wave.period
    coupling = multiplication(wave.constants.stiffness(profile(wave.modes)), j)
    drift = np.diag(1j * wave.speed * q)
    bend = -4.0 * np.sin(0.5 * q)[:, None] ** 2 * coupling
    return q, np.block([[drift, np.eye(j.size)], [bend, drift]])
