"""Running a chain on a bench to the tolerance of what is watched, and what that is to cost."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.derive.symbols import number_value
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.integration import CellRingEngine, Comparison
from longwave.lattice.schemes import REDUCED_PHASE_6, scheme_named
from longwave.lattice.trial import DRIVEN_SHARE
from longwave.scenes.description.bench import MOST_READINGS, Bench
from longwave.scenes.description.losses import without_losses
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import MOST_STEPS
from longwave.scenes.engines.ring_cost import USUAL_RUNS, search_cost
from longwave.scenes.engines.run_record import RunRecord, judged, searched
from longwave.scenes.starts.bench_chain import (
    Moment,
    chain_on_bench,
    start_on_bench,
    watched,
    watched_cuts,
)
from longwave.support.request_limits import OverBudgetError, check_request

if TYPE_CHECKING:
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.energy_balance import EnergyBalance
    from longwave.lattice.refine import Announce
    from longwave.lattice.state import State
    from longwave.lattice.trial import Progress, Trial
    from longwave.scenes.engines.recorders import Variables
    from longwave.support.request_limits import ExpectedCost

Array = NDArray[np.float64]

BALANCE_SECONDS = 4e-4
"""To stop at a step and follow energy through it: measured on 24 cells."""

READING_SECONDS = 3e-4
"""To stop at a time and read what is watched: 3e-4 to 4.6e-4, on 31 and 60 cells."""

FIRST_STEP = 4.0
"""A first step, in units of the inverse highest frequency at rest."""


@lru_cache(maxsize=4)
def chain_of(scene: Scene, lossless: bool = False) -> tuple[Bench, DrivenChain]:
    """The scene's bench, and its chain with numbers; without the losses of cells if asked for."""
    bench = scene.own_bench
    values = {name: number_value(name, value) for name, value in scene.constants}
    lattice, losses = without_losses(scene.symbolic_lattice, values)
    span = scene.t0, scene.end
    return bench, chain_on_bench(bench, lattice, span, None if lossless else losses)


def reading_times(scene: Scene, bench: Bench) -> Array:
    """The scene's times, and those at which sensors are read between them."""
    begin, end, every = scene.t0, scene.end, bench.every
    if not (end - begin) / every <= MOST_READINGS:
        raise ValueError(
            f"every in [observables] must give at most {MOST_READINGS:g} times, got "
            f"{every:g} (read less often)"
        )
    between = begin + every * np.arange(1, math.floor((end - begin) / every) + 1)
    wanted = np.union1d(between if math.isfinite(every) else [], scene.snapshots)
    return np.asarray(wanted[wanted <= end])


def scene_cost(scene: Scene) -> ExpectedCost:
    """What the scene is expected to cost, by its chain's waves at rest."""
    bench, chain = chain_of(scene)
    times = reading_times(scene, bench)
    highest = Dynamics(chain).highest_frequency(np.zeros((len(chain.bonds) + len(chain.fields), 2)))
    duration = float(times[-1] - scene.t0)
    longest = FIRST_STEP / highest if highest > 0.0 else duration
    driven = chain.drive_steps(
        scene.t0, scene.end, longest, REDUCED_PHASE_6, scene.target.tolerance
    )
    steps = max(duration / driven.step, float(times.size)) + driven.stops.size
    if steps > MOST_STEPS and driven.step >= longest:
        raise ValueError(
            f"times must end within at most {MOST_STEPS:g} steps, got {scene.end:g} (about "
            f"{steps:.2g}, for the fastest waves have the frequency {highest:.2g}; end earlier)"
        )
    if steps > MOST_STEPS:
        raise ValueError(
            f"losses and what drives a chain must take at most {MOST_STEPS:g} steps, got about "
            f"{steps:.2g} (they change within {driven.step / DRIVEN_SHARE:.2g}; slow them down or "
            "end earlier)"
        )
    kept = times.size * max(1, len(bench.sensed)) * max(1, len(bench.sensors))
    found = search_cost(chain, bench.sites, steps, REDUCED_PHASE_6.stages, float(kept))
    balanced = steps * BALANCE_SECONDS if watched_cuts(bench, chain) is not None else 0.0
    read = times.size * READING_SECONDS
    return replace(found, seconds=found.seconds + USUAL_RUNS * (read + balanced))


class BenchReadings:
    """What is watched on a bench, the engine that compares it between runs, and its records."""

    def __init__(self, scene: Scene, bench: Bench, chain: DrivenChain) -> None:
        self.bench, self.chain, self.scene = bench, chain, scene
        self.times = reading_times(scene, bench)
        self.watched = list(watched(bench, chain))
        scheme = scheme_named(scene.target.scheme) if scene.target.scheme else REDUCED_PHASE_6
        start = chain.held(start_on_bench(bench, chain, scene.t0))
        self.engine = CellRingEngine(
            chain,
            start,
            self.times,
            scheme,
            Comparison(self.read),
            kept=self.times[:0],
            cuts=watched_cuts(bench, chain),
            tolerance=scene.target.tolerance,
        )
        self.sizes = [part.shape for part in self._parts(start, self.engine.balance(start))]

    def _parts(self, state: State, balance: EnergyBalance | None) -> list[Array]:
        flows = () if balance is None else (balance.total, balance.rate)
        now = Moment(self.chain, *state.arrays, *flows)
        return [np.asarray(one.read(now)) for one in self.watched]

    def read(self, state: State, balance: EnergyBalance | None = None) -> Array:
        """All that is watched, one after the other."""
        return np.concatenate([part.ravel() for part in self._parts(state, balance)])

    def variables(self, found: Array, ending: str = "", meaning: str = "") -> Variables:
        """What is watched, by name and that ending; ``meaning`` precedes what it is."""
        variables: Variables = {}
        splits = np.cumsum([math.prod(size) for size in self.sizes])[:-1]
        parts = np.split(found, splits, axis=1)
        for one, size, part in zip(self.watched, self.sizes, parts, strict=True):
            values = part.reshape(len(part), *size)
            dimensions = one.dimensions
            if dimensions[1:] and size[-1] == 1:
                values, dimensions = values[..., 0], dimensions[:-1]
            told = {"units": one.units, "long_name": meaning + one.long_name}
            variables[one.name + ending] = ("time", *dimensions), values, told
        return variables

    def record_of(self, trial: Trial) -> RunRecord:
        """The record of a run, without variables if it broke down."""
        blow_up, steps, _, _ = trial.payload
        variables = {} if trial.values is None else self.variables(trial.values)
        told = "" if blow_up is None else str(blow_up)
        return self.record(variables, steps, trial.seconds, told)

    def record(
        self, variables: Variables, steps: int, seconds: float, blow_up: str = ""
    ) -> RunRecord:
        """The record of these variables, with places of sensors and numbers of modes."""
        for name, counted, long_name in (
            ("sensor", self.bench.sensors, "number of the cell"),
            ("mode", self.bench.modes, "number of the mode"),
            ("driver", self.chain.drivers, "wall that moves, or force in the scene's order"),
            ("cut", self.bench.flux, "number of the cell to the left"),
        ):
            if any(name in found for found, _, _ in variables.values()):
                told = {"units": "1", "long_name": long_name}
                variables[name] = (name,), np.array(counted), told
        scheme = self.engine.scheme
        cost = {
            "engine": "stencil",
            "scheme": scheme.name,
            "order": scheme.order,
            "steps": steps,
            "force_evaluations": steps * scheme.stages,
            "sites": self.bench.sites,
            "seconds": seconds,
            "blow_up": blow_up,
        }
        reached = tuple(self.times.tolist()) if variables else ()
        return RunRecord(self.scene, (0,), reached, variables, cost)


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """Run the chain so that nothing watched is off by more than the tolerance.

    Raises ValueError in one line for what the lattice does not admit, for what would take too long,
    and for a chain that flies apart.
    """
    begun = perf_counter()
    if restart is not None:
        raise ValueError(
            f"a chain on a bench must be run from its start, got a state of {scene.name} (run it)"
        )
    cost = scene_cost(scene)
    check_request(scene.name, cost, "watch it less often, end earlier or take fewer sites")
    announce, progress = announce or (lambda _: None), progress or (lambda _: None)
    bench, chain = chain_of(scene)
    if bench.noise is not None:
        from longwave.scenes.engines.bench_bath import record_means

        return record_means(scene, bench, chain, progress, announce)
    announce(cost.seconds)
    readings = BenchReadings(scene, bench, chain)
    try:
        found = searched(readings.engine, scene, progress, announce, readings.record_of)
    except OverBudgetError as dear:
        raise ValueError(readings.engine.told_dear(dear.work, scene.tolerance)) from None
    record = readings.record_of(found.trial)
    if found.trial.values is None:
        if readings.engine.meets_features and not record.attrs["blow_up"]:
            raise ValueError(readings.engine.told_unfollowed(found.trial.choices.step))
        raise ValueError(
            f"times must end before {scene.lattice} flies apart, got {scene.end:g} "
            f"({record.attrs['blow_up'] or 'no run comes to the end'}, with steps down to "
            f"{found.trial.choices.step:.2g}; end earlier)"
        )
    return judged(record, found, scene, begun)
