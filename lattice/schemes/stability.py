"""The linear stability limit of a scheme, computed from its table."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from lattice.model import Constants
from lattice.schemes.scheme import Scheme

Array = NDArray[np.float64]

SCAN = np.linspace(0.0, 8.0, 80_001)[1:]
TOLERANCE = 1e-12


def _stable(scheme: Scheme, z: Array) -> NDArray[np.bool_]:
    """Whether both eigenvalues of the step of y'' = -y stay in the unit disc (Jury's test)."""
    step = scheme.oscillator(z)
    trace = step[:, 0, 0] + step[:, 1, 1]
    determinant = step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]
    inside: NDArray[np.bool_] = (np.abs(trace) <= 1.0 + determinant + TOLERANCE) & (
        determinant <= 1.0 + TOLERANCE
    )
    return inside


@cache
def stability_limit(scheme: Scheme) -> float:
    """Largest z = omega h below which y'' = -omega^2 y stays bounded.

    Scanned in steps of 1e-4 up to 8, then refined by bisection.

    >>> from lattice.schemes.catalogue import scheme_named
    >>> round(stability_limit(scheme_named("stoermer_verlet")), 6)
    2.0
    >>> round(stability_limit(scheme_named("rk4")) ** 2, 6)
    8.0
    """
    unstable = np.flatnonzero(~_stable(scheme, SCAN))
    if unstable.size == 0:
        return float(SCAN[-1])
    high = float(SCAN[unstable[0]])
    low = high - float(SCAN[0])
    for _ in range(40):
        middle = 0.5 * (low + high)
        if _stable(scheme, np.array([middle]))[0]:
            low = middle
        else:
            high = middle
    return low


def check_step(step: float, scheme: Scheme, constants: Constants, strain: Array) -> float:
    """The largest stable step (time units) for waves about any of the given strains.

    Raises ValueError if ``step`` is past it.
    """
    limit = stability_limit(scheme) / constants.highest_frequency(strain)
    if step > limit:
        raise ValueError(
            f"step must satisfy step <= {limit:.7g}, got {step:.9g} "
            f"(linear stability limit of {scheme.name} at the zone boundary k = pi; "
            "take a smaller step)"
        )
    return limit
