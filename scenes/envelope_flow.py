"""A solution of an envelope equation, with the next order or without, on a ring in X, by Fourier.

The waves exp(i kappa X) turn exactly; the rest takes an exponential Adams step.  The carrier times
A is periodic on the ring of cells, so A itself ends as it began but for a turn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import CarrierFields, CarrierTerm
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


@dataclass(frozen=True)
class EnvelopeFlow:
    """A(X, T) with ``A_T = G_0 + eps G_1`` on a ring, from values ``start(X)`` at the time ``T0``.

    ``form`` gives G; with ``highest`` 0 eps G_1 is left out.  The ring begins at ``first``, is
    ``length`` long, has that many ``points``, and ``A(X + length) = A(X) exp(i turn)``.  ``share``
    makes all steps shorter.

    >>> from longwave.derive import LATTICES, envelope
    >>> from longwave.derive.carrier_numbers import carrier_fields
    >>> form = carrier_fields(envelope(LATTICES["fput_strain"]), 1, K2=1, K3=0, K4=1)
    >>> flow = EnvelopeFlow(form, 0.1, np.ones_like, first=0.0, length=1.0, points=8, T0=0.0)
    >>> turned = flow.jets(0.25, 2.0, 0)[0]        # a plane wave: A_T = i q |A|^2 A
    >>> bool(abs(turned - np.exp(-6j * np.sin(0.5))) < 1e-8)
    True
    """

    form: CarrierFields
    eps: float
    start: Callable[[Array], Complex]
    first: float
    length: float
    points: int
    T0: float
    turn: float = 0.0
    highest: int = 1
    share: float = 1.0

    def jets(self, X: ArrayLike, T: float, highest: int) -> Complex:
        """A and its X-derivatives, (highest + 1, *points); ValueError before ``T0``."""
        at = (np.asarray(X, dtype=np.float64) - self.first) / self.length
        spectrum = self._spectrum(T)
        turned = np.exp(1j * self.turn * at)
        return np.stack(
            [
                turned * _sum(spectrum * (1j * self._waves) ** m, 2 * np.pi * at)
                for m in range(highest + 1)
            ]
        )

    def error(self, T: float) -> float:
        """How much half the step and twice the points change A, at most."""
        control = replace(self, points=2 * self.points, share=self.share / 2)
        X = self.first + self.length * np.arange(2 * self.points) / (2 * self.points)
        return float(np.max(np.abs(self.jets(X, T, 0) - control.jets(X, T, 0))))

    @cached_property
    def _waves(self) -> Array:
        modes = np.fft.fftfreq(self.points, 1 / self.points)
        return np.asarray((2 * np.pi * modes + self.turn) / self.length)

    @cached_property
    def _terms(self) -> list[CarrierTerm]:
        """A_T, the powers of eps put into the values."""
        kept = (term for term in self.form.flow[0] if term.power <= self.highest)
        return [CarrierTerm(0, t.jets, self.eps**t.power * t.value) for t in kept]

    @cached_property
    def _run(self) -> _Run:
        linear = np.zeros(self.points, dtype=np.complex128)
        products = []
        for term in self._terms:
            if len(term.jets) == 1:
                linear += term.value * (1j * self._waves) ** term.jets[0][0]
            else:
                products.append(term)
        places = np.arange(self.points) / self.points
        values = np.asarray(self.start(self.first + self.length * places), dtype=np.complex128)
        speed = sum(abs(term.value) for term in products) * float(np.max(np.abs(values))) ** 2
        h = self.share * STEP / max(speed, 1e-300)
        turned = np.exp(-1j * self.turn * places)
        return _Run(self._waves, linear, products, turned, values, h)

    def _spectrum(self, T: float) -> Complex:
        if self.T0 - EARLY * abs(self.T0) > T:
            raise ValueError(f"T must satisfy T >= {self.T0:g}, got {T:g} (the flow starts there)")
        return self._run.at(max(T - self.T0, 0.0)) / self.points


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


class _Run:
    """The spectrum at later and later times; those that were asked for are kept."""

    def __init__(
        self,
        waves: Array,
        linear: Complex,
        products: list[CarrierTerm],
        turned: Complex,
        values: Complex,
        h: float,
    ) -> None:
        self._waves, self._products, self._turned = waves, products, turned
        self._made = (linear[np.newaxis], np.fft.fft(turned * values)[np.newaxis], h)
        self._known: dict[float, Complex] = {}
        self._run = self._begun()

    def _begun(self) -> ExponentialAdams:
        linear, spectrum, h = self._made
        return ExponentialAdams(linear, self._nonlinear, spectrum, h)

    def _nonlinear(self, spectrum: Complex) -> Complex:
        """The products of the jets, on a ring where the turn is taken off."""
        p = np.ravel(spectrum)
        jets: dict[int, Complex] = {}
        total = np.zeros_like(p)
        for term in self._products:
            product = np.full_like(p, term.value)
            for count, conjugated in term.jets:
                if count not in jets:
                    jets[count] = np.fft.ifft((1j * self._waves) ** count * p)
                product *= np.conj(jets[count]) if conjugated else jets[count]
            total += product
        return np.asarray(np.fft.fft(total))

    def at(self, time: float) -> Complex:
        """The spectrum so long after the start."""
        if time not in self._known:
            if self._run.whole_steps(time) < 0:
                self._run = self._begun()
            for _ in range(self._run.whole_steps(time)):
                self._run.step()
            self._known[time] = np.ravel(self._run.ahead(time)).copy()
        return self._known[time]
