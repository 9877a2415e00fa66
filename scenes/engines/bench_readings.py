"""What is watched of a chain on a bench, which runs are compared by and recorded in."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.derive.symbols import number_value
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.schemes import REDUCED_PHASE_6, scheme_named
from longwave.scenes.description.bench import MOST_READINGS, Bench
from longwave.scenes.description.losses import without_losses
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts.bench_chain import (
    Moment,
    chain_on_bench,
    start_on_bench,
    watched,
    watched_cuts,
)

if TYPE_CHECKING:
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.energy_balance import EnergyBalance
    from longwave.lattice.state import State
    from longwave.lattice.trial import Trial
    from longwave.scenes.engines.recorders import Variables

Array = NDArray[np.float64]


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


class BenchReadings:
    """What is watched on a bench, the engine that compares it between runs, and its records."""

    def __init__(self, scene: Scene, bench: Bench, chain: DrivenChain) -> None:
        self.bench, self.chain, self.scene = bench, chain, scene
        self.times = reading_times(scene, bench)
        self.watched = list(watched(bench, chain))
        scheme = scheme_named(scene.target.scheme) if scene.target.scheme else REDUCED_PHASE_6
        start = chain.with_walls(start_on_bench(bench, chain, scene.t0))
        self.engine = CellEngine(
            chain,
            start,
            self.times,
            scheme,
            StateComparison(self.read),
            stored_times=self.times[:0],
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
