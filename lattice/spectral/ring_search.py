"""The search for the step and the points of a ring: the parts that are alike on all rings."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Any, Self

from longwave.lattice.spectral.evolution import WATCH, RunawayError, SamplingError
from longwave.lattice.spectral.exponential import ORDER
from longwave.lattice.trial import LEAST_FACTOR, STEP_RATIO, Choices, Kind, Progress, Trial

SCHEME = "exponential_adams"
"""The one scheme of a ring."""

TURNED = 1.0
"""Longest step, in units of the time in which a wave of number 2 pi turns by one radian, that shows
how the lattices differ."""

ALIKE = 0.2
"""Share of the tolerance by which the lattices of a ring may differ unseen. While the nonlinear
part turns the phase of a typical wave by one, their strains part by 0.02 to 0.4 times the spread of
their energies, in units of the largest strain: measured on 30 scenes of all waves, a |y| from 0.3
to 0.63, as `searches/estimates.py` draws them."""

TAIL_SHARE = 0.1
"""Bound of the spectrum's tail, in units of the tolerance."""

DENSITY_RATIO = 1.25
"""Points of a control run, in units of those of the run before it. With 1.15, two samplings about
two points a site agreed on an error above their estimate."""

RUN_AWAY = 0.01
"""If the times at which three runs lose the fields differ less, in units of the time since the
beginning, and beside what the watch resolves, it is not the step that does it."""


def resolving_step(speed: float) -> float:
    """The longest step that shows how the lattices of a ring differ that moves at ``speed``."""
    return TURNED / (2.0 * math.pi * speed)


class SpectralRingSearch:
    """An engine that runs a ring from ``begin`` on, in a frame of ``speed``, for `refine` to judge.

    A run whose spectrum's tail rises is begun again with more points. A step that is too long lets
    short waves grow, however densely they are sampled: fields that run away by themselves are told
    from it by doing so at the same time with another step, or at first.
    """

    threads = 1
    order = ORDER
    unstable = 10
    step_ratio = STEP_RATIO
    """Step of a control run, in units of that of the run before it."""
    least_factor = LEAST_FACTOR
    """Least factor on a step from one choice to the next."""

    def __init__(self, begin: float, duration: float, speed: float, tolerance: float) -> None:
        self._begin, self._duration, self._tolerance = begin, duration, tolerance
        self._telling = resolving_step(speed) if speed else math.inf
        self._density, self._alike = 1.0, 0.0
        self._ran_away: list[float] = []

    def coarse_engine(self) -> Self:
        """None: a ring must hold what it holds."""
        return self

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run, with more points if the spectrum's tail calls for them."""
        kept, sampled = self._density, True
        while sampled:
            try:
                return self._run(choices, progress)
            except SamplingError:
                sampled = self._made_denser(choices)
            except RunawayError as error:
                self._tell_loss(error, choices.step)
                break
        self._density = kept
        return Trial(choices, None, self.work(choices), 0.0, 0.0, None)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step, more points."""
        if "step" in kinds:
            step, start = self.step_ratio * choices.step, self.step_ratio * choices.start
            choices = replace(choices, step=step, start=start)
        if "sampling" in kinds:
            choices = replace(choices, finer=DENSITY_RATIO * choices.finer)
        return choices

    def taken(self, choices: Choices) -> float:
        """The step that was chosen."""
        return choices.step

    def work(self, choices: Choices) -> float:
        """Steps times points times their logarithm."""
        points = self.points(choices)
        return self._duration / choices.step * points * math.log2(points + 2.0)

    @property
    def _must_tell(self) -> bool:
        """Whether the ring's lattices part too far for a step that does not show it."""
        return self._alike > ALIKE * self._tolerance

    def _unshown(self, choices: Choices) -> float:
        """By how much the lattices part and steps so long do not show it."""
        return 0.0 if choices.step <= self._telling else self._alike

    def _shorter(self, choices: Choices, excess: float) -> Choices:
        """The step by the law of the order; a start's step keeps its share if that law is known."""
        factor = max(self.least_factor, 0.9 * excess ** (-1.0 / ORDER))
        start = factor * choices.start if math.isfinite(excess) else choices.start
        return replace(choices, step=factor * choices.step, start=start)

    def _lost_again(self, error: RunawayError, step: float) -> bool:
        """Whether the fields run away whatever the step: at first, or when they did before."""
        passed = error.t - self._begin
        apart = RUN_AWAY * passed + WATCH * step
        alike = [abs(t - passed) <= apart for t in self._ran_away]
        self._ran_away = [*self._ran_away[-1:], passed]
        return passed == 0.0 or (passed > 2 * WATCH * step and alike == [True, True])

    def _run(self, choices: Choices, progress: Progress) -> Trial:
        """A run with those points."""
        raise NotImplementedError

    def points(self, choices: Choices) -> float:
        """The number of points that the choices mean."""
        raise NotImplementedError

    def _made_denser(self, choices: Choices) -> bool:
        """Take more points from now on, if that may be."""
        raise NotImplementedError

    def _tell_loss(self, error: RunawayError, step: float) -> None:
        """Raise what is to be said of fields that run away whatever the step."""
        raise NotImplementedError


def run_facts(
    trial: Trial, steps: int, evaluations: int, sites: int, blow_up: str
) -> dict[str, Any]:
    """What a run's record tells of it."""
    return {
        "engine": "spectral",
        "scheme": SCHEME,
        "order": ORDER,
        "steps": steps,
        "force_evaluations": evaluations,
        "sites": sites,
        "step": trial.choices.step,
        "seconds": trial.seconds,
        "blow_up": blow_up,
    }
