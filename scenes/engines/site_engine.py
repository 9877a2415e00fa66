"""Engine that runs a scene's wave cell by cell; `lattice.refine` chooses its step and domain."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from longwave.lattice.schemes import scheme_named
from longwave.lattice.trial import (
    Choices,
    Kind,
    Progress,
    StepSearch,
    StoppedTrial,
    Trial,
    clock_error,
    rounding_error,
    shorter_step,
)
from longwave.scenes.description.numerics import Discretisation
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import window
from longwave.scenes.engines.domain_plan import (
    EXTRA_CELLS,
    OUTER_CELLS,
    SCHEME,
    ComparedCells,
    DomainPlan,
    count_cells,
    longest_step,
    representative_cells,
    round_up,
)
from longwave.scenes.engines.recorders import Samples, exact_times
from longwave.scenes.engines.run_record import UnfinishedRun
from longwave.scenes.engines.stated_run import run_from
from longwave.scenes.engines.stepped_cells import (
    SteppedCells,
    WindowCells,
    add_energy_drift,
    measures_all_cells,
)
from longwave.scenes.engines.window import LARGEST_MISFIT
from longwave.support.real_arrays import Array

STEP_RATIO = 0.8
"""Ratio of a control run's step to the step of the run before it."""

SIMILARITY_FRACTION = 1e-3
"""Largest relative excess of the whole wave's data over a part's data at which the part counts as
representative."""

CLEARANCE_CELLS = 128
"""Number of cells beyond the wave's extent that the coarse engine compares."""

FEED_FRACTION = 0.3
"""Largest fraction of the tolerance allowed for the error of a window's feed."""

MISFIT_GROWTH = 1.4
"""Factor on the size of a window after a run whose feed did not match the lattice."""

FEED_SAFETY = 2.0
"""Factor on a feed's mismatch in the error estimate: at each move, half of the mismatch travels to
the rear, past the compared cells."""


class SiteEngine(StepSearch):
    """Runs of a scene's wave cell by cell, in windows or on causal rings.

    The scene is in lattice times. A trial's values are the compared quantities and their rates, in
    units of the wave's scale; the rates reveal an error that happens to vanish at one of the times.
    A trial's payload is a `RunRecord`. ``metered`` maps a run's step to its `PulseMeter` readings.
    Runs are compared on the cells ``judged``, by default all compared cells.
    """

    decay = window.WINDOW_DECAY

    def __init__(
        self, scene: Scene, domains: DomainPlan, judged: ComparedCells | None = None
    ) -> None:
        self.scene, self.domains = scene, domains
        wave, self.times = domains.wave, domains.times
        self._scheme = scheme_named(scene.target.scheme) if scene.target.scheme else SCHEME
        self._fields = len(wave.lattice.fields)
        self._fades = not measures_all_cells(scene)
        self.amplifies_rounding = wave.amplifies_rounding(self.times[0])
        self.unstable = 1 if wave.watches_strains else StepSearch.unstable
        self.judged = judged or domains.compared
        self.metered: dict[float, Array] = {}
        longest = longest_step(domains.fastest, wave.frequency, self._scheme)
        longest = min(longest, domains.driven_step)
        self._ring = float(count_cells(domains.ends()))
        self._uses_rings, self._widened = domains.window is None, 1.0
        allowed = FEED_FRACTION * scene.target.tolerance / FEED_SAFETY
        self._largest_misfit = min(LARGEST_MISFIT, allowed)
        stops = np.array(self.times)
        if domains.window is not None:
            self.kinds, self.safety = ("step", "domain"), window.WINDOW_SAFETY
            fed = window.FedWave(domains, domains.window)
            moves = (t for t in window.window_moves(fed) if t < self.times[-1])
            stops = np.unique([*self.times, *moves])
        super().__init__(self._scheme.order, longest, stops, float(domains.window or self._ring))
        self._first = replace(self._first, causal=domains.window is None)
        self.expected = domains.expected

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """Run the wave in a window of the chosen size, or on a causal or slightly wider ring.

        Observables are recorded if ``shown`` and on every ring, as any run there may become the
        final one, but not for nudged data. If a window's feed does not match the lattice, this and
        all later windows are made wider, or replaced by rings. Raises ValueError for a run that
        would take too long.
        """
        while True:
            trial = self._run(choices, shown, progress)
            feed = trial.payload.attrs.get("feed_mismatch", 0.0)
            if not feed > self._largest_misfit:
                return replace(trial, common_error=FEED_SAFETY * feed)
            self._widened *= MISFIT_GROWTH
            self._uses_rings = self._widened * self._first.size >= self._ring
            wider = round_up(self._widened * choices.size)
            self.domains.check_wider(None if self._uses_rings else wider)

    def _run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        wave, ends = self.domains.wave, (self.times[0], self.times[-1])
        records = (shown or self._is_ring(choices)) and not choices.nudged
        cells = self._cells(choices, records)
        judged = Samples(self.times, lambda view: view.judged(0, self.judged))
        around = Samples(ends[1:], lambda view: view.judged(OUTER_CELLS, self.judged))
        energies = Samples(ends, lambda view: np.array(view.energy))
        witnesses = [judged, around, energies]
        limit, largest = self.domains.limit(cells.ring), float(np.max(np.abs(cells.ring.f)))
        readings = Samples(self.times)
        meter = wave.disorder.meter(cells.ring) if wave.disorder is not None else None
        if meter is not None:
            readings = Samples(self.times, lambda view: np.array(meter(*view.state.arrays)))
            witnesses.append(readings)
        try:
            run, stopped = run_from(cells, None, progress, witnesses), False
        except UnfinishedRun as stop:
            run, stopped = stop.record, True
        if not choices.nudged:
            self.metered[choices.step] = np.array(readings.samples)
        if readings.samples:
            add_energy_drift(run, float(readings.samples[0][-1]), float(readings.samples[-1][-1]))
        elif wave.lattice.conserves_energy and wave.losses is None and self._is_ring(choices):
            add_energy_drift(run, float(energies.samples[0]), float(energies.samples[-1]))
        values = np.array(judged.samples)
        is_complete = len(values) == len(self.times) or stopped
        is_bounded = is_complete and bool(np.all(np.abs(values) <= limit))
        evaluations, largest = run.attrs["force_evaluations"], largest / wave.scale
        rounding = rounding_error(largest, evaluations)
        if is_bounded:
            largest = max(largest, float(np.max(np.abs(values[:, 0]))))
            rounding = rounding_error(largest, evaluations) + clock_error(values, wave.speed, ends)
        outer = around.samples[0] if is_bounded and not stopped else None
        compared, work = values if is_bounded else None, self.work(choices)
        seconds = float(run.attrs["seconds"])
        trial = Trial(choices, compared, work, seconds, rounding, run, records, around=outer)
        if stopped:
            raise StoppedTrial(trial)
        return trial

    def coarse_engine(self) -> SiteEngine:
        """Return an engine with smaller windows and fewer times, or this one if none is cheaper."""
        domains = self.domains
        if domains.window is None or domains.extent is None:
            return self
        low, high = domains.extent
        near = math.ceil(max(-low, high, 0.0)) + CLEARANCE_CELLS
        if near >= domains.compared.reach[0]:
            return self
        scene = replace(self.scene, observables=())
        fed, exact = window.FedWave(domains, domains.window), exact_times(scene)
        times = window.judged_times(fed, (self.times[0], *exact))
        compared = replace(domains.compared, reach=(near,))
        return SiteEngine(scene, DomainPlan(domains.wave, compared, times, domains.tolerance))

    def parts(self) -> tuple[SiteEngine, SiteEngine] | None:
        """Return the engines of a representative part and of all cells, both compared on the part.

        Returns None if no part is representative, that is, if the data elsewhere are larger or
        steeper than in the part.
        """
        domains = self.domains
        part = representative_cells(domains.wave, domains.compared, domains.times, domains.signals)
        if part is None:
            return None
        inner = DomainPlan(domains.wave, part, domains.times, domains.tolerance)
        if not np.all(domains.sizes <= (1.0 + SIMILARITY_FRACTION) * inner.sizes):
            return None
        within = SiteEngine(replace(self.scene, observables=()), inner)
        return within, SiteEngine(self.scene, domains, part)

    def _is_ring(self, choices: Choices) -> bool:
        return choices.causal or self._uses_rings

    def _cells(self, choices: Choices, records: bool) -> SteppedCells:
        def plan(domain: str, sites: int) -> Scene:
            stated = Discretisation(choices.step, domain, sites, self._scheme.name)
            observables = self.scene.observables if records else ()
            return replace(self.scene, numerics=stated, observables=observables)

        if not self._is_ring(choices):
            window_plan = plan("window", round_up(self._widened * choices.size))
            return WindowCells(window_plan, self.domains, choices.nudged)
        least = self._ring if choices.causal else self._first.size
        ends = self.domains.ends(EXTRA_CELLS if choices.size > least else 0)
        closes = self.domains.wave.watches_strains and self.domains.room  # others are always closed
        ring_plan = plan("closed_ring" if closes else "ring", count_cells(ends))
        return SteppedCells(ring_plan, self.domains, ends, choices.nudged, self._fades)

    def _sized(self, choices: Choices, cells: float) -> Choices:
        """Return the choices with a window of ``cells`` cells, or a ring if that is smaller."""
        if self._widened * cells >= self._ring:
            return replace(choices, size=self._ring, causal=True)
        return replace(choices, size=float(round_up(cells)))

    def metered_before(self, step: float) -> Array:
        """Return the meter's readings in the run with the next longer step; NaN if none."""
        longer = [other for other in self.metered if other > step]
        previous = self.metered[min(longer)] if longer else np.empty(0)
        current = self.metered[step]
        return previous if previous.shape == current.shape else np.full_like(current, np.nan)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return the choices of a control run, which reveals these ``kinds`` of error.

        The kind "step" takes a shorter step, on a ring of the other size; "domain" a wider window.
        """
        if "step" in kinds:
            step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
            choices = replace(choices, step=step)
            if choices.causal:
                wider = EXTRA_CELLS if choices.size == self._ring else 0
                choices = replace(choices, size=self._ring + wider)
        if "domain" in kinds and not choices.causal:
            choices = self._sized(choices, window.SIZE_RATIO * choices.size)
        return choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Return choices that divide this ``kind`` of error by the factor ``excess``."""
        if kind == "step":
            shorter = super().improved(choices, kind, excess)
            return replace(shorter, size=self._ring) if choices.causal else shorter
        if choices.causal:
            return choices
        return self._sized(choices, window.widened(choices.size, excess, self.decay))

    def work(self, choices: Choices) -> float:
        """Return the work of a run, in force evaluations on single fields of cells."""
        cells = choices.size if self._is_ring(choices) else self._widened * choices.size
        return super().work(choices) * self._scheme.stages * cells * self._fields
