"""Readings of a chain on a bench: the values by which runs are compared and recorded."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from longwave.derive.symbols import number_value
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.schemes import REDUCED_PHASE_6, scheme_named
from longwave.lattice.state import State
from longwave.scenes.description.bench import MOST_READINGS, Bench
from longwave.scenes.description.losses import without_losses
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.run_record import RunRecord, stencil_cost
from longwave.scenes.starts import bench_chain
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.energy_balance import EnergyBalance
    from longwave.lattice.trial import Trial
    from longwave.scenes.engines.recorders import Variables


@lru_cache(maxsize=4)
def bench_and_chain(scene: Scene, lossless: bool = False) -> tuple[Bench, DrivenChain]:
    """Return a scene's bench and numeric chain, without its losses if ``lossless``."""
    bench = scene.own_bench
    values = {name: number_value(name, value) for name, value in scene.constants}
    lattice, losses = without_losses(scene.symbolic_lattice, values)
    span = scene.t0, scene.end
    return bench, bench_chain.chain_on_bench(bench, lattice, span, None if lossless else losses)


def reading_times(scene: Scene, bench: Bench) -> Array:
    """Return the snapshots, and times ``bench.every`` apart between; ValueError if too many."""
    begin, end, every = scene.t0, scene.end, bench.every
    if not (end - begin) / every <= MOST_READINGS:
        raise ValueError(
            f"every in [observables] must give at most {MOST_READINGS:g} times, got "
            f"{every:g} (read less often)"
        )
    between = begin + every * np.arange(1, math.floor((end - begin) / every) + 1)
    times = np.union1d(between if math.isfinite(every) else [], scene.snapshots)
    return np.asarray(times[times <= end])


class BenchReadings:
    """Readings of a bench scene, with the engine whose runs are compared by them."""

    def __init__(self, scene: Scene, bench: Bench, chain: DrivenChain) -> None:
        self.bench, self.chain, self.scene = bench, chain, scene
        self.times = reading_times(scene, bench)
        self.outputs = list(bench_chain.bench_variables(bench, chain))
        scheme = scheme_named(scene.target.scheme) if scene.target.scheme else REDUCED_PHASE_6
        start = chain.with_walls(bench_chain.start_on_bench(bench, chain, scene.t0))
        self.engine = CellEngine(
            chain,
            start,
            self.times,
            scheme,
            StateComparison(self.read),
            stored_times=self.times[:0],
            cuts=bench_chain.energy_cuts(bench, chain),
            tolerance=scene.target.tolerance,
        )
        self.sizes = [part.shape for part in self._parts(start, self.engine.balance(start))]

    def _parts(self, state: State, balance: EnergyBalance | None) -> list[Array]:
        flows = () if balance is None else (balance.total, balance.rate)
        now = bench_chain.Moment(self.chain, *state.arrays, *flows)
        return [np.asarray(one.read(now)) for one in self.outputs]

    def read(self, state: State, balance: EnergyBalance | None = None) -> Array:
        """Return all readings of a state, flattened into one array."""
        return np.concatenate([part.ravel() for part in self._parts(state, balance)])

    def variables(self, readings: Array, ending: str = "", meaning: str = "") -> Variables:
        """Return readings (times, values) as variables; ``ending`` is appended to each name.

        ``meaning`` is appended to each long name.
        """
        variables: Variables = {}
        splits = np.cumsum([math.prod(size) for size in self.sizes])[:-1]
        parts = np.split(readings, splits, axis=1)
        for output, size, part in zip(self.outputs, self.sizes, parts, strict=True):
            values, dimensions = part.reshape(len(part), *size), output.dimensions
            if dimensions[1:] and size[-1] == 1:
                values, dimensions = values[..., 0], dimensions[:-1]
            attributes = {"units": output.units, "long_name": meaning + output.long_name}
            variables[output.name + ending] = ("time", *dimensions), values, attributes
        return variables

    def record_of(self, trial: Trial) -> RunRecord:
        """Return the record of a run, without variables if it broke down."""
        blow_up, steps, _, _ = trial.payload
        variables = {} if trial.values is None else self.variables(trial.values)
        return self.record(variables, steps, trial.seconds, blow_up)

    def record(
        self, variables: Variables, steps: int, seconds: float, blow_up: object = None
    ) -> RunRecord:
        """Return a record, with coordinates added; ``blow_up`` describes a breakdown or is None."""
        for name, numbers, long_name in (
            ("sensor", self.bench.sensors, "number of the cell"),
            ("mode", self.bench.modes, "number of the mode"),
            ("driver", self.chain.drivers, "wall that moves, or force in the scene's order"),
            ("cut", self.bench.flux, "number of the cell to the left"),
        ):
            if any(name in dimensions for dimensions, _, _ in variables.values()):
                attributes = {"units": "1", "long_name": long_name}
                variables[name] = (name,), np.array(numbers), attributes
        cost = stencil_cost(self.engine.scheme, steps, self.bench.sites, seconds, blow_up)
        reached = tuple(self.times.tolist()) if variables else ()
        return RunRecord(self.scene, (0,), reached, variables, cost)
