"""Cost of each effect of a chain on a bench: per cell and stage, and of a run to a tolerance.

The beta chain of 4096 cells in displacements is run with one effect at a time. Code is generated
for requested effects only. Operations are those of `StagePlan`, a fused multiply-add counted once.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache

import numpy as np

from longwave.derive import LATTICES
from longwave.lattice import SiteForce, State, driven_chain, integrate
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.kernels.streams import varied_stage_plan
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.reports.studies.peak import multiply_add_rate
from longwave.scenes.description.time_functions import time_function
from longwave.support.processes import Job, Key

CELLS, STEPS, STEP, ROUNDS = 4096, 64, 0.2, 20
"""Timing of a stage: cells of the chain, steps per round, time step, and number of rounds."""

WIDTH, END = 10.0, 100.0
"""Pulse width in cells and end time of the runs to `TOLERANCES`."""

TOLERANCES = (1e-6, 1e-10)
"""Tolerances of the runs whose whole time is measured."""


@cache
def effects() -> dict[str, NumericLattice]:
    """Return the beta chain with a single effect, keyed by the name of the effect."""
    chain = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
    push = SiteForce(3, time_function("force", "0.3*cos(9*t/10)"))
    shaken = time_function("wall", "0.05*sin(13*t/10)")
    return {
        "none": chain,
        "losses of cells": driven_chain(chain, CELLS, losses=0.03),
        "held walls": driven_chain(chain, CELLS, left="fixed", right="fixed"),
        "a free end": driven_chain(chain, CELLS, left="free", right="fixed"),
        "a wall that moves": driven_chain(chain, CELLS, left=shaken, right="fixed"),
        "a force": driven_chain(chain, CELLS, forces=[push]),
        "dashpots": driven_chain(chain, CELLS, dashpots=0.05),
        "losses, walls, a force": driven_chain(
            chain, CELLS, left="fixed", right="fixed", losses=0.03, forces=[push]
        ),
    }


@dataclass(frozen=True)
class EffectCost:
    """Cost of an effect: ``operations`` and ``seconds`` are those of one cell in one stage.

    ``share`` is the rate of operations over the core's multiply-add rate, ``runs`` has the error
    estimate and the seconds of a run to each of `TOLERANCES`.
    """

    operations: int
    seconds: float
    share: float
    runs: tuple[tuple[float, float], ...]


def effect_cost(name: str) -> EffectCost:
    """Measure the cost of one of `effects` on one core."""
    lattice = effects()[name]
    ordered, variation, _ = lattice.cellwise
    operations = varied_stage_plan(ordered, variation).flow.operations
    seconds = _stage_seconds(lattice)
    share = operations / seconds / multiply_add_rate()
    _run(lattice, TOLERANCES[0])  # compiles the kernels
    runs = tuple(_run(lattice, tolerance) for tolerance in TOLERANCES)
    return EffectCost(operations, seconds, share, runs)


def _stage_seconds(lattice: NumericLattice) -> float:
    """Return the seconds for a cell and stage, the smallest of several rounds."""
    random = np.random.default_rng(0)
    dynamics, times = Dynamics(lattice), []
    state = lattice.with_walls(State(0.0, *(0.1 * random.standard_normal((2, 1, CELLS)))))
    for number in range(ROUNDS):
        start = time.perf_counter()
        dynamics.advance(REDUCED_PHASE_6, state.f, state.v, STEP, STEPS, number * STEPS * STEP)
        times.append(time.perf_counter() - start)
    return min(times) / (STEPS * REDUCED_PHASE_6.stages * CELLS)


def _run(lattice: NumericLattice, tolerance: float) -> tuple[float, float]:
    """Return a run's error estimate, and its seconds including the search for the step."""
    f = np.exp(-((np.arange(CELLS) / WIDTH - 10.0) ** 2))[np.newaxis]
    start = time.perf_counter()
    result = integrate(lattice, State(0.0, f, np.zeros_like(f)), [END], tolerance=tolerance)
    return result.error_estimate, time.perf_counter() - start


def effect_jobs() -> dict[Key, Job]:
    """Return a job for each effect."""
    return {("effect", name): Job(effect_cost, (name,), 3.0) for name in effects()}
