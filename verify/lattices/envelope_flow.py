"""A solution of an envelope equation, with the next order or without, on a ring in X, by Fourier.

The waves exp(i kappa X) turn exactly; the rest takes an exponential Adams step.  A times its
carrier is periodic on the ring of cells, so A itself ends as it began but for a turn.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from derive.carrier_fields import CarrierFields, CarrierTerm

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP = 0.004
"""Longest step, in units of the time in which the wave's largest amplitude turns its phase by 1.
With half of it the Peregrine wave's spectrum changes by 1e-9 (measured over 4 such times)."""


class EnvelopeFlow:
    """A(X, T) with ``A_T = G_0 + eps G_1`` from values at a time, on a ring of length ``length``.

    ``form`` gives G; ``order`` 0 leaves eps G_1 out.  ``start`` is A at that many points of
    ``first + length i/points`` at the time ``T0``; ``A(X + length) = A(X) exp(i turn)``.  ``step``
    is the longest step in T.
    """

    def __init__(
        self,
        form: CarrierFields,
        eps: float,
        start: Callable[[Array], Complex],
        *,
        first: float,
        length: float,
        points: int,
        T0: float,
        turn: float = 0.0,
        order: int = 1,
        share: float = 1.0,
    ) -> None:
        self._first, self._length, self._points, self._T0 = first, length, points, T0
        terms = [term for term in form.flow[0] if term.power <= order]
        modes = np.fft.fftfreq(points, 1 / points)
        self._waves = (2 * np.pi * modes + turn) / length
        self._turn = np.exp(1j * turn * np.arange(points) / points)
        linear = np.zeros(points, dtype=np.complex128)
        for term in (t for t in terms if len(t.jets) == 1):
            linear += eps**term.power * term.value * (1j * self._waves) ** term.jets[0][0]
        self._products = [
            CarrierTerm(t.power, t.jets, eps**t.power * t.value) for t in terms if len(t.jets) > 1
        ]
        at = first + length * np.arange(points) / points
        values = np.asarray(start(at), dtype=np.complex128)
        speed = sum(abs(t.value) for t in self._products) * float(np.max(np.abs(values))) ** 2
        self._step = share * STEP / max(speed, 1e-300)
        self._linear, self._begin = linear, self._spectrum(values)
        self._known: dict[float, Complex] = {T0: self._begin}
        self._run = self._fresh()
