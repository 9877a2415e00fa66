"""The spectrum of the strain."""

from collections.abc import Mapping

import numpy as np

from verify.lattice.observables.entry import Array, View


def spectrum(view: View) -> Mapping[str, Array]:
    """Amplitudes of the strain on the compared sites, by wavenumber in 0 .. pi."""
    return {"spectrum": amplitudes(view.numeric)}


def amplitudes(values: Array) -> Array:
    """Hann-windowed Fourier amplitudes of ``values`` less their mean.

    Scaled so that a cos(k n) with k on the grid has the amplitude a there. The window keeps the
    jump between the two ends from covering the tail: its leakage falls like 1/k^3.

    >>> n = np.arange(64)
    >>> float(np.round(amplitudes(3.0 * np.cos(2.0 * np.pi * 8.0 * n / 64.0))[8], 12))
    3.0
    """
    count = values.size
    window = 1.0 - np.cos(2.0 * np.pi * np.arange(count) / count)
    modes = np.fft.rfft((values - np.mean(values)) * window)
    found: Array = 2.0 * np.abs(modes) / count
    return found
