"""A run by the spectral engine, with the step, the sampling and the domain that a tolerance needs.

Each of the three is measured by doubling. The time step and the sampling do not depend on the
circumference, so both are settled on the smallest ring: the step is halved, and the density of
points doubled, until the compared strains differ by less than their share of the tolerance. Then
the circumference is doubled until the difference says that its share is met, or until no signal
from the seam can reach the compared sites: then there is no error. At all times the tail of the
spectrum is watched; where it rises above the share of the sampling, the run is begun again
with twice the points.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import NDArray

from verify.exponential.halving import Halving, halve, sup_difference
from verify.lattice.ring_state import RingState
from verify.lattice.spectral import NotHyperbolicError, SamplingError, SpectralRing
from verify.lattice.spectral_data import Ring, RingData
from verify.lattice.spectral_scale import first_density, first_step
from verify.lattice.spectral_task import Estimates, SpectralCost, SpectralRun, SpectralTask

__all__ = ["SpectralRun", "SpectralTask", "spectral_run"]

Array = NDArray[np.float64]
Progress = Callable[[float], None]

STEP_SHARE, SAMPLING_SHARE, DOMAIN_SHARE = 0.25, 0.25, 0.5
"""Shares of the tolerance."""

DOMAIN_RATIO = (2.0, 16.0)
"""Doubling the domain divides its error by what was measured, but by no more than L^-4 says."""

UNMEASURED_RATIO = 4.0
"""The law L^-2 of a ring that is not closed, as long as there is one difference only."""

TINY = 1e-300
"""Keeps the ratio of two differences finite."""

SOFTENED = 3
"""Attempts in which waves cease to exist, after which it is not the step that does it."""

MOST_POINTS = 2**22
"""Points on the largest ring."""


class RingTooLargeError(ValueError):
    """A tolerance that needs more points than a ring may have."""


def spectral_run(task: SpectralTask, progress: Progress | None = None) -> SpectralRun:
    """Run the task to its tolerance.

    ``progress`` is called with the share of the work that is done, 0 .. 1, each attempt taken to
    cost as much as all before it. Raises RingTooLargeError if the tolerance cannot be met, and
    FloatingPointError if the lattice blows up.
    """
    return _Planner(task, progress).run()


@dataclass(frozen=True)
class _Attempt:
    states: tuple[RingState, ...]
    values: Array
    steps: int
    evaluations: int
    seconds: float

    @property
    def work(self) -> float:
        return float(self.evaluations) * self.states[0].y.size


class _Planner:
    """The search: the density it has come to, the initial rings, and the attempts so far."""

    def __init__(self, task: SpectralTask, progress: Progress | None) -> None:
        self._task, self._progress = task, progress
        width, duration = 2 * task.compared + 1, task.times[-1] - task.t0
        self._data = RingData(task.constants, task.wave, task.eps, task.t0, width, duration)
        self._density = first_density(task.wave, task.eps)
        self._rings: dict[int, Ring] = {}
        self._states: dict[tuple[Ring, int], RingState] = {}
        self._attempts: list[_Attempt] = []
        self._softened = 0

    def run(self) -> SpectralRun:
        tolerance, count = self._task.tolerance, self._data.smallest
        duration = self._task.times[-1] - self._task.t0
        start = first_step(self._task.constants, self._state(self._ring(count)), duration)
        halving = halve(lambda step: self._values(count, step), start, STEP_SHARE * tolerance)
        values, sampling = self._settle_sampling(count, halving)
        domain, ratio = self._settle_domain(count, halving.step, values)
        if self._progress is not None:
            self._progress(1.0)
        estimates = Estimates(halving.error, sampling, domain, ratio)
        states = self._attempts[-1].states
        return SpectralRun(self._task, states, halving.step, estimates, self._cost())

    def _settle_sampling(self, count: int, halving: Halving) -> tuple[Array, float]:
        """Double the density until that no longer matters; the values, and by how much it did."""
        bound, values = SAMPLING_SHARE * self._task.tolerance, halving.values
        while True:
            kept = self._density
            self._density = 2.0 * kept
            fine = self._values(count, halving.step)
            difference = sup_difference(fine, values)
            if difference <= bound:
                self._density = kept
                return values, difference
            values = fine

    def _settle_domain(self, count: int, step: float, values: Array) -> tuple[float, float]:
        """Double the ring until its share is met; the error, and the ratio that it comes from."""
        ratio, before = UNMEASURED_RATIO, None
        while not self._ring(count).causal:
            count *= 2
            fine = self._values(count, step)
            difference = sup_difference(fine, values)
            if before is not None:
                ratio = float(np.clip(before / max(difference, TINY), *DOMAIN_RATIO))
            if difference <= DOMAIN_SHARE * self._task.tolerance * (ratio - 1.0):
                return difference / (ratio - 1.0), ratio
            values, before = fine, difference
        return 0.0, math.inf

    def _values(self, count: int, step: float) -> Array:
        """The compared y/eps; the density grows until the tail keeps down, infinity if it cannot.

        A step that is too long lets short waves grow, however densely they are sampled. A lattice
        on which waves cease to exist is told from it by losing them again with shorter steps, or by
        its initial data.
        """
        kept = self._density
        while True:
            try:
                attempt = self._attempt(count, step)
            except SamplingError:
                self._density *= 2.0
            except FloatingPointError as error:
                if isinstance(error, NotHyperbolicError):
                    self._softened += 1
                    if error.t == self._task.t0 or self._softened >= SOFTENED:
                        raise
                self._density = kept
                return np.array([np.inf])
            else:
                self._attempts.append(attempt)
                return attempt.values

    def _attempt(self, count: int, step: float) -> _Attempt:
        task = self._task
        begun = time.perf_counter()
        tail = SAMPLING_SHARE * task.tolerance * task.eps
        where = self._ring(count)
        cutoff = self._data.absorbed(where)
        ring = SpectralRing(task.constants, self._state(where), step, tail, absorbed=cutoff)
        states = tuple(self._through(ring))
        values = [state.strain(task.sites(state.t)) / task.eps for state in states]
        seconds = time.perf_counter() - begun
        integrator = ring.integrator
        return _Attempt(states, np.array(values), integrator.steps, integrator.evaluations, seconds)

    def _through(self, ring: SpectralRing) -> Iterator[RingState]:
        t0, end = self._task.t0, self._task.times[-1]
        for t in self._task.times:
            yield ring.at(t)
            if self._progress is not None and end > t0:
                share = (t - t0) / (end - t0)
                self._progress(1.0 - 0.5 ** (len(self._attempts) + share))

    def _ring(self, count: int) -> Ring:
        if count not in self._rings:
            self._rings[count] = self._data.ring(count)
        return self._rings[count]

    def _state(self, ring: Ring) -> RingState:
        wanted = ring.circumference * self._density
        if wanted > MOST_POINTS:
            raise RingTooLargeError(f"a ring of more than {MOST_POINTS} points")
        points = 2 * int(ducc0.fft.good_size(math.ceil(wanted / 2.0), True))
        if (ring, points) not in self._states:
            self._states[ring, points] = self._data.state(ring, points)
        return self._states[ring, points]

    def _cost(self) -> SpectralCost:
        *before, last = self._attempts
        return SpectralCost(
            last.steps,
            last.states[0].y.size,
            last.evaluations,
            last.seconds,
            sum(attempt.work for attempt in before),
            sum(attempt.seconds for attempt in before),
        )
