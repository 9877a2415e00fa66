"""Runs of a scene's wave cell by cell, for `lattice.refine` to judge by step and domain."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.schemes import scheme_named
from longwave.lattice.trial import (
    DRIVEN_SHARE,
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
from longwave.scenes.engines.domain_plan import (
    AROUND,
    SCHEME,
    WIDER,
    ComparedCells,
    DomainPlan,
    longest_step,
    part_of,
    round_up,
    sites_of,
)
from longwave.scenes.engines.recorders import Samples, exact_times
from longwave.scenes.engines.run_record import UnfinishedRun
from longwave.scenes.engines.stated_run import run_from
from longwave.scenes.engines.stepped_cells import (
    SteppedCells,
    WindowCells,
    sees_all_cells,
    tell_energies,
)
from longwave.scenes.engines.window import (
    LARGEST_MISFIT,
    SIZE_RATIO,
    WINDOW_DECAY,
    WINDOW_SAFETY,
    FedWave,
    judged_times,
    widened,
    window_moves,
)

Array = NDArray[np.float64]

STEP_RATIO = 0.8
"""Step of a control run, in units of the one before it."""

ALIKE = 1e-3
"""By what share data may be larger or steeper elsewhere than on a part that stands for all."""

CLEARANCE = 128
"""Cells beyond the wave on which runs of a scout are compared."""

FEED_SHARE = 0.3
"""Most of the tolerance that is left to it."""

MISFED_GROWTH = 1.4
"""Factor on a window whose feed missed the lattice by too much: such a run ends early."""

FEED_SAFETY = 2.0
"""Factor on what a feed misses the lattice by: half of it runs on to the rear, past the compared
cells, at each move anew."""


class SiteEngine(StepSearch):
    """Runs of a scene's wave cell by cell, in windows or on causal rings.

    The scene has times of the lattice. Values are what is compared, in units of the wave's scale,
    and its rate: an error that passes through 0 at one of the times does not seem to be none. The
    payload is a `RunRecord`; ``metered`` holds what the wave's meter gave, by step. Of the compared
    cells only those ``judged`` are, if they are given.
    """

    decay = WINDOW_DECAY

    def __init__(
        self, scene: Scene, domains: DomainPlan, judged: ComparedCells | None = None
    ) -> None:
        self.scene, self.domains = scene, domains
        wave, self.times = domains.wave, domains.times
        self._scheme = scheme_named(scene.target.scheme) if scene.target.scheme else SCHEME
        self._fields = len(wave.lattice.fields)
        self._fades = not sees_all_cells(scene)
        self.amplifies_rounding = wave.amplifies_rounding(self.times[0])
        self.unstable = 1 if wave.watches_strains else StepSearch.unstable
        self.judged = judged or domains.compared
        self.metered: dict[float, Array] = {}
        longest = longest_step(domains.fastest, wave.frequency, self._scheme)
        longest = min(
            longest, DRIVEN_SHARE * wave.lattice.driven_within(self.times[0], self.times[:2][-1])
        )
        self._ring = float(sites_of(domains.ends()))
        self._misfed, self._widened = domains.window is None, 1.0
        allowed = FEED_SHARE * scene.target.tolerance / FEED_SAFETY
        self._largest_misfit = min(LARGEST_MISFIT, allowed)
        stops = np.array(self.times)
        if domains.window is not None:
            self.kinds, self.safety = ("step", "domain"), WINDOW_SAFETY
            fed = FedWave(domains, domains.window)
            stops = np.unique([*self.times, *(t for t in window_moves(fed) if t < self.times[-1])])
        super().__init__(self._scheme.order, longest, stops, float(domains.window or self._ring))
        self._first = replace(self._first, causal=domains.window is None)
        self.expected = domains.expected

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run in a window of that size, or on a ring as wide as it must be or a little wider.

        On a ring observables are always seen, but for nudged data: any run may become a control.
        Where a window's feed misses the lattice by too much, all windows are wider from then on,
        or rings. Raises ValueError for what would take too long.
        """
        while True:
            trial = self._run(choices, shown, progress)
            feed = trial.payload.attrs.get("feed_mismatch", 0.0)
            if not feed > self._largest_misfit:
                return replace(trial, common_error=FEED_SAFETY * feed)
            self._widened *= MISFED_GROWTH
            self._misfed = self._widened * self._first.size >= self._ring
            wider = round_up(self._widened * choices.size)
            self.domains.check_wider(None if self._misfed else wider)

    def _run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        wave, ends = self.domains.wave, (self.times[0], self.times[-1])
        looked = (shown or self._is_ring(choices)) and not choices.nudged
        cells = self._cells(choices, looked)
        judged = Samples(self.times, lambda view: view.judged(0, self.judged))
        around = Samples(ends[1:], lambda view: view.judged(AROUND, self.judged))
        energies = Samples(ends, lambda view: np.array(view.energy))
        witnesses = [judged, around, energies]
        limit, largest = self.domains.limit(cells.ring), float(np.max(np.abs(cells.ring.f)))
        metered = Samples(self.times)
        meter = wave.disorder.meter(cells.ring) if wave.disorder is not None else None
        if meter is not None:
            metered = Samples(self.times, lambda view: np.array(meter(*view.state.arrays)))
            witnesses.append(metered)
        try:
            run, stopped = run_from(cells, None, progress, witnesses), False
        except UnfinishedRun as stop:
            run, stopped = stop.record, True
        if not choices.nudged:
            self.metered[choices.step] = np.array(metered.samples)
        if metered.samples:
            tell_energies(run, float(metered.samples[0][-1]), float(metered.samples[-1][-1]))
        elif wave.lattice.conserves_energy and wave.losses is None and self._is_ring(choices):
            tell_energies(run, float(energies.samples[0]), float(energies.samples[-1]))
        values = np.array(judged.samples)
        done = len(values) == len(self.times) or stopped
        sound = done and bool(np.all(np.abs(values) <= limit))
        largest /= wave.scale
        if sound:
            largest = max(largest, float(np.max(np.abs(values[:, 0]))))
        rounding = rounding_error(largest, run.attrs["force_evaluations"])
        if sound:
            rounding += clock_error(values, wave.speed, (self.times[0], self.times[-1]))
        trial = Trial(
            choices,
            values if sound else None,
            self.work(choices),
            float(run.attrs["seconds"]),
            rounding,
            run,
            looked,
            around=around.samples[0] if sound and not stopped else None,
        )
        if stopped:
            raise StoppedTrial(trial)
        return trial

    def coarse_engine(self) -> SiteEngine:
        """The same about the wave alone in windows, seen less often, if that saves cells."""
        domains = self.domains
        if domains.window is None or domains.extent is None:
            return self
        low, high = domains.extent
        near = math.ceil(max(-low, high, 0.0)) + CLEARANCE
        if near >= domains.compared.reach[0]:
            return self
        scene = replace(self.scene, observables=())
        times = judged_times(FedWave(domains, domains.window), (self.times[0], *exact_times(scene)))
        compared = replace(domains.compared, reach=(near,))
        return SiteEngine(scene, DomainPlan(domains.wave, compared, times, domains.tolerance))

    def parts(self) -> tuple[SiteEngine, SiteEngine] | None:
        """Engines of a part that stands for all cells, and of all of them, judged there.

        None where there is none: the data must be no larger, nor steeper, anywhere than there.
        """
        domains = self.domains
        part = part_of(domains.wave, domains.compared, domains.times, domains.signals)
        if part is None:
            return None
        inner = DomainPlan(domains.wave, part, domains.times, domains.tolerance)
        if not np.all(domains.sizes <= (1.0 + ALIKE) * inner.sizes):
            return None
        within = SiteEngine(replace(self.scene, observables=()), inner)
        return within, SiteEngine(self.scene, domains, part)

    def _is_ring(self, choices: Choices) -> bool:
        return choices.causal or self._misfed

    def _cells(self, choices: Choices, looked: bool) -> SteppedCells:
        observables = self.scene.observables if looked else ()
        scheme = self._scheme.name
        if not self._is_ring(choices):
            size = round_up(self._widened * choices.size)
            stated = Discretisation(choices.step, "window", size, scheme)
            plan = replace(self.scene, numerics=stated, observables=observables)
            return WindowCells(plan, self.domains, choices.nudged)
        least = self._ring if choices.causal else self._first.size
        ends = self.domains.ends(WIDER if choices.size > least else 0)
        closes = self.domains.wave.watches_strains and self.domains.room  # others always do
        domain = "closed_ring" if closes else "ring"
        stated = Discretisation(choices.step, domain, sites_of(ends), scheme)
        plan = replace(self.scene, numerics=stated, observables=observables)
        return SteppedCells(plan, self.domains, ends, choices.nudged, self._fades)

    def _sized(self, choices: Choices, cells: float) -> Choices:
        """With a window of that many cells, or a ring if that takes fewer."""
        if self._widened * cells >= self._ring:
            return replace(choices, size=self._ring, causal=True)
        return replace(choices, size=float(round_up(cells)))

    def metered_before(self, step: float) -> Array:
        """What the meter gave in the run with the next longer step; nan where there is none."""
        longer = [one for one in self.metered if one > step]
        found = self.metered[min(longer)] if longer else np.empty(0)
        wanted = self.metered[step]
        return found if found.shape == wanted.shape else np.full_like(wanted, np.nan)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step, a wider window; a ring varies with the step.

        It is wider than it must be, or as it must be if it was wider before.
        """
        if "step" in kinds:
            step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
            choices = replace(choices, step=step)
            if choices.causal:
                wider = WIDER if choices.size == self._ring else 0
                choices = replace(choices, size=self._ring + wider)
        if "domain" in kinds and not choices.causal:
            choices = self._sized(choices, SIZE_RATIO * choices.size)
        return choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """A shorter step, on the ring as it must be; a wider window."""
        if kind == "step":
            found = super().improved(choices, kind, excess)
            return replace(found, size=self._ring) if choices.causal else found
        if choices.causal:
            return choices
        return self._sized(choices, widened(choices.size, excess, self.decay))

    def work(self, choices: Choices) -> float:
        """Forces on fields of cells."""
        cells = choices.size if self._is_ring(choices) else self._widened * choices.size
        return super().work(choices) * self._scheme.stages * cells * self._fields
