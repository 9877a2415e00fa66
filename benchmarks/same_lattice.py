"""The stencil and its peers on the same lattice and data, interleaved in one run.

The FPUT lattice: a ring of 4096 sites, 500 time units, the wave Y2 (K2 = 4, K4 = 1, eps = 0.05)
started at t = -250. With ``--lattice`` another of `problem.PROBLEMS`: springs between next-nearest
neighbours, a dimer, the square lattice, a chain with losses that is pushed, a Toda lattice, grains
that are struck.
The error is the sup over cells of |stretch - reference| in units of the stretch, the reference a
composition of order 10. Each contender gets the coarsest resolution on a ladder that brings its
error to 1e-6 (1e-4 where contacts open), found by bisection; then all run in turn, equally often,
and the least processor time of each counts. Absent peers are reported as absent, those whose ladder
ends above the target as not reached. Ratios are to the stencil with the first scheme.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from contenders import (
    Contender,
    boost_contender,
    diffrax_contender,
    heyoka_contender,
    rk4_contender,
    scipy_contender,
    stencil_contender,
)
from problem import PROBLEMS, Array, Problem

from longwave.lattice.schemes import (
    BLANES_MOAN_6,
    KAHAN_LI_8,
    MCLACHLAN_4,
    REDUCED_PHASE_6,
    SUZUKI_UMENO_8,
    Scheme,
)
from longwave.reports.studies.peak import multiply_add_rate

TOLERANCES = (1e4, 1e11, 10.0**0.25)

Ladder = tuple[float, float, float]
"""Least and largest resolution, and the factor between rungs."""


Make = Callable[[str, Path], Contender]
"""A contender for the problem of that name, with a folder to compile in."""


def _stencil(scheme: Scheme) -> Make:
    return lambda name, _: stencil_contender(PROBLEMS[name], scheme)


ENTRANTS: dict[str, tuple[Make, Ladder]] = {
    "stencil reduced_phase_6": (_stencil(REDUCED_PHASE_6), (40, 32000, 1.02)),
    "stencil blanes_moan_6": (_stencil(BLANES_MOAN_6), (40, 32000, 1.02)),
    "stencil kahan_li_8": (_stencil(KAHAN_LI_8), (40, 32000, 1.02)),
    "stencil suzuki_umeno_8": (_stencil(SUZUKI_UMENO_8), (40, 32000, 1.02)),
    "stencil mclachlan_4": (_stencil(MCLACHLAN_4), (400, 32000, 1.02)),
    "Boost odeint": (
        lambda name, folder: boost_contender(PROBLEMS[name], name, folder),
        (400, 32000, 1.02),
    ),
    "SciPy DOP853": (lambda name, _: scipy_contender(PROBLEMS[name]), TOLERANCES),
    "Diffrax Dopri8": (lambda name, _: diffrax_contender(PROBLEMS[name]), TOLERANCES),
    "heyoka.py": (lambda name, _: heyoka_contender(PROBLEMS[name]), TOLERANCES),
    "NumPy RK4": (lambda name, _: rk4_contender(PROBLEMS[name]), (2000, 64000, 2.0**0.25)),
}

FIRST = next(iter(ENTRANTS))


def coarsest(contender: Contender, ladder: Ladder, problem: Problem, exact: Array) -> float | None:
    """Return the least resolution of the ladder that meets the target, by bisection.

    None if the ladder's last rung misses it.
    """
    least, largest, factor = ladder
    rungs = least * factor ** np.arange(int(np.log(largest / least) / np.log(factor)) + 2)
    low, high = -1, len(rungs) - 1
    start = problem.start()
    if not problem.error(contender(rungs[high], *start)[1], exact) <= problem.target:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        met = problem.error(contender(rungs[middle], *start)[1], exact) <= problem.target
        low, high = (low, middle) if met else (middle, high)
    return float(rungs[high])


def entered(
    name: str, folder: Path, skip: list[str], exact: Array
) -> dict[str, tuple[Contender, float]]:
    """Return the contenders that meet the target, with their resolutions; print the others."""
    found = {}
    for entrant, (make, ladder) in ENTRANTS.items():
        if entrant in skip:
            continue
        try:
            contender = make(name, folder)
        except (ImportError, OSError) as reason:
            print(f"{entrant:24s} absent: {reason}")
            continue
        with np.errstate(all="ignore"):
            resolution = coarsest(contender, ladder, PROBLEMS[name], exact)
        if resolution is None:
            target = PROBLEMS[name].target
            print(f"{entrant:24s} not reached: its ladder ends above an error of {target:g}")
        else:
            found[entrant] = contender, resolution
    return found


def print_share(problem: Problem, seconds: float, steps: float, rate: float) -> None:
    """Print the kernel's arithmetic as a share of the core's multiply-add rate."""
    cells = problem.start()[0][0].size
    done = problem.operations * cells * round(steps) * REDUCED_PHASE_6.stages / seconds
    print(
        f"{problem.operations} operations per cell and force evaluation (a multiply-add counts "
        f"once, cells at rest count though they are not advanced): {done / 1e9:.1f} G/s; "
        f"multiply-adds alone {rate / 1e9:.1f} G/s; share {done / rate:.0%}"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Time the stencil and its peers.")
    parser.add_argument("--lattice", choices=list(PROBLEMS), default="fput_strain")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each contender")
    parser.add_argument("--skip", nargs="*", default=[], choices=list(ENTRANTS)[1:])
    chosen = parser.parse_args()
    problem = PROBLEMS[chosen.lattice]
    start = problem.start()
    exact = problem.reference(*start)
    with tempfile.TemporaryDirectory() as folder:
        field = entered(chosen.lattice, Path(folder), chosen.skip, exact)
        seconds, errors, rates = dict.fromkeys(field, np.inf), {}, []
        for _ in range(chosen.rounds):
            rates.append(multiply_add_rate())
            for name, (contender, resolution) in field.items():
                spent, result = contender(resolution, *start)
                seconds[name] = min(spent, seconds[name])
                errors[name] = problem.error(result, exact)
    first = next(iter(seconds))
    for name, spent in seconds.items():
        print(
            f"{name:24s} {spent * 1e3:9.1f} ms  error {errors[name]:.1e}  "
            f"ratio {spent / seconds[first]:6.1f}  resolution {field[name][1]:.4g}"
        )
    if first == FIRST:
        print_share(problem, seconds[first], field[first][1], max(rates))
    return 0


if __name__ == "__main__":
    sys.exit(main())
