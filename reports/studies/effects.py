"""What each effect of a chain on a bench costs, alone and to a tolerance.

The beta chain of 4096 cells in displacements, with nothing but one effect: what it does not ask for
is not in its machine code. Operations are those of `StagePlan`, a fused multiply-add counted once.
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
WIDTH, END = 10.0, 100.0
TOLERANCES = (1e-6, 1e-10)


@cache
def effects() -> dict[str, NumericLattice]:
    """The chain with each effect."""
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
    """Operations and seconds a cell and stage, and their share of the multiply-adds that the core
    does alone; the error estimate and seconds of a run to each of `TOLERANCES`."""

    operations: int
    seconds: float
    share: float
    runs: tuple[tuple[float, float], ...]


def effect_cost(name: str) -> EffectCost:
    """The cost of one of `effects`, on one core."""
    lattice = effects()[name]
    ordered, variation, _ = lattice.cellwise
    operations = varied_stage_plan(ordered, variation).flow.operations
    seconds = _stage_seconds(lattice)
    share = operations / seconds / multiply_add_rate()
    _run(lattice, TOLERANCES[0])  # which compiles
    return EffectCost(operations, seconds, share, tuple(_run(lattice, to) for to in TOLERANCES))


def _stage_seconds(lattice: NumericLattice) -> float:
    """The least of some rounds, a cell and stage."""
    random = np.random.default_rng(0)
    dynamics, spent = Dynamics(lattice), []
    state = lattice.with_walls(State(0.0, *(0.1 * random.standard_normal((2, 1, CELLS)))))
    for number in range(ROUNDS):
        begun = time.perf_counter()
        dynamics.advance(REDUCED_PHASE_6, state.f, state.v, STEP, STEPS, number * STEPS * STEP)
        spent.append(time.perf_counter() - begun)
    return min(spent) / (STEPS * REDUCED_PHASE_6.stages * CELLS)


def _run(lattice: NumericLattice, tolerance: float) -> tuple[float, float]:
    """The error estimate, and the seconds of the run and of the search for its step."""
    f = np.exp(-((np.arange(CELLS) / WIDTH - 10.0) ** 2))[np.newaxis]
    begun = time.perf_counter()
    found = integrate(lattice, State(0.0, f, np.zeros_like(f)), [END], tolerance=tolerance)
    return found.error_estimate, time.perf_counter() - begun


def effect_jobs() -> dict[Key, Job]:
    """A job for each effect."""
    return {("effect", name): Job(effect_cost, (name,), 3.0) for name in effects()}
