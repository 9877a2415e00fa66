"""What two chains on a bench are known for: a mode that returns, the speed of struck grains."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import stats

from longwave.scenes.description.named_scenes import load_scene
from longwave.support.processes import Job, Key

Array = NDArray[np.float64]

VELOCITIES = (0.0125, 0.05, 0.2, 0.8)
"""Of the first grain. The speed of the wave goes as the fifth root (Nesterenko 1983)."""

FIRST, SECOND = 20, 40
"""Cells between which the wave is timed."""


class Return(NamedTuple):
    """When a mode comes back, in units of its period at small amplitudes, and with how much of its
    energy; ``reading`` is the time between two readings in that unit."""

    periods: float
    share: float
    reading: float


def mode_return(run: xr.Dataset) -> Return:
    """The first return of a run's first mode after it has lost half of its energy."""
    energy, times = run.mode_energy.values[:, 0], run.time.values
    lost = int(np.argmax(energy < 0.5 * energy[0]))
    back = lost + int(np.argmax(energy[lost:]))
    cells = load_scene("fput_1955").own_bench.sites
    period = math.pi / math.sin(0.5 * math.pi / (cells + 1))
    when, most = _peak(times, energy, back)
    return Return(when / period, most / energy[0], float(times[back] - times[back - 1]) / period)


def _peak(times: Array, values: Array, place: int) -> tuple[float, float]:
    """The time and the height of the parabola through a largest reading and those beside it."""
    bend, slope, level = np.polyfit([-1.0, 0.0, 1.0], values[place - 1 : place + 2], 2)
    moved = -0.5 * slope / bend
    spacing = times[place + 1] - times[place]
    return float(times[place] + moved * spacing), float(level + 0.5 * slope * moved)


def struck_exponent() -> tuple[float, float]:
    """The exponent of the wave's speed in the velocity of the grain, and its standard error."""
    scene, speeds = load_scene("struck_grains"), []
    for velocity in VELOCITIES:
        scale = (0.1 / velocity) ** 0.2
        run = scene.changed(
            start={"impact": {"site": 0, "velocity": velocity}},
            observables={"sensors": {"sites": [FIRST, SECOND], "of": ["velocity"]}, "every": 0.1},
            times=[0, round(90.0 * scale, 1)],
            tolerance=1e-3 * velocity,
        ).run()
        read = run.sensor_velocity.values
        peaks = [_peak(run.time.values, one, int(np.argmax(one)))[0] for one in read.T]
        speeds.append((SECOND - FIRST) / (peaks[1] - peaks[0]))
    fitted = stats.linregress(np.log(VELOCITIES), np.log(speeds))
    return float(fitted.slope), float(fitted.stderr)


def bench_law_jobs() -> dict[Key, Job]:
    """The runs of struck grains; the mode's is that of a shipped scene."""
    return {("struck", ""): Job(struck_exponent, (), 4.0)}
