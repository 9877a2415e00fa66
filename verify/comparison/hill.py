"""Linear (Floquet) stability of periodic travelling mKdV waves: Hill's method.

A perturbation e^{lambda tau} W(xi - V tau) of the wave U0(xi - V tau) obeys, in the normal form,

    lambda W = V W' - W''' - 6 s (U0^2 W)',    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P}.

Truncated in j it is a matrix; no time step enters (Deconinck, Kutz, J. Comput. Phys. 219 (2006)
296).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BLOCH_POINTS = 25
"""Wavenumbers that are tried before the best is refined to a thousandth of the zone's edge."""

LEAST_MODES = 12
MOST_MODES = 96

TAIL = 1e-7
"""Modes of the wave below this share of its largest are left out."""


def fastest_rate(U: Array, wavelength: float, speed: float, s: int) -> float:
    """Largest growth rate (per tau) over all perturbations of the infinite line.

    ``U`` are the wave's samples over one wavelength, several for each mode that counts. NaN if
    those are too many: a train of crests that are very far apart.
    """
    modes = resolving_modes(U)
    if modes > MOST_MODES:
        return float("nan")
    edge = np.pi / wavelength

    def rate(kappa: float) -> float:
        return mkdv_rate(U, wavelength, speed, s, kappa, modes)

    apart = edge / BLOCH_POINTS
    found = {kappa: rate(kappa) for kappa in apart * np.arange(1, BLOCH_POINTS + 1)}
    while apart > 1e-3 * edge:
        best, apart = max(found, key=found.__getitem__), 0.5 * apart
        found |= {kappa: rate(kappa) for kappa in (best - apart, best + apart) if kappa <= edge}
    return max(found.values())


def resolving_modes(U: Array) -> int:
    """How many Fourier modes the perturbations of a wave with samples ``U`` need."""
    sizes = np.abs(np.fft.rfft(U))
    last = int(np.flatnonzero(sizes > TAIL * np.max(sizes))[-1])
    return max(last, LEAST_MODES)


def mkdv_rate(U: Array, wavelength: float, speed: float, s: int, kappa: float, modes: int) -> float:
    """Largest growth rate (per tau) at the Bloch wavenumber kappa, with 2 modes + 1 modes."""
    j = np.arange(-modes, modes + 1)
    q = kappa + 2.0 * np.pi * j / wavelength
    potential = 6.0 * s * multiplication(U * U, j)
    matrix = np.diag(1j * (speed * q + q**3)) - 1j * q[:, None] * potential
    return float(np.max(np.linalg.eigvals(matrix).real))


def multiplication(samples: Array, j: NDArray[np.int64]) -> Complex:
    """The matrix, in the modes j, of multiplication by a periodic function with these samples."""
    modes = np.fft.fft(samples) / samples.size
    found: Complex = modes[np.subtract.outer(j, j) % samples.size]
    return found
