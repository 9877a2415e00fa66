"""Shipped scenes of further lattices, and rates at which lattices converge to their waves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import xarray as xr

from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.rate_cases import rate_cases
from longwave.support.processes import Job, Key, Progress

if TYPE_CHECKING:
    from longwave.scenes.convergence import SceneConvergence

SECONDS = {"alpha_beta_rogue": 4.0, "dimer_rogue": 6.0}
"""Scene -> expected processor seconds, for scenes on long rings; others take `USUAL`."""

USUAL = 1.0


@dataclass(frozen=True)
class SceneRun:
    """A scene with its run, or with the reason (``fault``) why it did not run."""

    scene: Scene
    run: xr.Dataset | None
    fault: str = ""

    @property
    def within_tolerance(self) -> bool:
        """Whether the run finished within its tolerance, by its own estimate."""
        estimate = float("inf") if self.run is None else self.run.attrs["error_estimate"]
        return float(estimate) <= self.scene.target.tolerance


def scene_run(name: str, progress: Progress = lambda _: None) -> SceneRun:
    """Run the shipped scene of that name; if it is refused, return the message as the fault."""
    scene = load_scene(name)
    try:
        return SceneRun(scene, scene.run(progress))
    except ValueError as error:
        return SceneRun(scene, None, str(error))


def scene_run_jobs() -> dict[Key, Job]:
    """Return a job for each shipped scene of waves and of chains on a bench."""
    return {
        (kind, name): Job(scene_run, (name,), SECONDS.get(name, USUAL), tells=True)
        for kind, folder in (("scene", "lattices"), ("bench", "bench"))
        for name in shipped_scenes(folder)
    }


RATE_SECONDS = {"leading": 1.0, "slaved": 3.0, "corrected": 15.0}
"""Order of the initial data -> expected processor seconds of a case; long ones take `LONGER` times
that."""

LONGER = 10.0


def measured_rate(name: str, order: str) -> SceneConvergence:
    """Measure the rate of one of the `rate_cases`; ``order`` names the order of the initial data.

    >>> found = measured_rate("2", "leading")
    >>> found.equation, found.theory, found.reached
    ('KdV', 4, True)
    """
    return rate_cases()[name].study(order)


def rate_jobs(full: bool) -> dict[Key, Job]:
    """Return the jobs of short cases with leading data; if ``full``, of all cases and orders."""
    return {
        ("rate", (name, order)): Job(
            measured_rate, (name, order), RATE_SECONDS[order] * (LONGER if case.is_long else 1.0)
        )
        for name, case in rate_cases().items()
        if full or not case.is_long
        for order in case.orders[: None if full else 1]
    }
