"""Pilot runs: a scene on its crest alone, to measure what step and domain change."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.discretisation import StrainSamples
from verify.lattice.domain import window_moves
from verify.lattice.extent import TIMES, watched_times
from verify.lattice.recording import Progress, record
from verify.lattice.scene import Scene

Array = NDArray[np.float64]

CLEARANCE = 128
"""Sites beyond the crest on which pilots are compared."""

EXPECTED = 2
"""Pilots that a plan usually needs: what their progress is measured against."""

THREADS = 2
"""Pilots that run at once: their kernels release the interpreter."""


class Pilots:
    """Runs of one scene with different steps and sizes, each done once.

    They are compared with each other and with the scene's own run on the ``compared`` sites on
    either side of c t, which hold the crest (its half-width is ``crest``), and at ``times``: there
    the discretisation's errors are largest.
    """

    def __init__(
        self, scene: Scene, wave: Wave, scheme: str, domain: str, crest: int, progress: Progress
    ) -> None:
        reach = crest + CLEARANCE if domain == "window" else scene.compared
        self.compared = min(scene.compared, reach)
        self.times = common_stops(scene) if domain == "window" else watched_times(scene)
        self._scene = replace(
            scene,
            tolerance=None,
            engine="stencil",
            scheme=scheme,
            domain=domain,
            snapshots=self.times,
            observables=(),
            compared=self.compared,
            step=1.0,
            sites=1,
        )
        self._wave, self._progress = wave, progress
        self._shares: dict[tuple[float, int], float] = {}
        self._done: dict[tuple[float, int], list[Array] | None] = {}

    def difference(self, one: tuple[float, int], other: tuple[float, int]) -> float:
        """Largest difference of y/eps between two runs (step, sites); infinite after a blow-up."""
        missing = [key for key in (one, other) if key not in self._done]
        with ThreadPoolExecutor(THREADS) as pool:
            self._done.update(zip(missing, pool.map(self._strains, missing), strict=True))
        second = self._done[other]
        return float("inf") if second is None else self.distance(second, one)

    def distance(self, strains: Sequence[Array], pilot: tuple[float, int]) -> float:
        """Largest difference of y/eps between strains at ``times`` and those of a pilot.

        They may extend beyond the pilots' compared sites. Infinite without a pilot that came to
        its end.
        """
        known = self._done.get(pilot)
        if known is None:
            return float("inf")
        rows = zip(known, map(self._crest_of, strains), strict=True)
        return max(float(np.max(np.abs(a - b))) for a, b in rows) / self._scene.eps

    def errors(self, sites: int) -> tuple[list[float], list[float]]:
        """Steps done with that size, and their differences to the shortest of them."""
        steps = sorted((step for step, size in self._done if size == sites), reverse=True)
        *longer, shortest = steps
        return longer, [self.difference((step, sites), (shortest, sites)) for step in longer]

    def _crest_of(self, strain: Array) -> Array:
        beyond = strain.size // 2 - self.compared
        return strain[beyond : strain.size - beyond]

    def _strains(self, key: tuple[float, int]) -> list[Array] | None:
        step, sites = key
        samples = StrainSamples(self.times)
        scene = replace(self._scene, step=step, sites=sites)
        recording = record(scene, self._wave, [samples], lambda share: self._tell(key, share))
        return None if recording.march.blow_up else samples.samples

    def _tell(self, key: tuple[float, int], share: float) -> None:
        self._shares[key] = share
        self._progress(min(1.0, sum(self._shares.values()) / EXPECTED))


def common_stops(scene: Scene) -> tuple[float, ...]:
    """The snapshots, and some of the times at which each window of the scene stops anyway."""
    moves = [t for t in window_moves(scene) if t < scene.end]
    every = max(1, len(moves) // TIMES)
    return tuple(sorted({*moves[::every], *scene.snapshots}))
