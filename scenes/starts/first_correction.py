"""Effect of a reduced equation's first correction on a wave, as a linear perturbation.

With ``Y_T = F_0 + eps^p F_p`` and ``Y = Y0 + eps^p Y1``, Y0 a solution of ``Y_T = F_0``,

    Y1_T = F_0'[Y0] Y1 + F_p[Y0],    Y1 = 0 at the start.

It is solved once for all eps, by a Fourier series on an interval of X.  Terms with constant
coefficients are integrated exactly, the others by an adaptive Runge-Kutta method.  Terms of second
order in Y1 are of the same size as the next correction, so both are neglected.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.scenes.starts.fourier_interval import FourierInterval
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.solutions import NumericWave, WaveValues

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.starts.computed_soliton import ComputedSoliton
    from longwave.scenes.starts.damped_soliton import DampedSoliton

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CORRECTION_TOLERANCE = 1e-8
"""Error tolerance of Y1: relative, and absolute in units of the largest ``|F_p[Y0]|`` at the
start."""

FIRST_POINTS, MAX_POINTS = 384, 24576
"""First and largest number of points on the interval. The number is doubled while truncated modes
are too large."""

MAX_TRUNCATED = 3e-7
"""Largest accepted truncated mode, in units of the largest mode. Step errors within
`CORRECTION_TOLERANCE` contribute less to truncated modes (1.3e-7 in scene 1:108 of
`searches/soak.py`)."""


class JetWave(Protocol):
    """Solution of the reduced equation: a `solutions.Wave`, or a computed one."""

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Return Y and its X-derivatives up to order ``highest``, (highest + 1, *points)."""

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """Return W with W_X = Y, up to a constant at each T."""

    def background(self, X: ArrayLike, T: float) -> WaveValues:
        """Return the background, a periodic wave or a constant, with its X- and T-derivatives."""


class FirstCorrection:
    """First correction Y1 of a wave, to be added with the factor ``eps**power``.

    ``interval`` is the interval of X on which Y1 is solved: whole periods of the wave, or much
    longer than the wave.  Outside it Y1 is 0, or periodic if it ``repeats``.  `start` sets the time
    at which Y1 is 0.
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
        self._solved: dict[float, Complex] = {}
        self._sample(FIRST_POINTS)

    def _sample(self, points: int) -> None:
        self._space = FourierInterval(self._interval, points, self._repeats)
        self._linear: Complex = np.zeros(self._space.k.size, dtype=np.complex128)
        for count, value in self._constant.items():
            self._linear += value * (1j * self._space.k) ** count
        self._truncated = 0.0

    def start(self, T: float) -> None:
        """Set Y1 = 0 at T and discard earlier results."""
        self._begin = T
        self._solved = {T: np.zeros(self._space.k.size, dtype=np.complex128)}

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Return Y1 and its X-derivatives up to order ``highest``, (highest + 1, *points)."""
        modes = self._at(T)  # may replace the interval
        return self._space.jets(modes, X, highest)

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """Return W1 with ``W1_X = Y1``."""
        modes = self._at(T)
        return self._space.antiderivative(modes, X)

    def _at(self, T: float) -> Complex:
        """Return the Fourier modes of Y1 at T.

        Raises ValueError before `start`, and if `MAX_POINTS` points do not resolve Y1.
        """
        if not self._solved:
            raise ValueError(
                f"start must be called before the corrected wave is evaluated, got T = {T:g} (call "
                "start with the time of the initial data)"
            )
        while T not in self._solved:
            nearest = min(self._solved, key=lambda time: abs(time - T))
            modes = self._advanced(self._solved[nearest], nearest, T)
            if self._truncated <= MAX_TRUNCATED:
                self._solved[T] = modes
                continue
            if 2 * self._space.points > MAX_POINTS:
                raise ValueError(
                    "interval must be shorter, or the wave smoother, for a correction, got "
                    f"{self._interval} ({self._space.points} points do not resolve the correction)"
                )
            self._sample(2 * self._space.points)
            self.start(self._begin)
        return self._solved[T]

    def _advanced(self, modes: Complex, begin: float, end: float) -> Complex:
        """Integrate the modes of Y1 to T = ``end``, or until truncated modes are too large."""
        from scipy.integrate import DOP853

        def growth(T: float) -> Complex:
            return np.asarray(np.exp(self._linear * (T - begin)))

        def slope(T: float, scaled: Complex) -> Complex:
            factor = growth(T)
            return np.asarray(self._space.modes(self._varying(T, factor * scaled)) / factor)

        forcing = float(np.max(np.abs(self._further(self._jets(begin)))))
        # Y1_X needs small errors of short modes, too. This weight, a compromise between Y1 and
        # Y1_X, takes 1.4 times the steps instead of twice as many.
        absolute = CORRECTION_TOLERANCE * forcing / np.sqrt(1.0 + np.abs(self._space.k))
        solver = DOP853(slope, begin, modes, end, rtol=CORRECTION_TOLERANCE, atol=absolute)
        self._update_truncated(begin, modes)
        while solver.status == "running" and self._truncated <= MAX_TRUNCATED:
            message = solver.step()
            if solver.status == "failed":
                raise ValueError(f"T must be reached by the corrected wave, got {end} ({message})")
            # checked after accepted steps only, as rejected ones do not represent the wave
            self._update_truncated(solver.t, solver.y * growth(solver.t))
        return np.asarray(solver.y * growth(solver.t))

    def _jets(self, T: float) -> Array:
        highest = max(self._flow.highest, self._further.highest)
        return np.asarray(self._wave.jets(self._space.X, T, highest))

    def _varying(self, T: float, modes: Complex) -> Array:
        """Return Y1_T at the points, without the terms with constant coefficients."""
        jets = self._jets(T)
        total = self._further(jets)
        for count, slope in enumerate(self._flow.variation(jets)):
            rest = slope - self._constant.get(count, 0.0)
            if np.any(rest):
                total = total + rest * self._space.values(modes, count)
        return np.asarray(total)

    def _update_truncated(self, T: float, modes: Complex) -> None:
        """Raise ``_truncated`` to the largest truncated mode of Y1_T over its largest mode."""
        sizes = np.abs(np.fft.rfft(self._varying(T, modes)))
        largest = max(float(np.max(sizes)), TINY_DENOMINATOR)
        self._truncated = max(self._truncated, float(np.max(sizes[self._space.k.size :]) / largest))


TINY_DENOMINATOR = 1e-300
"""Lower bound of the divisor of relative truncated modes; avoids division by 0."""


HALF_LENGTHS = {True: 8.0, False: 2.0}
"""Half-length of the interval for the next order of an infinite wave, in half-widths of the
compared region, for envelopes (True) and long waves (False). With 6 the Peregrine wave's errors
change by less than 1 %; on a longer interval the crest of a rogue wave would not be resolved
(measured on rational_2, half-width 8)."""


def correction_interval(
    scene: Scene, wave: NumericWave | ComputedSoliton | DampedSoliton
) -> tuple[float, float] | None:
    """Return the interval of X on which a scene's next order is solved; None if none is needed.

    The interval contains whole periods of the wave, or several times the compared region. None is
    needed for a wave that tends to 0, nor for any order but "corrected".
    """
    if scene.order != "corrected" or wave.constant_background == 0.0:
        return None
    assert isinstance(wave, NumericWave)
    compared = scene.half_width or scene.compared * scene.eps
    period = wave.numbers.wavelength
    half = HALF_LENGTHS[scene.is_envelope] * compared
    half = half if period is None else math.ceil(half / period) * period
    return -half, half
