"""Spectral solution of an envelope equation, with or without its next order, on a ring in X.

The linear terms are integrated exactly for each Fourier mode, the others by an exponential Adams
method.  The carrier times A is periodic on the ring of cells, so A itself is periodic up to a
constant phase.
"""

from collections.abc import Callable
from functools import partial

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import CarrierFields
from longwave.lattice.spectral.exponential import ExponentialAdams

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LONGEST_TURN = 0.005
"""Step, in units of the time in which the largest initial amplitude shifts the phase by 1 rad. The
Peregrine wave, three times as high at its crest as at its start, is then accurate to 1e-6."""

TIME_ROUNDING = 1e-12
"""Fraction of the start time by which a requested time may be earlier, because of rounding."""

SUM_ERROR = 1e-13
"""Largest error of a nonuniform Fourier sum, relative to its terms."""


class EnvelopeFlow:
    """Solution A(X, T) of ``A_T = G_0 + eps G_1`` on a ring, from ``start(X)`` at time ``T0``.

    ``form`` gives G_0 and G_1.  The ring begins at ``first``, has the given ``length`` and number
    of ``points``, and ``A(X + length) = A(X) exp(i turn)``.  Results at requested times are cached.

    >>> from longwave.derive import LATTICES, envelope
    >>> from longwave.derive.carrier_numbers import carrier_fields
    >>> form = carrier_fields(envelope(LATTICES["fput_strain"]), 1, K2=1, K3=0, K4=1)
    >>> flow = EnvelopeFlow(form, 0.1, np.ones_like, first=0.0, length=1.0, points=8, T0=0.0)
    >>> turned = flow.jets(0.25, 2.0, 0)[0]        # a plane wave: A_T = i q |A|^2 A
    >>> bool(abs(turned - np.exp(-6j * np.sin(0.5))) < 1e-8)
    True
    """

    def __init__(
        self,
        form: CarrierFields,
        eps: float,
        start: Callable[[Array], Complex],
        first: float,
        length: float,
        points: int,
        T0: float,
        turn: float = 0.0,
    ) -> None:
        self._first, self._length, self._turn, self._T0 = first, length, turn, T0
        modes, positions = np.fft.fftfreq(points, 1 / points), np.arange(points) / points
        self._waves = np.asarray((2 * np.pi * modes + turn) / length)
        linear = np.zeros(points, dtype=np.complex128)
        self._products = []
        for term in form.flow[0]:
            value = eps**term.power * term.value
            if len(term.jets) == 1:
                linear += value * (1j * self._waves) ** term.jets[0][0]
            else:
                self._products.append((value, term.jets))
        values = np.asarray(start(first + length * positions), dtype=np.complex128)
        rate = sum(abs(value) for value, _ in self._products) * float(np.max(np.abs(values))) ** 2
        spectrum = np.fft.fft(np.exp(-1j * turn * positions) * values)
        data = linear[np.newaxis], self._nonlinear, spectrum[np.newaxis]
        self._new_integrator = partial(ExponentialAdams, *data, LONGEST_TURN / max(rate, 1e-300))
        self._integrator = self._new_integrator()
        self._spectra: dict[float, Complex] = {}

    def jets(self, X: ArrayLike, T: float, highest: int) -> Complex:
        """Return A and its X-derivatives up to order ``highest``, (highest + 1, *points).

        Raises ValueError for T before ``T0``.
        """
        if self._T0 - TIME_ROUNDING * abs(self._T0) > T:
            raise ValueError(f"T must satisfy T >= {self._T0:g}, got {T:g} (the flow starts there)")
        at = (np.asarray(X, dtype=np.float64) - self._first) / self._length
        spectrum = self._spectrum(max(T - self._T0, 0.0)) / self._waves.size
        phase = np.exp(1j * self._turn * at)
        modes = [spectrum * (1j * self._waves) ** m for m in range(highest + 1)]
        return np.stack([phase * _sum(row, 2 * np.pi * at) for row in modes])

    def _nonlinear(self, spectrum: Complex) -> Complex:
        """Return the spectrum of the nonlinear terms, with the phase ``turn`` removed."""
        p = np.ravel(spectrum)
        jets: dict[int, Complex] = {}
        total = np.zeros_like(p)
        for value, factors in self._products:
            product = np.full_like(p, value)
            for count, conjugated in factors:
                if count not in jets:
                    jets[count] = np.fft.ifft((1j * self._waves) ** count * p)
                product *= np.conj(jets[count]) if conjugated else jets[count]
            total += product
        return np.asarray(np.fft.fft(total))

    def _spectrum(self, time: float) -> Complex:
        """Return the spectrum at ``time`` after the start; cached."""
        if time not in self._spectra:
            if self._integrator.whole_steps(time) < 0:
                self._integrator = self._new_integrator()
            for _ in range(self._integrator.whole_steps(time)):
                self._integrator.step()
            self._spectra[time] = np.ravel(self._integrator.solution_at(time)).copy()
        return self._spectra[time]


def _sum(modes: Complex, phases: Array) -> Complex:
    """Return the Fourier sum of ``modes``, ordered as by np.fft.fft, at arbitrary phases."""
    total = ducc0.nufft.u2nu(
        grid=np.fft.fftshift(modes),
        coord=np.mod(phases, 2 * np.pi).reshape(-1, 1),
        forward=False,
        epsilon=SUM_ERROR,
        periodicity=2 * np.pi,
    )
    return np.asarray(total).reshape(phases.shape)
