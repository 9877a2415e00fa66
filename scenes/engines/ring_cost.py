"""What runs on a ring are expected to take, known from the lattice's data alone.

Measured in processor time on one core of a 3 GHz server, with rings that fit its cache;
`benchmarks/time_told.py` compares it with what shipped scenes take. What a tolerance takes is known
only when its search has ended.
"""

from __future__ import annotations

from longwave.lattice.force_program import UNARY, ForceProgram
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.support.request_limits import ExpectedCost

USUAL_RUNS = 4.5
"""Runs of a search, in units of the first: 3.9, with what rounding does 4.9, at times 7."""

BEGIN_SECONDS = 1.6
"""Once in a process: imports, to derive the equation and to have its wave as a program."""

STEP_SECONDS = 3e-7
"""For a step of a ring of few cells: 2.6e-7 to 3.3e-7, on chains of 100 cells."""

DRIVEN_STEP_SECONDS = 2.5e-5
"""For a step whose stages take weights of their own times: 2.8e-5 to 4e-5 on a busy machine."""

SECONDS_PER_DASHPOT = 3e-9
"""For a dashpot beside a spring, which follows its bond's rate in each stage."""

CELL_SECONDS = 5e-6
"""To form the data of a cell in all runs: 1e-6 to 2e-5, by the wave."""

SECONDS_PER_FIELD = {1: 2e-10, 2: 2e-9}
"""To advance a field of a cell by a stage, by the number of axes; what deviates is a field, too."""

SECONDS_PER_ROOT = 4.5e-10
"""For a root or a quotient in a force."""

SECONDS_PER_FUNCTION = dict.fromkeys(UNARY, 1.2e-9) | {"exp": 6e-10, "log": 8e-10}
SECONDS_PER_FUNCTION |= {"contact": 0.0, "touching": 0.0}
"""For a function in a force: 3 to 8 times a polynomial's work. A comparison is none."""

SECONDS_PER_POWER = 2.6e-9
"""For a power whose exponent is neither whole nor half."""

PROCESS_BYTES = 3e8
"""Of a process that has run something small."""

BYTES_PER_VALUE = 100.0
"""Of what is compared at a time, by all runs of a search and in what is made of them."""

SHOWN = 0.4
"""The share of that where no search keeps it: 34 bytes at ten million cells of two fields."""

BYTES_PER_CELL = 160.0
"""Of a run, for each field of a cell: state, data, and what is compared."""

LARGE = 100_000
"""Compared cells from which on the step is looked for on a part of them."""

SHARE = 8
"""The part is at most one of so many."""


def cell_seconds(lattice: NumericLattice) -> float:
    """Seconds to advance all fields of a cell by a stage.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> cell_seconds(numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 1}))
    2e-10
    >>> cell_seconds(numeric_lattice(LATTICES["toda"], {"a": 1, "b": 1}))
    8e-10
    """
    each = SECONDS_PER_FIELD[min(lattice.dimension, 2)]
    forces = sum(_force_seconds(bond.force) for bond in lattice.bonds)
    resting = lattice.cellwise[2].shape[0]
    pots = SECONDS_PER_DASHPOT * sum(map(bool, getattr(lattice, "dashpots", ())))
    return each * (len(lattice.fields) + resting) + forces + pots


def _force_seconds(force: ForceProgram) -> float:
    total = 0.0
    for word, value in force.instructions:
        if word == "power":
            if 2.0 * value != round(2.0 * value):
                total += SECONDS_PER_POWER
            elif value < 0.0 or value != round(value):
                total += SECONDS_PER_ROOT
        else:
            total += SECONDS_PER_FUNCTION.get(word, 0.0)
    return total


def search_cost(
    lattice: NumericLattice, cells: float, steps: float, stages: int, kept: float
) -> ExpectedCost:
    """Of a search on rings of so many ``cells``, ``kept`` of which are compared at all times.

    ``steps`` are those of the first run.
    """
    fields = len(lattice.fields)
    begun = DRIVEN_STEP_SECONDS if lattice.is_driven else STEP_SECONDS
    first = steps * (begun + stages * cells * cell_seconds(lattice))
    return ExpectedCost(
        BEGIN_SECONDS + CELL_SECONDS * cells + USUAL_RUNS * first,
        PROCESS_BYTES + (BYTES_PER_CELL * cells + BYTES_PER_VALUE * kept) * fields,
        steps,
        BEGIN_SECONDS,
    )
