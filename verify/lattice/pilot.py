"""Pilot runs: a scene on its crest alone, to measure what step and domain change."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.discretisation import StrainSamples
from verify.lattice.extent import watched_times
from verify.lattice.recording import Progress, record
from verify.lattice.scene import Scene

Array = NDArray[np.float64]

CLEARANCE = 128
"""Sites beyond the crest on which pilots are compared."""

EXPECTED = 4
"""Pilots that a plan usually needs: what their progress is measured against."""


class Pilots:
    """Runs of one scene with different steps and sizes, each done once.

    They compare only the sites about the crest, at the snapshots and a few times between: there the
    discretisation's errors are largest. ``crest`` is its half-width.
    """

    def __init__(
        self, scene: Scene, wave: Wave, scheme: str, domain: str, crest: int, progress: Progress
    ) -> None:
        self.compared = scene.compared
        if domain == "window":
            self.compared = min(scene.compared, crest + CLEARANCE)
        self._scene = replace(
            scene,
            tolerance=None,
            engine="stencil",
            scheme=scheme,
            domain=domain,
            snapshots=watched_times(scene),
            observables=(),
            compared=self.compared,
            step=1.0,
            sites=1,
        )
        self._wave, self._progress = wave, progress
        self._done: dict[tuple[float, int], list[Array] | None] = {}

    def difference(self, one: tuple[float, int], other: tuple[float, int]) -> float:
        """Largest difference of y/eps between two runs (step, sites); infinite after a blow-up."""
        first, second = self._strains(*one), self._strains(*other)
        if first is None or second is None:
            return float("inf")
        rows = zip(first, second, strict=True)
        return max(float(np.max(np.abs(a - b))) for a, b in rows) / self._scene.eps

    def errors(self, sites: int) -> tuple[list[float], list[float]]:
        """Steps done with that size, and their differences to the shortest of them."""
        steps = sorted((step for step, size in self._done if size == sites), reverse=True)
        *longer, shortest = steps
        return longer, [self.difference((step, sites), (shortest, sites)) for step in longer]

    def _strains(self, step: float, sites: int) -> list[Array] | None:
        key = (step, sites)
        if key not in self._done:
            before = len(self._done)
            samples = StrainSamples(self._scene.snapshots)
            scene = replace(self._scene, step=step, sites=sites)
            recording = record(
                scene,
                self._wave,
                [samples],
                lambda share: self._progress(min(1.0, (before + share) / EXPECTED)),
            )
            self._done[key] = None if recording.march.blow_up else samples.samples
        return self._done[key]
