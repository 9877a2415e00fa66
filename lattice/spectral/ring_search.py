"""The search for the step and the points of a ring, shared by all rings."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Any

from longwave.lattice.spectral.evolution import STEPS_PER_CHECK, RunawayError, SamplingError
from longwave.lattice.spectral.exponential import ORDER
from longwave.lattice.trial import LEAST_FACTOR, STEP_RATIO, Choices, Engine, Kind, Progress, Trial

SCHEME = "exponential_adams"
"""Name of the scheme of all rings."""

RESOLVED_ANGLE = 1.0
"""Longest step that resolves the difference between a ring's lattices (one for each x mod 1), in
units of the time in which the phase of a wave of wavenumber 2 pi changes by one radian."""

ALIKE = 0.2
"""Largest unresolved difference between a ring's lattices, as a fraction of the tolerance. While
the nonlinear part turns the phase of a typical wave by one radian, the lattices' strains separate
by 0.02 to 0.4 times the spread of their energies, in units of the largest strain: measured on 30
scenes of all waves, with |y| from 0.3 to 0.63, as `searches/estimates.py` draws them."""

TAIL_SHARE = 0.1
"""Largest tail of the spectrum accepted in a run, as a fraction of the tolerance."""

DENSITY_RATIO = 1.25
"""Number of points of a control run, divided by that of the run before it. With 1.15, two samplings
of about two points a site agreed on an error above their estimate."""

LOSS_TIME_SPREAD = 0.01
"""Largest relative difference, apart from the interval between checks, of the times at which the
fields of three runs run away, if the cause is physical and not the step."""


def resolving_step(speed: float) -> float:
    """Return the longest step, at the ring's ``speed``, that tells its lattices apart."""
    return RESOLVED_ANGLE / (2.0 * math.pi * speed)


class SpectralSearch(Engine):
    """Base of engines that run a ring from ``begin``, in a frame of ``speed``, for `refine`.

    A run whose spectrum's tail rises is restarted with more points. A step that is too long lets
    short waves grow, however dense the points. Growth counts as physical if it happens at the same
    time with other steps, or at the start.
    """

    threads = 1
    order = ORDER
    unstable = 10
    step_ratio = STEP_RATIO
    """Step of a control run, as a fraction of the step of the run before it."""
    least_factor = LEAST_FACTOR
    """Least ratio of a step to the step of the previous choices."""

    def __init__(self, begin: float, duration: float, speed: float, tolerance: float) -> None:
        self._begin, self._duration, self._tolerance = begin, duration, tolerance
        self._resolving = resolving_step(speed) if speed else math.inf
        self._density, self._lattice_spread = 1.0, 0.0
        self._loss_times: list[float] = []

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """Make a run, with more points if the spectrum's tail needs them."""
        density, retry = self._density, True
        while retry:
            try:
                return self._run(choices, progress)
            except SamplingError:
                retry = self._add_points(choices)
            except RunawayError as error:
                self._handle_loss(error, choices.step)
                break
        self._density = density
        return Trial(choices, None, self.work(choices), 0.0, 0.0, None)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return choices with a shorter step, or more points, or both, as ``kinds`` say."""
        if "step" in kinds:
            step, start = self.step_ratio * choices.step, self.step_ratio * choices.start
            choices = replace(choices, step=step, start=start)
        if "sampling" in kinds:
            choices = replace(choices, finer=DENSITY_RATIO * choices.finer)
        return choices

    def taken(self, choices: Choices) -> float:
        """Return the chosen step."""
        return choices.step

    def work(self, choices: Choices) -> float:
        """Return the cost of a run: steps times points times log2(points)."""
        points = self.points(choices)
        return self._duration / choices.step * points * math.log2(points + 2.0)

    @property
    def _must_resolve(self) -> bool:
        """Whether the ring's lattices differ so much that the step must resolve the difference."""
        return self._lattice_spread > ALIKE * self._tolerance

    def _unresolved_error(self, choices: Choices) -> float:
        """Return the error due to the difference of the ring's lattices; 0 for resolving steps."""
        return 0.0 if choices.step <= self._resolving else self._lattice_spread

    def _shorter(self, choices: Choices, excess: float) -> Choices:
        """Return choices with a shorter step, whose error ~ step^order is smaller by ``excess``.

        The initial step is shortened by the same factor if the error is finite.
        """
        factor = max(self.least_factor, 0.9 * excess ** (-1.0 / ORDER))
        start = factor * choices.start if math.isfinite(excess) else choices.start
        return replace(choices, step=factor * choices.step, start=start)

    def _lost_again(self, error: RunawayError, step: float) -> bool:
        """Return whether fields run away for any step: at the start, or when two other runs did."""
        elapsed = error.t - self._begin
        resolution = LOSS_TIME_SPREAD * elapsed + STEPS_PER_CHECK * step
        agree = [abs(t - elapsed) <= resolution for t in self._loss_times]
        self._loss_times = [*self._loss_times[-1:], elapsed]
        return elapsed == 0.0 or (elapsed > 2 * STEPS_PER_CHECK * step and agree == [True, True])

    def _run(self, choices: Choices, progress: Progress) -> Trial:
        """Make a run with the current density of points."""
        raise NotImplementedError

    def points(self, choices: Choices) -> float:
        """Return the number of points for these choices."""
        raise NotImplementedError

    def _add_points(self, choices: Choices) -> bool:
        """Increase the density of points; return False if that is not possible."""
        raise NotImplementedError

    def _handle_loss(self, error: RunawayError, step: float) -> None:
        """Raise an error if the fields run away whatever the step."""
        raise NotImplementedError


def run_facts(
    trial: Trial, steps: int, evaluations: int, sites: int, blow_up: str
) -> dict[str, Any]:
    """Return a run's record: engine, scheme, step, numbers of steps and evaluations, blow-up."""
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
