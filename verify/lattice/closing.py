"""Closing a ring by its circumference.

A localised wave on a periodic background approaches its far field through a phase that decays like
1/x, so the data at the two ends of m wavelengths miss each other by O(1/m). The circumference of a
spectral ring is any real number: the one for which Y(x + L) = Y(x) across the seam in the sense of
least squares leaves a miss of the second order, and the effect of the domain falls like L^-4
instead of L^-2.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

SAMPLES = 64
"""Points on the wavelength about the seam."""


def close_circumference(profile: Callable[[Array], Array], wavelength: float, count: int) -> float:
    """The circumference near ``count`` wavelengths for which the profile closes up.

    ``profile`` is Y against x, centred on the crest; the seam lies at x = -L/2 and x = L/2.

    >>> round(close_circumference(lambda x: np.cos(x - np.arctan(x)), 2 * np.pi, 8), 4)
    52.7884
    """
    whole = count * wavelength
    offsets = wavelength * ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5)

    def miss(shift: Array) -> Array:
        half = 0.5 * (whole + wavelength * shift[0])
        return np.asarray(profile(half + offsets) - profile(-half + offsets))

    starts = (-0.25, 0.0, 0.25)
    fits = [least_squares(miss, [start], xtol=1e-14, ftol=1e-14) for start in starts]
    best = min(fits, key=lambda fit: (round(float(fit.cost), 12), abs(float(fit.x[0]))))
    return whole + wavelength * float(best.x[0])
