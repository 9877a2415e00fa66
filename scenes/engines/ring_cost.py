"""Cost model for runs on a ring: expected time and memory from the lattice's data alone.

The constants are CPU times measured on one core of a 3 GHz server, with rings that fit its cache.
`benchmarks/time_told.py` compares the model with the shipped scenes. The exact cost of a tolerance
is known only when its search for step and domain has ended.
"""

from dataclasses import replace

from longwave.lattice.force_program import UNARY, ForceProgram
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.support.request_limits import ExpectedCost

USUAL_RUNS = 4.5
"""Cost of a search, in units of its first run. Measured: 3.9, or 4.9 if rounding is estimated;
sometimes 7."""

BEGIN_SECONDS = 1.6
"""Seconds once per process: imports, deriving the equation and compiling its wave."""

STEP_SECONDS = 3e-7
"""Seconds per step on a small ring: 2.6e-7 to 3.3e-7 on chains of 100 cells."""

DRIVEN_STEP_SECONDS = 2.5e-5
"""Seconds per step of a driven lattice with time-dependent weights; 4e-5 on a busy machine."""

SECONDS_PER_DASHPOT = 3e-9
"""Seconds per dashpot and stage of a step, in which the rate of its bond is computed."""

CELL_SECONDS = 5e-6
"""Seconds to compute one cell's initial data for all runs: 1e-6 to 2e-5, depending on the wave."""

SECONDS_PER_FIELD = {1: 2e-10, 2: 2e-9}
"""Seconds to advance one field of a cell by one stage, by the number of axes; each parameter with
disorder counts as a field."""

SECONDS_PER_ROOT = 4.5e-10
"""Seconds for a square root or a division in a force."""

SECONDS_PER_FUNCTION = dict.fromkeys(UNARY, 1.2e-9) | {"exp": 6e-10, "log": 8e-10}
SECONDS_PER_FUNCTION |= {"contact": 0.0, "touching": 0.0}
"""Seconds for a function in a force, 3 to 8 times as long as a polynomial; comparisons are free."""

SECONDS_PER_POWER = 2.6e-9
"""Seconds for a power whose exponent is neither an integer nor a half-integer."""

PROCESS_BYTES = 3e8
"""Memory, in bytes, of a process that has run a small scene."""

BYTES_PER_VALUE = 100.0
"""Bytes for each compared value at each time, over all runs of a search and their results."""

SINGLE_RUN_FRACTION = 0.4
"""Memory per value of a single run, as a fraction of `BYTES_PER_VALUE`. Measured: 34 bytes at
1e7 cells of two fields."""

BYTES_PER_CELL = 160.0
"""Bytes per field of a cell in a run: state, initial data and compared values."""

LARGE_CELLS = 100_000
"""Number of compared cells above which the step is searched for on a part of the cells."""

MIN_PART_RATIO = 8
"""Minimum ratio of all compared cells to the part on which the step is searched for."""


def cell_seconds(lattice: NumericLattice) -> float:
    """Return the seconds needed to advance all fields of a cell by one stage of a step.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> cell_seconds(numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 1}))
    2e-10
    >>> cell_seconds(numeric_lattice(LATTICES["toda"], {"a": 1, "b": 1}))
    8e-10
    """
    each = SECONDS_PER_FIELD[min(lattice.dimension, 2)]
    forces = sum(_force_seconds(bond.force) for bond in lattice.bonds)
    disordered = lattice.cellwise[2].shape[0]
    pots = SECONDS_PER_DASHPOT * sum(map(bool, getattr(lattice, "dashpots", ())))
    return each * (len(lattice.fields) + disordered) + forces + pots


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


def enlarged(cost: ExpectedCost, seconds: float, memory_bytes: float = 0.0) -> ExpectedCost:
    """Return the cost with these seconds and bytes added."""
    memory_bytes += cost.memory_bytes
    return replace(cost, seconds=cost.seconds + seconds, memory_bytes=memory_bytes)


def search_cost(
    lattice: NumericLattice, cells: float, steps: float, stages: int, compared: float
) -> ExpectedCost:
    """Return the expected cost of a search for step and domain on a ring of ``cells`` cells.

    ``steps`` is the number of steps of its first run, ``compared`` the number of compared cells,
    summed over all times.
    """
    fields = len(lattice.fields)
    overhead = DRIVEN_STEP_SECONDS if lattice.is_driven else STEP_SECONDS
    first = steps * (overhead + stages * cells * cell_seconds(lattice))
    seconds = BEGIN_SECONDS + CELL_SECONDS * cells + USUAL_RUNS * first
    memory = PROCESS_BYTES + (BYTES_PER_CELL * cells + BYTES_PER_VALUE * compared) * fields
    return ExpectedCost(seconds, memory, steps, BEGIN_SECONDS)
