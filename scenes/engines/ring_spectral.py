"""Runs of a scene's causal ring by the spectral engine, refined to a tolerance by `lattice.refine`.

The initial data are as in a run site by site, on a causal ring. They are sampled at as few
points as resolve them: far fewer than one a cell for a long wave, and at most one a cell, where the
spectral ring is exactly the lattice. Values are compared at the cells, by evaluating the Fourier
series there.
"""

import math

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.spectral.field_ring import FieldRing, fast_count
from longwave.lattice.spectral.ring_search import run_facts
from longwave.lattice.spectral.spectral_integration import FieldComparison, FieldRingEngine
from longwave.lattice.state import State
from longwave.lattice.trial import Trial
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import (
    EXTRA_CELLS,
    OUTER_CELLS,
    REMEDY,
    DomainPlan,
    Ends,
    count_cells,
)
from longwave.scenes.engines.recorders import build_recorders, recorded_variables
from longwave.scenes.engines.ring_cost import USUAL_RUNS, enlarged, search_cost
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.engines.stepped_cells import CellView, SteppedCells, add_energy_drift
from longwave.support.checkpoint import Memory
from longwave.support.request_limits import ExpectedCost, check_request

SECONDS_PER_WORK = 1e-8
"""Seconds per field and unit of work: one step of one point, times log2(points)."""

CARRIER_STEP_FACTOR = 2.5
"""Factor on the first step for a wave with a carrier, in units of the step chosen for other waves.
The step's error is then at most a thirtieth of the tolerance (shipped Peregrine wave, dimer)."""

BYTES_PER_POINT = 500.0
"""Bytes per field and point: modes, tables and past values of the engine."""


class SpectralRuns:
    """Runs of a scene's wave on spectral rings: the engine and the records of its runs.

    The scene is in lattice times and states the times of its looks. The ring is the smallest causal
    one; that of a control run has `EXTRA_CELLS` more cells on each axis. Raises ValueError, before
    any large array is made, for a run that would take too much memory or time, and for a lattice
    whose cells differ.
    """

    def __init__(self, scene: Scene, domains: DomainPlan) -> None:
        self.scene, self.domains, self.times = scene, domains, domains.times
        wave, lattice = domains.wave, domains.wave.lattice
        self._cells: dict[tuple[float, ...], SteppedCells] = {}
        self._states: dict[bool, FieldRing] = {}
        state = self._state_of(wider=False)
        ring = self._cells[state.circumferences].ring
        comparison = FieldComparison(
            lambda state: self._view(state).judged(),
            wave.scale,
            at_sites=True,
            stored=self._observed,
            around=lambda state: self._view(state).judged(OUTER_CELLS),
            limit=domains.limit(ring),
            wider=self._wider,
        )
        times, speeds = np.array(domains.times), (wave.speed, *(0.0,) * (lattice.dimension - 1))
        tolerance, factor = scene.target.tolerance, CARRIER_STEP_FACTOR if wave.frequency else 1.0
        self.engine = FieldRingEngine(
            ring.lattice, state, times, speeds, tolerance, comparison, factor
        )
        self.engine.amplifies_rounding = wave.amplifies_rounding(self.times[0])
        self.expected = self._expected()
        cells = count_cells(self._ends(wider=True))
        check_request(f"scene of {cells:.3g} cells on a spectral ring", self.expected, REMEDY)

    def _expected(self) -> ExpectedCost:
        """Return the expected cost of the search, extrapolated from its first run."""
        engine, fields = self.engine, len(self.domains.wave.lattice.fields)
        cells = float(count_cells(self._ends(wider=True)))
        compared = math.prod(2.0 * reach + 1.0 for reach in self.domains.compared.reach)
        cost = search_cost(self.domains.wave.lattice, cells, 0.0, 1, compared * len(self.times))
        work, points = engine.work(engine.first()), engine.points(engine.first())
        seconds = USUAL_RUNS * SECONDS_PER_WORK * fields * work
        return enlarged(cost, seconds, BYTES_PER_POINT * fields * points)

    def _wider(self) -> tuple[NumericLattice, FieldRing]:
        state = self._state_of(wider=True)
        return self._cells[state.circumferences].ring.lattice, state

    def _ends(self, wider: bool) -> list[Ends]:
        """Return the ends, along each axis, of a causal ring of FFT-friendly size.

        The ring contains any wave of finite extent; ``wider`` selects the ring of control runs.
        """
        ends = self.domains.ends()
        low, high = self.domains.wave.support(self.times[0])
        if math.isfinite(high - low):
            ends[0] = min(ends[0][0], math.floor(low)), max(ends[0][1], math.ceil(high))
        counts = [fast_count(high + 1 - low) for low, high in ends]
        firsts = [low for low, _ in ends]
        if wider:
            counts = [fast_count(count + EXTRA_CELLS) for count in counts]
            firsts = [low - EXTRA_CELLS // 2 for low in firsts]
        return [(low, low + count - 1) for low, count in zip(firsts, counts, strict=True)]

    def _state_of(self, wider: bool) -> FieldRing:
        """Return the initial data on all cells of the ring, or of the wider control ring."""
        if wider not in self._states:
            cells = SteppedCells(self.scene, self.domains, self._ends(wider))
            ring, left = cells.ring, tuple(float(low) for low, _ in cells.ends)
            circumferences = tuple(map(float, ring.f.shape[1:]))
            self._cells[circumferences] = cells
            self._states[wider] = FieldRing(ring.t, left, circumferences, ring.f, ring.v)
        return self._states[wider]

    def _view(self, state: FieldRing) -> CellView:
        cells = self._cells[state.circumferences]
        whole = state.sampled(cells.ring.f.shape[1:])
        return cells.view(State(state.t, whole.f, whole.v))

    def _observed(self, state: FieldRing) -> Memory:
        """Return observables due at a state, by time dimension; energy too at start and end."""
        view = self._view(state)
        rows = {
            recorder.dimension: recorder.measure(view)
            for recorder in build_recorders(self.scene)
            if recorder.moments.is_due(state.t)
        }
        if state.t not in (self.times[0], self.times[-1]):
            return {"seen": rows}
        return {"seen": rows, "energy": view.energy}

    def record_of(self, trial: Trial) -> RunRecord | None:
        """Return the record of a run; None if it broke down before it was measured."""
        if trial.payload is None:
            return None
        ring, rows = trial.payload
        recorders = build_recorders(self.scene)
        for recorder in recorders:
            for t, row in zip(self.times, rows, strict=True):
                if recorder.dimension in row["seen"]:
                    recorder.add(t, row["seen"][recorder.dimension])
        variables = recorded_variables(recorders)
        steps, evaluations = ring.integrator.steps, ring.integrator.evaluations
        attributes = run_facts(trial, steps, evaluations, math.prod(ring.start.counts), "")
        reach = self.domains.compared.reach
        record = RunRecord(self.scene, reach, self.scene.snapshots, variables, attributes)
        if self.domains.wave.lattice.conserves_energy:
            add_energy_drift(record, rows[0]["energy"], rows[-1]["energy"])
        return record
