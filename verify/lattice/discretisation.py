"""Measured discretisation errors: the same scene with half the step, with twice the sites."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.moments import Moments
from verify.lattice.observables.entry import View
from verify.lattice.recorder import Variables
from verify.lattice.recording import Progress, record
from verify.lattice.scene import Scene

Array = NDArray[np.float64]

COST = {"time_step_error": 2.0, "domain_error": 2.0}
"""Work of each re-run relative to the run itself."""


class StrainSamples:
    """Keeps the run's strains on the compared sites, and nothing else."""

    def __init__(self, times: Sequence[float]) -> None:
        self.moments = Moments(tuple(times))
        self.samples: list[Array] = []

    def see(self, view: View) -> None:
        """Keep the strains at one time."""
        self.samples.append(view.numeric)

    def variables(self) -> Variables:
        """Nothing: the samples are only compared."""
        return {}


def refined(scene: Scene, measure: str) -> Scene:
    """The scene with half the step (``time_step_error``) or twice the sites (``domain_error``)."""
    if measure == "time_step_error":
        return replace(scene, step=scene.step / 2.0, observables=())
    return replace(scene, sites=2 * scene.sites, observables=())


def measured_error(
    scene: Scene, wave: Wave, measure: str, samples: Sequence[Array], progress: Progress
) -> list[float]:
    """Largest difference of y/eps over the compared sites between a run and its refinement.

    One number for each of the snapshots in ``samples``, the strains of the run itself. Raises
    KeyboardInterrupt on Ctrl-C.
    """
    finer = StrainSamples(scene.snapshots[: len(samples)])
    if record(refined(scene, measure), wave, [finer], progress).stopped:
        raise KeyboardInterrupt
    return [
        float(np.max(np.abs(fine - coarse))) / scene.eps
        for coarse, fine in zip(samples, finer.samples, strict=False)
    ]
