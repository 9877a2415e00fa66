"""What each effect of a chain on a bench costs: nanoseconds a cell and stage, on one core.

The beta chain of 4096 cells in displacements, alone and with each effect: what it does not ask for
is not in its machine code. Operations are those of `StagePlan`, a fused multiply-add counted once;
the share is that of the multiply-adds that the core does alone.

    python benchmarks/effects.py
"""

from __future__ import annotations

import time

import numpy as np
from peak import multiply_add_rate

from longwave.derive import LATTICES
from longwave.lattice import SiteForce, State, driven_chain
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.kernels.streams import varied_stage_plan
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.scenes.bench import time_function

CELLS, STEPS, STEP, ROUNDS = 4096, 64, 0.2, 20
CHAIN = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
PUSH = SiteForce(3, time_function("force", "0.3*cos(9*t/10)"))
SHAKEN = time_function("wall", "0.05*sin(13*t/10)")
EFFECTS: dict[str, NumericLattice] = {
    "none": CHAIN,
    "losses of cells": driven_chain(CHAIN, CELLS, losses=0.03),
    "held walls": driven_chain(CHAIN, CELLS, left="fixed", right="fixed"),
    "a free end": driven_chain(CHAIN, CELLS, left="free", right="fixed"),
    "a wall that moves": driven_chain(CHAIN, CELLS, left=SHAKEN, right="fixed"),
    "a force": driven_chain(CHAIN, CELLS, forces=[PUSH]),
    "dashpots": driven_chain(CHAIN, CELLS, dashpots=0.05),
    "losses, walls and a force": driven_chain(
        CHAIN, CELLS, left="fixed", right="fixed", losses=0.03, forces=[PUSH]
    ),
}


def seconds(lattice: NumericLattice) -> float:
    """Of a stretch of steps; the least of some rounds."""
    random = np.random.default_rng(0)
    dynamics, spent = Dynamics(lattice), []
    state = lattice.held(State(0.0, *(0.1 * random.standard_normal((2, 1, CELLS)))))
    for number in range(ROUNDS):
        begun = time.perf_counter()
        t = number * STEPS * STEP
        dynamics.advance(REDUCED_PHASE_6, state.f, state.v, STEP, STEPS, t)
        spent.append(time.perf_counter() - begun)
    return min(spent)


def main() -> None:
    """Print a line for each effect."""
    rate = multiply_add_rate()
    print("effect                      ns a cell and stage   operations   share of the core's")
    for name, lattice in EFFECTS.items():
        ordered, variation, _ = lattice.cellwise
        operations = varied_stage_plan(ordered, variation).flow.operations
        each = seconds(lattice) / (STEPS * REDUCED_PHASE_6.stages * CELLS)
        share = operations / each / rate
        print(f"{name:27} {each * 1e9:12.3f} {operations:17d} {share:18.0%}")


if __name__ == "__main__":
    main()
