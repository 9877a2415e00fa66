"""Known laws of two chains on a bench: the return of a mode, the speed of struck grains."""

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
"""Initial velocities of the struck grain. In theory the speed of the wave that it starts grows as
their fifth root (Nesterenko 1983)."""

FIRST, SECOND = 20, 40
"""Numbers of the two cells between which the wave's travel time is measured."""


class Return(NamedTuple):
    """Largest return of energy to the first mode (FPUT recurrence).

    ``periods`` is its time in the mode's linear periods, ``share`` the mode's energy then over its
    initial energy, ``reading`` the time between two readings in linear periods.
    """

    periods: float
    share: float
    reading: float


def mode_return(run: xr.Dataset) -> Return:
    """Return the first mode's largest energy after it fell below half, as a `Return`."""
    energy, times = run.mode_energy.values[:, 0], run.time.values
    half_lost = int(np.argmax(energy < 0.5 * energy[0]))
    returned = half_lost + int(np.argmax(energy[half_lost:]))
    cells = load_scene("fput_1955").own_bench.sites
    period = math.pi / math.sin(0.5 * math.pi / (cells + 1))
    time, energy_then = _peak(times, energy, returned)
    reading = float(times[returned] - times[returned - 1])
    return Return(time / period, energy_then / energy[0], reading / period)


def _peak(times: Array, values: Array, index: int) -> tuple[float, float]:
    """Return time and height of the peak of the parabola through three values around ``index``."""
    quadratic, linear, constant = np.polyfit([-1.0, 0.0, 1.0], values[index - 1 : index + 2], 2)
    offset = -0.5 * linear / quadratic
    spacing = times[index + 1] - times[index]
    return float(times[index] + offset * spacing), float(constant + 0.5 * linear * offset)


def struck_exponent() -> tuple[float, float]:
    """Return the fitted exponent of wave speed in the grain's velocity, and its standard error."""
    scene, speeds = load_scene("struck_grains"), []
    for velocity in VELOCITIES:
        scale = (0.1 / velocity) ** 0.2
        run = scene.changed(
            start={"impact": {"site": 0, "velocity": velocity}},
            observables={"sensors": {"sites": [FIRST, SECOND], "of": ["velocity"]}, "every": 0.1},
            times=[0, round(90.0 * scale, 1)],
            tolerance=1e-3 * velocity,
        ).run()
        times, readings = run.time.values, run.sensor_velocity.values.T
        first, second = (_peak(times, v, int(np.argmax(v)))[0] for v in readings)
        speeds.append((SECOND - FIRST) / (second - first))
    fitted = stats.linregress(np.log(VELOCITIES), np.log(speeds))
    return float(fitted.slope), float(fitted.stderr)


def bench_law_jobs() -> dict[Key, Job]:
    """Return the job that runs the struck grains; the mode's run is that of a shipped scene."""
    return {("struck", ""): Job(struck_exponent, (), 4.0)}
