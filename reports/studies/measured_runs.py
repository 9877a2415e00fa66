"""Numbers measured in runs, each with its discretisation error."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import expected_cost
from longwave.scenes.observed.observables import measured_error
from longwave.support.processes import Job

RK4_STEP = 0.25
"""Time step at which RK4 is stable but visibly adds to the error against the wave."""

SPLIT = "rational_2_eps_0.05"
"""Name of the run whose error is split into position, amplitude and shape."""

PARTS = ("position", "amplitude", "shape")


class UncertainNumber(NamedTuple):
    """A measured number and the largest error that step and domain could cause in it."""

    value: float
    error: float


@dataclass(frozen=True)
class MeasuredRuns:
    """Runs of a report and their scenes, under the same names."""

    runs: Mapping[str, xr.Dataset]
    scenes: Mapping[str, Scene]

    def discretisation(self, name: str) -> xr.DataArray:
        """Return the measured error of y/eps that is due to step and domain, at each snapshot."""
        error = measured_error(self.runs[name])
        assert error is not None, f"{name} measured no error"
        return xr.DataArray(error, {"time": self.runs[name]["time"].values}, "time")

    def relative_error(self, name: str, time: float, variable: str = "error") -> UncertainNumber:
        """Return a run's relative sup error ``variable`` at a snapshot, and its numerical error.

        The denominator is exact, so the numerical error is that of y over the same denominator.
        """
        value = float(self.runs[name][variable].sel(time=time))
        own_error = self.discretisation(name).sel(time=time) / self.amplitude(name).sel(time=time)
        return UncertainNumber(value, float(own_error))

    def largest_error(self, name: str) -> tuple[UncertainNumber, float]:
        """Return the largest relative error of the run's error curve and its time."""
        curve = self.runs[name]["error_curve"]
        own_error = (self.discretisation(name) / self.amplitude(name)).max()
        time = float(curve["curve_time"].values[np.argmax(curve.values)])
        return UncertainNumber(float(curve.max()), float(own_error)), time

    def split(self, name: str, time: float) -> dict[str, UncertainNumber]:
        """Return a wave's shift in sites, and its error's parts by position, amplitude and shape.

        The parts have the error's denominator, so they share its discretisation error. A change of
        y/eps by at most d changes a least-squares shift by at most d sum |Y_n| / sum Y_n^2, with
        Y_n the slope in n.
        """
        snapshot = self.runs[name].sel(time=time)
        own_error = float(self.discretisation(name).sel(time=time))
        slope = np.gradient(snapshot["analytic"].values / self.scenes[name].eps)
        shift = own_error * float(np.sum(np.abs(slope)) / np.sum(slope**2))
        share = own_error / float(self.amplitude(name).sel(time=time))
        parts = {part: UncertainNumber(float(snapshot[f"error_{part}"]), share) for part in PARTS}
        return {"shift": UncertainNumber(float(snapshot["shift"]), shift)} | parts

    def amplitude(self, name: str) -> xr.DataArray:
        """Return the largest distance of the wave Y from its bare background, at each snapshot."""
        run = self.runs[name]
        distance: xr.DataArray = abs(run["analytic"] - run["background"])
        return distance.max("site") / self.scenes[name].eps

    def peaks(self, name: str, time: float) -> tuple[UncertainNumber, float]:
        """Return the largest y/eps of the lattice and of the wave on the sites at a snapshot."""
        snapshot, eps = self.runs[name].sel(time=time), self.scenes[name].eps
        lattice, wave = (float(snapshot[key].max()) / eps for key in ("strain", "analytic"))
        own_error = float(self.discretisation(name).sel(time=time))
        return UncertainNumber(lattice, own_error), wave


def report_scenes() -> dict[str, Scene]:
    """Return all shipped scenes, and two that show the effect of RK4's step on the error figure.

    The scene `SPLIT` also splits its error into shift, amplitude and shape.
    """
    scenes = {name: load_scene(name) for name in shipped_scenes()}
    for order in (2, 3):
        base = scenes[f"rational_{order}_eps_0.05"]
        scenes[rk4_name(order)] = base.changed(
            scheme="rk4", step=RK4_STEP, observables=("strain", "error_curve", "time_step_error")
        )
    observables = (*scenes[SPLIT].observables, "error_split")
    scenes[SPLIT] = replace(scenes[SPLIT], observables=observables)
    return scenes


def rk4_name(order: int) -> str:
    """Return the name of the RK4 variant of the scene of the rational solution of that order."""
    return f"rational_{order}_eps_0.05_rk4"


def scene_job(scene: Scene) -> Job:
    """Return the job that runs a scene with a stated step."""
    return Job(run, (scene,), expected_cost(scene).seconds, tells=True)
