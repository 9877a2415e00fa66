"""Hard cases: stable and unstable periodic backgrounds over long times.

The waves are the lattice's own travelling waves, so that nothing but the seed is a perturbation.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lattice.schemes.catalogue import KAHAN_LI_8
from verify.comparison.trust import UNIT_ROUNDOFF, horizon
from verify.studies.floquet import fastest_mode
from verify.studies.hard_case import Measurement
from verify.studies.travelling import TravellingWave, travelling_wave

Array = NDArray[np.float64]

CN = ("wave_cn", 0.8, 20, 1, 1)
"""Form, k, period in sites, K2, K4 of the unstable background."""

CN_WAVELENGTHS = 16
CN_STEP = 0.25


def deviations(wave: TravellingWave, y: Array, s: Array, h: float, times: Array) -> Array:
    """sup |y_n(t) - f(n - v t)| / eps at the times (multiples of h) of a run from (y, s)."""
    n, t, found = np.arange(float(y.size)), 0.0, []
    for later in times:
        KAHAN_LI_8.advance(y, s, h, round((later - t) / h), wave.constants)
        t = float(later)
        found.append(float(np.max(np.abs(y - wave.strain(n - wave.speed * t)))) / wave.eps)
    return np.array(found)


def cn_growth() -> Measurement:
    """Growth rate of the fastest mode, seeded at 1e-9, against the eigenvalue problem's."""
    wave = travelling_wave(*CN)
    mode = fastest_mode(wave, CN_WAVELENGTHS)
    n = np.arange(float(CN_WAVELENGTHS * wave.period))
    y, s = (1e-9 * wave.eps * part for part in mode.at(n))
    times = np.linspace(25.0, 5500.0, 220)
    found = deviations(wave, wave.strain(n) + y, wave.velocity(n) + s, CN_STEP, times)
    window = (found > 1e-8) & (found < 1e-5)
    rate = float(np.polyfit(times[window], np.log(found[window]), 1)[0])
    predicted = mode.rate.real
    detail = f"{rate:.5g} per unit time, predicted {predicted:.5g}"
    return Measurement(abs(rate / predicted - 1.0), detail)


def cn_horizon() -> Measurement:
    """Time until rounding alone has grown to 1e-4 eps, against the predicted horizon."""
    wave = travelling_wave(*CN)
    rate = fastest_mode(wave, CN_WAVELENGTHS).rate.real
    predicted = horizon(rate, 1e-4, UNIT_ROUNDOFF)
    n = np.arange(float(CN_WAVELENGTHS * wave.period))
    times = 50.0 * np.arange(1.0, math.ceil(1.6 * predicted / 50.0))
    found = deviations(wave, wave.strain(n), wave.velocity(n), CN_STEP, times)
    passed = np.flatnonzero(found > 1e-4)
    reached = float(times[passed[0]]) if passed.size else math.inf
    detail = f"lost at t = {reached:.0f}, predicted horizon {predicted:.0f}"
    return Measurement(abs(reached / predicted - 1.0), detail)


def stable_sn() -> Measurement:
    """Growth of noise on an sn wave over t = 10^4, shifts removed."""
    return _growth("wave_sn", -1)


def stable_dn() -> Measurement:
    """Growth of noise on a dn wave over t = 10^4, shifts removed."""
    return _growth("wave_dn", 1)


def _growth(form: str, K4: int) -> Measurement:
    wave = travelling_wave(form, 0.7, 27, 1, K4)
    rate = fastest_mode(wave, 8).rate.real
    n = np.arange(float(8 * wave.period))
    noise = 1e-6 * wave.eps * np.random.default_rng(7).standard_normal(n.size)
    y, s = wave.strain(n) + noise - np.mean(noise), wave.velocity(n)
    first, _ = shape_deviation(wave, y, 0.0)
    worst, shift = first, 0.0
    for t in 100.0 * np.arange(1, 101):
        KAHAN_LI_8.advance(y, s, 0.5, 200, wave.constants)
        deviation, shift = shape_deviation(wave, y, float(t))
        worst = max(worst, deviation)
    detail = f"shift {shift:.1g} sites at t = 10^4, largest eigenvalue {rate:.1g}"
    return Measurement(worst / first, detail)


def shape_deviation(wave: TravellingWave, y: Array, t: float) -> tuple[float, float]:
    """Root mean square deviation from the best shifted wave, and that shift (Gauss-Newton)."""
    n, shift = np.arange(float(y.size)), 0.0
    for _ in range(4):
        x = n - wave.speed * t - shift
        slope = wave.velocity(x) / wave.speed
        shift += float(slope @ (y - wave.strain(x)) / (slope @ slope))
    missed = y - wave.strain(n - wave.speed * t - shift)
    return float(np.sqrt(np.mean(missed**2))), shift
