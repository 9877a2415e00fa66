"""A solution of an envelope equation, with the next order or without, on a ring in X, by Fourier.

The waves exp(i kappa X) turn exactly; the rest takes an exponential Adams step.  The carrier times
A is periodic on the ring of cells, so A itself ends as it began but for a turn.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import CarrierFields
from longwave.lattice.spectral.exponential import ExponentialAdams

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP = 0.005
"""Longest step, in units of the time in which the largest amplitude turns the phase by 1. The
Peregrine wave, three times as high at its crest as at its start, is then right to 1e-6."""

EARLY = 1e-12
"""A time that much of itself before the start is the start."""

INTERPOLATION = 1e-13
"""Error of a Fourier sum, relative to its terms."""


class EnvelopeFlow:
    """A(X, T) with ``A_T = G_0 + eps G_1`` on a ring, from values ``start(X)`` at the time ``T0``.

    ``form`` gives G.  The ring begins at ``first``, is ``length`` long, has that many ``points``,
    and ``A(X + length) = A(X) exp(i turn)``.  Times that were asked for are kept.

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
        modes, places = np.fft.fftfreq(points, 1 / points), np.arange(points) / points
        self._waves = np.asarray((2 * np.pi * modes + turn) / length)
        linear = np.zeros(points, dtype=np.complex128)
        self._products = []
        for term in form.flow[0]:
            value = eps**term.power * term.value
            if len(term.jets) == 1:
                linear += value * (1j * self._waves) ** term.jets[0][0]
            else:
                self._products.append((value, term.jets))
        values = np.asarray(start(first + length * places), dtype=np.complex128)
        speed = sum(abs(value) for value, _ in self._products) * float(np.max(np.abs(values))) ** 2
        turned = np.fft.fft(np.exp(-1j * turn * places) * values)
        self._begun = partial(
            ExponentialAdams,
            linear[np.newaxis],
            self._nonlinear,
            turned[np.newaxis],
            STEP / max(speed, 1e-300),
        )
        self._run = self._begun()
        self._known: dict[float, Complex] = {}

    def jets(self, X: ArrayLike, T: float, highest: int) -> Complex:
        """A and its X-derivatives, (highest + 1, *points); ValueError before ``T0``."""
        if self._T0 - EARLY * abs(self._T0) > T:
            raise ValueError(f"T must satisfy T >= {self._T0:g}, got {T:g} (the flow starts there)")
        at = (np.asarray(X, dtype=np.float64) - self._first) / self._length
        spectrum = self._spectrum(max(T - self._T0, 0.0)) / self._waves.size
        turned = np.exp(1j * self._turn * at)
        return np.stack(
            [
                turned * _sum(spectrum * (1j * self._waves) ** m, 2 * np.pi * at)
                for m in range(highest + 1)
            ]
        )

    def _nonlinear(self, spectrum: Complex) -> Complex:
        """The products of the jets, on a ring where the turn is taken off."""
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
        """The spectrum so long after the start."""
        if time not in self._known:
            if self._run.whole_steps(time) < 0:
                self._run = self._begun()
            for _ in range(self._run.whole_steps(time)):
                self._run.step()
            self._known[time] = np.ravel(self._run.solution_at(time)).copy()
        return self._known[time]


def _sum(modes: Complex, phases: Array) -> Complex:
    """The Fourier sum with these modes, in the order of NumPy."""
    found = ducc0.nufft.u2nu(
        grid=np.fft.fftshift(modes),
        coord=np.mod(phases, 2 * np.pi).reshape(-1, 1),
        forward=False,
        epsilon=INTERPOLATION,
        periodicity=2 * np.pi,
    )
    return np.asarray(found).reshape(phases.shape)
