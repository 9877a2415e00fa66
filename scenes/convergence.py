"""How fast the lattice comes near its long-wave limit: errors at fixed slow time over eps, a rate.

Every error stands beside its own: a second run on a ring half as long again, with a longer step,
compared on the same cells.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from longwave.scenes.lattice_wave import CellRing, LatticeWave
from longwave.scenes.ring_run import advanced

Array = NDArray[np.float64]

STEP, LONGER_STEP = 0.4, 0.7
"""Of the run and of the one that judges it, in units of the longest stable one."""

LONGER = 1.5
"""How much longer the ring of that is."""

SNAPSHOTS = 4
"""Times at which lattice and theory are compared."""

FEWEST = 3
"""Errors that a rate with its uncertainty needs."""


@dataclass(frozen=True)
class ErrorAt:
    """The sup error of what is compared at one eps, and what the run itself adds to it at most.

    Both are in the units of the lattice; ``cells`` is the length of the ring.
    """

    eps: float
    cells: int
    error: float
    discretisation: float


@dataclass(frozen=True)
class FittedRate:
    """The power of eps that fits errors, and an interval for its limit at small eps.

    >>> print(FittedRate(5.82, 5.81, 6.04))
    5.8 (5.8 .. 6.1)
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return (
            f"{self.value:.1f} ({floor(10 * self.low) / 10:.1f} .. {ceil(10 * self.high) / 10:.1f})"
        )

    def holds(self, power: float) -> bool:
        """Whether the interval, with its ends as they are printed, holds that power."""
        return floor(10 * self.low) <= 10 * power <= ceil(10 * self.high)


@dataclass(frozen=True)
class ConvergenceStudy:
    """Errors at a fixed slow time and the power of eps that fits them."""

    errors: tuple[ErrorAt, ...]
    rate: FittedRate


def fitted_rate(
    eps: Sequence[float], errors: Sequence[float], own: Sequence[float] = ()
) -> FittedRate:
    """The least-squares slope of ``log error`` by ``log eps``, and where its limit may lie.

    The slope drifts with eps. Between two neighbours it is told at their geometric mean, and what
    is held is the slope at all eps, that of the two least, and what lines through the slopes by eps
    and by its square have at eps = 0; beyond that, what slopes miss of these lines, and what the
    errors ``own`` of the runs may change.  Raises ValueError for fewer than three errors, and for
    what has no logarithm.

    >>> fitted_rate([0.1, 0.2, 0.4], [0.01, 0.04, 0.16]).value
    2.0
    """
    if len(eps) != len(errors) or len(errors) < FEWEST or len({*eps}) < len(eps):
        raise ValueError(
            f"errors must be at least {FEWEST}, each at its own eps, got {len(errors)} at "
            f"{len({*eps})} (take more values of eps)"
        )
    if not (min(eps) > 0.0 and 0.0 < min(errors) <= max(errors) < np.inf):
        raise ValueError(
            f"errors must be finite and > 0, got {min(errors):g} to {max(errors):g} (an error of 0 "
            "has no rate)"
        )
    places = np.argsort(eps)
    logs = np.log(np.array([eps, errors], dtype=np.float64)[:, places])
    value = round(float(np.polyfit(logs[0], logs[1], 1)[0]), 12)
    widths, heights = np.diff(logs, axis=1)
    slopes, middles = heights / widths, np.exp((logs[0, 1:] + logs[0, :-1]) / 2)
    lines = [np.polyfit(middles**power, slopes, 1) for power in (1, 2)]
    missed = min(
        float(np.max(np.abs(np.polyval(line, middles**power) - slopes)))
        for power, line in zip((1, 2), lines, strict=True)
    )
    shares = np.array(own or np.zeros(len(errors)))[places] / np.exp(logs[1])
    beyond = missed + float(np.max((shares[1:] + shares[:-1]) / widths))
    held = [value, float(slopes[0]), *(float(line[1]) for line in lines)]
    return FittedRate(value, min(held) - beyond, max(held) + beyond)


def convergence_study(
    make: Callable[[float], LatticeWave],
    eps_values: Sequence[float],
    slow_times: tuple[float, float],
    within: float | None = None,
    causal: bool = False,
) -> ConvergenceStudy:
    """Errors of the waves that ``make`` gives for each eps, from T = ``slow_times[0]`` to [1].

    Compared are the cells where the wave is, or those within ``within`` in X of the frame, which a
    wave that does not end needs: its ring is then so long that nothing comes round it, as any
    ring is that is ``causal``.
    """
    errors = tuple(error_at(make(eps), slow_times, within, causal) for eps in eps_values)
    own = [found.discretisation for found in errors]
    return ConvergenceStudy(errors, fitted_rate(eps_values, [found.error for found in errors], own))


def error_at(
    wave: LatticeWave,
    slow_times: tuple[float, float],
    within: float | None = None,
    causal: bool = False,
) -> ErrorAt:
    """The sup error of one wave over several times after the first, with the run's own error."""
    begin, end = (T / wave.eps**wave.slow for T in slow_times)
    times = np.linspace(begin, end, SNAPSHOTS + 1)
    wave.start(begin)
    window = _Window(wave, times, within, causal)
    first, second = (
        window.differences(window.ring(longer), share)
        for longer, share in ((1.0, STEP), (LONGER, LONGER_STEP))
    )
    changed = max(float(np.max(np.abs(a - b))) for a, b in zip(first, second, strict=True))
    error = max(float(np.max(np.abs(a))) for a in first)
    return ErrorAt(wave.eps, window.ring(1.0).cells.size, error, changed)


class _Window:
    """The cells that are compared at each of the times, and rings that hold them."""

    def __init__(self, wave: LatticeWave, times: Array, within: float | None, causal: bool) -> None:
        self._wave, self._times = wave, times
        self._ends = [self._around(float(t), within) for t in times]
        self._is_causal = causal or within is not None
        duration = float(times[-1] - times[0])
        low, high = self._ends[0]
        if self._is_causal:
            around = wave.ring(np.arange(int(low), int(high) + 1), float(times[0]))
            swept = wave.speed * duration
            reach = SAFETY * wave.signal_speed(around) * duration
            low, high = min(low, low + swept - reach), max(high, high + swept + reach)
        self._low, self._high = low, high

    def _around(self, t: float, within: float | None) -> tuple[float, float]:
        if within is not None:
            half = within / self._wave.eps
            return self._wave.speed * t - half, self._wave.speed * t + half
        low, high = self._wave.support(t)
        if not np.isfinite(high - low):
            raise ValueError(
                "within must be given for a wave that does not end, got None (the half-width in X "
                "of what is compared)"
            )
        return low, high

    def ring(self, longer: float) -> CellRing:
        """The state at first on a ring with all that is needed, or longer."""
        half = longer * (self._high - self._low) / 2.0 * (1.0 if self._is_causal else 2.0)
        middle = (self._low + self._high) / 2.0
        cells = np.arange(int(np.floor(middle - half)), int(np.ceil(middle + half)) + 1)
        return self._wave.ring(cells, float(self._times[0]))

    def differences(self, ring: CellRing, share: float) -> list[Array]:
        """Lattice less theory on the compared cells at each time after the first."""
        states = advanced(ring, self._times, share)
        found = []
        for t, f, (low, high) in zip(self._times[1:], states, self._ends[1:], strict=True):
            cells = np.arange(int(np.ceil(low)), int(high) + 1)
            places = (cells - int(ring.cells[0])) % ring.cells.size
            lattice = self._wave.measured(f, ring.mean_strain)[:, places]
            found.append(lattice - self._wave.strain(cells, float(t)))
        return found


SAFETY = 1.05
"""On the distance that signals come."""
