"""Cost of a site on rings that leave the cache, with one core and with all, in time and bytes.

The paper's chain: seconds of its steps per site and force evaluation, and the largest memory of a
process that runs it to one time and a tolerance, its state and result counted, beyond that of a
process which does so on few sites. Each in a process of its own.

    python benchmarks/large_rings.py [--sites 10000 100000 1000000 10000000]
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import time

import numpy as np
from problem import CONSTANTS, EPS

from longwave.lattice import integrate
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.state import State
from longwave.lattice.stepper import advance

STEPS, STEP, ROUNDS = 32, 0.25, 3
TOLERANCE = 1e-6
FEW = 10_000
"""Sites whose arrays stay in the cache."""


def state(sites: int) -> State:
    """Return a state of long waves of small strain, one in a thousand sites."""
    phase = 2.0 * np.pi * np.arange(sites) / 1000.0
    return State(0.0, EPS * np.sin(phase)[None], np.zeros((1, sites)))


def nanoseconds(sites: int) -> float:
    """Return the elapsed time per site and force evaluation; the least of a few rounds."""
    start = state(sites)
    steps = max(STEPS, STEPS * 100_000 // sites)
    spent = []
    for _ in range(ROUNDS + 1):
        begun = time.perf_counter()
        advance(REDUCED_PHASE_6, start.f, start.v, STEP, steps, CONSTANTS.lattice)
        spent.append(time.perf_counter() - begun)
    return min(spent) * 1e9 / (sites * steps * REDUCED_PHASE_6.stages)


def peak_bytes(sites: int) -> int:
    """Return the largest memory of this process when it has run to the tolerance."""
    integrate(CONSTANTS.lattice, state(sites), [4.0], TOLERANCE)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def in_process(quantity: str, sites: int, cores: int) -> float:
    """Measure the quantity in a process of its own, on so many cores."""
    chosen = sorted(os.sched_getaffinity(0))[:cores]
    words = [sys.executable, __file__, "--quantity", quantity, "--sites", str(sites)]
    found = subprocess.run(
        words,
        capture_output=True,
        text=True,
        check=True,
        preexec_fn=lambda: os.sched_setaffinity(0, chosen),
    )
    return float(found.stdout)


def main() -> int:
    """Print a row per number of sites, and the largest cost over that in the cache."""
    parser = argparse.ArgumentParser(description="Time and bytes a site of large rings.")
    parser.add_argument("--sites", type=int, nargs="+", default=[FEW, 10**5, 10**6, 10**7])
    parser.add_argument("--quantity", choices=["time", "bytes"])
    options = parser.parse_args()
    if options.quantity:
        print({"time": nanoseconds, "bytes": peak_bytes}[options.quantity](*options.sites))
        return 0
    cores = len(os.sched_getaffinity(0))
    base = in_process("bytes", FEW, cores)
    cached = in_process("time", FEW, 1)
    for sites in options.sites:
        one, all_ = (in_process("time", sites, used) for used in (1, cores))
        memory = (in_process("bytes", sites, cores) - base) / sites
        print(
            f"{sites:9d} sites: {one:.3f} ns a site and force evaluation on one core "
            f"({one / cached:.2f} times that in the cache), {all_:.3f} on {cores}; "
            f"{memory:.0f} bytes a site"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
