"""What the first correction of a reduced equation does to a wave.

With ``Y_T = F_0 + eps^p F_p`` and ``Y = Y0 + eps^p Y1``, Y0 a solution of ``Y_T = F_0``,

    Y1_T = F_0'[Y0] Y1 + F_p[Y0],    Y1 = 0 at first.

It is solved once for all eps, by Fourier's series on an interval of X: constant coefficients are
integrated exactly, the rest by a Runge-Kutta method that finds its steps.  At second order in Y1
and with the next correction the equation has terms of the same size, so neither is kept.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.scenes.starts.fourier_interval import FourierInterval
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.solutions import NumericWave

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.starts.computed_soliton import ComputedSoliton
    from longwave.scenes.starts.damped_soliton import DampedSoliton
    from longwave.solutions import WaveValues

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

TOLERANCE = 1e-8
"""Of Y1, in units of the largest change that F_p makes in a unit of T."""

POINTS, MOST_POINTS = 384, 24576
"""Of the interval: at first, doubled while the modes that are dropped have not fallen."""

RESOLVED = 3e-7
"""The largest of the modes that are dropped, in units of the largest. What steps to TOLERANCE leave
there of a wave that is resolved is less (1.3e-7 in scene 1:108 of `searches/soak.py`)."""


class JetWave(Protocol):
    """A solution of the reduced equation: `solutions.Wave`, or one computed."""

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Y, Y_X, Y_XX, ...: an array (highest + 1, *points)."""

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W with W_X = Y, up to a constant at each T."""

    def background(self, X: ArrayLike, T: float) -> WaveValues:
        """The bare wave, or the constant, that the wave deviates from."""


class FirstCorrection:
    """Y1 of a wave, to be added to it with the factor ``eps**power``.

    ``interval``: the X between which it lives, the wave's period or much longer than the wave; Y1
    is 0 outside unless it ``repeats``.  `start` says when it is 0.
    """

    def __init__(
        self,
        flow: JetPolynomial,
        further: JetPolynomial,
        wave: JetWave,
        power: int,
        interval: tuple[float, float],
        repeats: bool = False,
    ) -> None:
        self.power = power
        self._flow, self._further, self._wave = flow, further, wave
        self._interval, self._repeats = interval, repeats
        self._constant = flow.linear
        self._known: dict[float, Complex] = {}
        self._sample(POINTS)

    def _sample(self, points: int) -> None:
        self._space = FourierInterval(self._interval, points, self._repeats)
        self._linear: Complex = np.zeros(self._space.k.size, dtype=np.complex128)
        for count, value in self._constant.items():
            self._linear += value * (1j * self._space.k) ** count
        self._dropped = 0.0

    def start(self, T: float) -> None:
        """Let Y1 vanish at T."""
        self._begin = T
        self._known = {T: np.zeros(self._space.k.size, dtype=np.complex128)}

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Y1, its X-derivative and so on: an array (highest + 1, *points)."""
        modes = self._at(T)
        return self._space.jets(modes, X, highest)

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W1 with ``W1_X = Y1``."""
        modes = self._at(T)
        return self._space.antiderivative(modes, X)

    def _at(self, T: float) -> Complex:
        """The modes at T, found from the nearest T where they are known."""
        if not self._known:
            raise ValueError(f"start must come before the corrected wave is asked for, got T = {T}")
        while T not in self._known:
            nearest = min(self._known, key=lambda known: abs(known - T))
            found = self._advanced(self._known[nearest], nearest, T)
            if self._dropped <= RESOLVED:
                self._known[T] = found
                continue
            if 2 * self._space.points > MOST_POINTS:
                raise ValueError(
                    "interval must be shorter, or the wave smoother, for a correction, got "
                    f"{self._interval} (with {self._space.points} points its modes have not fallen)"
                )
            self._sample(2 * self._space.points)
            self.start(self._begin)
        return self._known[T]

    def _advanced(self, modes: Complex, begin: float, end: float) -> Complex:
        """The modes at the end, or wherever too much of them is dropped."""
        from scipy.integrate import DOP853

        def growth(T: float) -> Complex:
            return np.asarray(np.exp(self._linear * (T - begin)))

        def slope(T: float, turned: Complex) -> Complex:
            grown = growth(T)
            return np.asarray(self._space.modes(self._varying(T, grown * turned)) / grown)

        size = float(np.max(np.abs(self._further(self._jets(begin)))))
        # the error of short modes must be small in Y1_X, too: between both, which takes 1.4 times
        # the steps in place of twice as many
        least = TOLERANCE * size / np.sqrt(1.0 + np.abs(self._space.k))
        solver = DOP853(slope, begin, modes, end, rtol=TOLERANCE, atol=least)
        self._note(begin, modes)
        while solver.status == "running" and self._dropped <= RESOLVED:
            message = solver.step()
            if solver.status == "failed":
                raise ValueError(f"T must be reached by the corrected wave, got {end} ({message})")
            # what a step tries before it is refused says nothing of the wave
            self._note(solver.t, solver.y * growth(solver.t))
        return np.asarray(solver.y * growth(solver.t))

    def _jets(self, T: float) -> Array:
        highest = max(self._flow.highest, self._further.highest)
        return np.asarray(self._wave.jets(self._space.X, T, highest))

    def _varying(self, T: float, modes: Complex) -> Array:
        """Y1_T but for the terms with constant coefficients."""
        jets = self._jets(T)
        total = self._further(jets)
        for count, slope in enumerate(self._flow.variation(jets)):
            rest = slope - self._constant.get(count, 0.0)
            if np.any(rest):
                total = total + rest * self._space.values(modes, count)
        return np.asarray(total)

    def _note(self, T: float, modes: Complex) -> None:
        """How much of the modes of Y1_T is dropped."""
        found = np.abs(np.fft.rfft(self._varying(T, modes)))
        share = float(np.max(found[self._space.k.size :]) / max(float(np.max(found)), TINY))
        self._dropped = max(self._dropped, share)


TINY = 1e-300


INTERVAL = {True: 8.0, False: 2.0}
"""The X on which the next order of a wave that does not end is solved, in half-widths, of envelopes
and of long waves. With 6 the Peregrine wave's errors change by less than a hundredth of themselves;
a longer one would not resolve the crest of a rogue wave (measured on rational_2, half-width 8)."""


def correction_interval(
    scene: Scene, wave: NumericWave | ComputedSoliton | DampedSoliton
) -> tuple[float, float] | None:
    """Whole periods of the wave, or many times what is compared; None for a wave that ends."""
    if scene.order != "corrected" or wave.constant_background == 0.0:
        return None
    assert isinstance(wave, NumericWave)
    compared = scene.half_width or scene.compared * scene.eps
    period = wave.numbers.wavelength
    half = INTERVAL[scene.is_envelope] * compared
    half = half if period is None else math.ceil(half / period) * period
    return -half, half
