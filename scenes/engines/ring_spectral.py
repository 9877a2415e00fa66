"""Runs of a scene's ring of cells by the spectral engine, for `lattice.refine` to judge.

The data are those of the run site by site, on a ring on which no compared cell sees the seam. They
are taken on as few points as hold them, which for a long wave is far fewer than one a cell, and at
most on the cells themselves, where the ring is the lattice exactly, whatever the data are. What is
compared stands at the cells, to which the Fourier series is continued.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.spectral.field_ring import FieldRing, fast_count
from longwave.lattice.spectral.ring_search import run_facts
from longwave.lattice.spectral.spectral_integration import FieldComparison, FieldRingEngine
from longwave.lattice.state import State
from longwave.lattice.trial import Trial
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import AROUND, WIDER, DomainPlan, Ends, sites_of
from longwave.scenes.engines.recorders import Variables, build_recorders
from longwave.scenes.engines.ring_cost import USUAL_RUNS, search_cost
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.engines.stepped_cells import CellView, SteppedCells, tell_energies
from longwave.support.checkpoint import Memory
from longwave.support.request_limits import ExpectedCost, check_request

SECONDS_PER_WORK = 1e-8
"""For a field, per step, point and log2(points)."""

LONGER = 2.5
"""First step of a carrier's wave, in units of what a ring's own waves call for: with it, the error
of the step is a thirtieth of the tolerance or less (the shipped Peregrine wave on a dimer)."""

BYTES_PER_POINT = 500.0
"""For a field: the engine's modes, tables and past values."""


class SpectralRuns:
    """Runs of a scene's wave on spectral rings: the engine that has them, and their records.

    The scene has times of the lattice, and states how often it is looked at. The ring is the least
    that is causal; one that is wider is so by `WIDER` cells along each axis. Raises ValueError,
    before anything large is made, for what would take too much memory or too long, and for a
    lattice that is not the same in all cells.
    """

    def __init__(self, scene: Scene, domains: DomainPlan) -> None:
        self.scene, self.domains, self.times = scene, domains, domains.times
        wave, lattice = domains.wave, domains.wave.lattice
        self._held: dict[tuple[float, ...], SteppedCells] = {}
        self._states: dict[bool, FieldRing] = {}
        state = self._state_of(wider=False)
        ring = self._held[state.circumferences].ring
        sight = FieldComparison(
            lambda state: self._view(state).judged(),
            wave.scale,
            at_sites=True,
            stored=self._kept,
            around=lambda state: self._view(state).judged(AROUND),
            limit=domains.limit(ring),
            wider=self._wider,
        )
        self.engine = FieldRingEngine(
            ring.lattice,
            state,
            np.array(domains.times),
            (wave.speed, *(0.0,) * (lattice.dimension - 1)),
            scene.target.tolerance,
            sight,
            LONGER if wave.frequency else 1.0,
        )
        self.engine.amplifies_rounding = wave.amplifies_rounding(self.times[0])
        self.expected = self._expected()
        check_request(
            f"scene of {sites_of(self._ends(wider=True)):.3g} cells on a spectral ring",
            self.expected,
            "take a larger eps, end earlier or compare fewer cells",
        )

    def _expected(self) -> ExpectedCost:
        """What the search takes, by its first run."""
        engine, fields = self.engine, len(self.domains.wave.lattice.fields)
        cells = float(sites_of(self._ends(wider=True)))
        kept = math.prod(2.0 * reach + 1.0 for reach in self.domains.compared.reach)
        found = search_cost(self.domains.wave.lattice, cells, 0.0, 1, kept * len(self.times))
        work, points = engine.work(engine.first()), engine.points(engine.first())
        return replace(
            found,
            seconds=found.seconds + USUAL_RUNS * SECONDS_PER_WORK * fields * work,
            memory_bytes=found.memory_bytes + BYTES_PER_POINT * fields * points,
        )

    def _wider(self) -> tuple[NumericLattice, FieldRing]:
        state = self._state_of(wider=True)
        return self._held[state.circumferences].ring.lattice, state

    def _ends(self, wider: bool) -> list[Ends]:
        """First and last cell along each axis, with as many between them as transform fast.

        A wave that ends does so on the ring, for its data to be smooth over the seam.
        """
        ends = self.domains.ends()
        low, high = self.domains.wave.support(self.times[0])
        if math.isfinite(high - low):
            ends[0] = min(ends[0][0], math.floor(low)), max(ends[0][1], math.ceil(high))
        counts = [fast_count(high + 1 - low) for low, high in ends]
        firsts = [low for low, _ in ends]
        if wider:
            counts = [fast_count(count + WIDER) for count in counts]
            firsts = [low - WIDER // 2 for low in firsts]
        return [(low, low + count - 1) for low, count in zip(firsts, counts, strict=True)]

    def _state_of(self, wider: bool) -> FieldRing:
        """The data on all cells of a ring."""
        if wider not in self._states:
            cells = SteppedCells(self.scene, self.domains, self._ends(wider))
            ring, left = cells.ring, tuple(float(low) for low, _ in cells.ends)
            circumferences = tuple(map(float, ring.f.shape[1:]))
            self._held[circumferences] = cells
            self._states[wider] = FieldRing(ring.t, left, circumferences, ring.f, ring.v)
        return self._states[wider]

    def _view(self, state: FieldRing) -> CellView:
        cells = self._held[state.circumferences]
        whole = state.sampled(cells.ring.f.shape[1:])
        return cells.view(State(state.t, whole.f, whole.v))

    def _kept(self, state: FieldRing) -> Memory:
        """What observables measure, at their times; the energy at the first and the last."""
        view = self._view(state)
        seen = {
            item.dimension: item.measured(view)
            for item in build_recorders(self.scene)
            if item.moments.due(state.t)
        }
        if state.t not in (self.times[0], self.times[-1]):
            return {"seen": seen}
        return {"seen": seen, "energy": view.energy}

    def record_of(self, trial: Trial) -> RunRecord | None:
        """The record of a run; None if it broke down before it was seen."""
        if trial.payload is None:
            return None
        ring, kept = trial.payload
        recorders = build_recorders(self.scene)
        variables: Variables = {}
        for item in recorders:
            for t, row in zip(self.times, kept, strict=True):
                if item.dimension in row["seen"]:
                    item.add(t, row["seen"][item.dimension])
            variables |= item.variables()
        steps, evaluations = ring.integrator.steps, ring.integrator.evaluations
        told = run_facts(trial, steps, evaluations, math.prod(ring.start.counts), "")
        reach = self.domains.compared.reach
        record = RunRecord(self.scene, reach, self.scene.snapshots, variables, told)
        if self.domains.wave.lattice.conserves_energy:
            tell_energies(record, kept[0]["energy"], kept[-1]["energy"])
        return record
