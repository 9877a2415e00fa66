"""Cost of a wave's far field that is zero, and of one that is noise of 1e-13.

The tails of a pulse on zero fall through the subnormal numbers, which Intel's processors take 100
cycles for; the lattice's machine code takes them for 0 (`longwave.support.compiled.subnormals`).
Both are run in turn: the least seconds of processor of each, in nanoseconds a cell and step, and
their ratio.

python benchmarks/zero_tails.py
"""

import os
import platform
from collections.abc import Iterator
from pathlib import Path
from time import process_time

import numpy as np
from problem import CONSTANTS, EPS, PROBLEMS, Array, hump

from longwave.derive import LATTICES
from longwave.lattice import State
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import REDUCED_PHASE_6

CELLS, SIDE, STEPS, ROUNDS, SEED = 4096, 128, 400, 7, 1
NOISE = 1e-13


def lattices() -> Iterator[tuple[str, NumericLattice, Array]]:
    """Yield each lattice with the positions that it starts from."""
    [strain], _ = hump(CELLS)
    yield "chain", CONSTANTS.lattice, EPS * strain[np.newaxis]
    yield "dimer", PROBLEMS["dimer"].lattice, PROBLEMS["dimer"].start()[0]
    yield "square", PROBLEMS["square"].lattice, hump(SIDE, SIDE)[0] ** 16
    for name, constants in (("toda", {"a": 1, "b": 1}), ("granular", {"A": 1, "d": 1})):
        yield name, numeric_lattice(LATTICES[name], constants), EPS * strain[np.newaxis]


def step_time(lattice: NumericLattice, f: Array) -> float:
    """Return nanoseconds of processor time a cell and step."""
    ring = lattice.with_walls(State(0.0, f.copy(), np.zeros_like(f)))
    dynamics = Dynamics(lattice)
    dynamics.advance(REDUCED_PHASE_6, ring.f, ring.v, 0.05, 4)
    begin = process_time()
    dynamics.advance(REDUCED_PHASE_6, ring.f, ring.v, 0.05, STEPS)
    return (process_time() - begin) / STEPS / f[0].size * 1e9


def processor_name() -> str:
    """Return the processor's name, as reported by the system."""
    lines = (
        Path("/proc/cpuinfo").read_text().splitlines() if os.path.exists("/proc/cpuinfo") else []
    )
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def main() -> None:
    """Print a line for each lattice."""
    noise = np.random.default_rng(SEED)
    print(f"{processor_name()}\nlattice    zero tails    noise of {NOISE:g}    ratio")
    for name, lattice, f in lattices():
        noisy = f + NOISE * noise.standard_normal(f.shape)
        times = np.array([[step_time(lattice, data) for data in (f, noisy)] for _ in range(ROUNDS)])
        zero, other = times.min(axis=0)
        print(f"{name:9}{zero:9.2f} ns{other:14.2f} ns{zero / other:12.2f}", flush=True)


if __name__ == "__main__":
    main()
