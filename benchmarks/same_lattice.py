"""The stencil and its peers on the same lattice and data, interleaved in one run.

A ring of 4096 sites, 500 time units, the wave Y2 (K2 = 4, K4 = 1, eps = 0.05) started at t = -250;
the error is the sup over sites of |y - reference| / eps, the reference a composition of order 10.
Each contender gets the coarsest resolution on a ladder that brings its error to 1e-6, found by
bisection; then all run in turn, equally often, and the least processor time of each counts. Absent
peers are reported as absent, those whose ladder ends above 1e-6 as not reached. Ratios are to the
stencil with the first scheme.
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
    run_numpy_rk4,
    run_scipy,
    stencil_contender,
)
from peak import multiply_add_rate
from problem import CONSTANTS, SITES, Array, error, initial, reference

from lattice.kernels.blocked import OPERATIONS
from lattice.schemes import (
    BLANES_MOAN_6,
    KAHAN_LI_8,
    MCLACHLAN_4,
    REDUCED_PHASE_6,
    SUZUKI_UMENO_8,
    Scheme,
)

TARGET = 1e-6
TOLERANCES = (1e4, 1e11, 10.0**0.25)

Ladder = tuple[float, float, float]
"""Least and largest resolution, and the factor between rungs."""


def _stencil(scheme: Scheme) -> Callable[[Path], Contender]:
    return lambda _: stencil_contender(scheme)


ENTRANTS: dict[str, tuple[Callable[[Path], Contender], Ladder]] = {
    "stencil reduced_phase_6": (_stencil(REDUCED_PHASE_6), (300, 1200, 1.02)),
    "stencil blanes_moan_6": (_stencil(BLANES_MOAN_6), (600, 2400, 1.02)),
    "stencil kahan_li_8": (_stencil(KAHAN_LI_8), (600, 2400, 1.02)),
    "stencil suzuki_umeno_8": (_stencil(SUZUKI_UMENO_8), (600, 2400, 1.02)),
    "stencil mclachlan_4": (_stencil(MCLACHLAN_4), (4000, 16000, 1.02)),
    "Boost odeint RKN": (boost_contender, (4000, 16000, 1.02)),
    "SciPy DOP853": (lambda _: run_scipy, TOLERANCES),
    "Diffrax Dopri8": (lambda _: diffrax_contender(), TOLERANCES),
    "heyoka.py": (lambda _: heyoka_contender(), TOLERANCES),
    "NumPy RK4": (lambda _: run_numpy_rk4, (12000, 48000, 2.0**0.25)),
}

FIRST = next(iter(ENTRANTS))


def coarsest(
    contender: Contender, ladder: Ladder, y: Array, s: Array, exact: Array
) -> float | None:
    """The least resolution of the ladder that meets the target, by bisection.

    None if the ladder's last rung misses it.
    """
    least, largest, factor = ladder
    rungs = least * factor ** np.arange(int(np.log(largest / least) / np.log(factor)) + 2)
    low, high = -1, len(rungs) - 1
    if not error(contender(rungs[high], y, s)[1], exact) <= TARGET:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        met = error(contender(rungs[middle], y, s)[1], exact) <= TARGET
        low, high = (low, middle) if met else (middle, high)
    return float(rungs[high])


def entered(
    folder: Path, skip: list[str], y: Array, s: Array, exact: Array
) -> dict[str, tuple[Contender, float]]:
    """The contenders that meet the target, with their resolutions; tells of the others."""
    found = {}
    for name, (make, ladder) in ENTRANTS.items():
        if name in skip:
            continue
        try:
            contender = make(folder)
        except (ImportError, OSError) as reason:
            print(f"{name:24s} absent: {reason}")
            continue
        with np.errstate(all="ignore"):
            resolution = coarsest(contender, ladder, y, s, exact)
        if resolution is None:
            print(f"{name:24s} not reached: its ladder ends above an error of {TARGET:g}")
        else:
            found[name] = contender, resolution
    return found


def print_share(seconds: float, steps: float, rate: float) -> None:
    """The kernel's arithmetic as a share of the core's multiply-add rate."""
    operations = OPERATIONS[CONSTANTS.K3 != 0, CONSTANTS.K4 != 0]
    evaluations = SITES * round(steps) * REDUCED_PHASE_6.stages
    done = operations * evaluations / seconds
    print(
        f"{operations} operations per site and force evaluation (a multiply-add counts once): "
        f"{done / 1e9:.1f} G/s; multiply-adds alone {rate / 1e9:.1f} G/s; share {done / rate:.0%}"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Time the stencil and its peers.")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each contender")
    parser.add_argument("--skip", nargs="*", default=[], choices=list(ENTRANTS)[1:])
    chosen = parser.parse_args()
    y, s = initial()
    exact = reference(y, s)
    with tempfile.TemporaryDirectory() as folder:
        field = entered(Path(folder), chosen.skip, y, s, exact)
        seconds, errors, rates = dict.fromkeys(field, np.inf), {}, []
        for _ in range(chosen.rounds):
            rates.append(multiply_add_rate())
            for name, (contender, resolution) in field.items():
                spent, result = contender(resolution, y, s)
                seconds[name] = min(spent, seconds[name])
                errors[name] = error(result, exact)
    first = next(iter(seconds))
    for name, spent in seconds.items():
        print(
            f"{name:24s} {spent * 1e3:9.1f} ms  error {errors[name]:.1e}  "
            f"ratio {spent / seconds[first]:6.1f}  resolution {field[name][1]:.4g}"
        )
    if first == FIRST:
        print_share(seconds[first], field[first][1], max(rates))
    return 0


if __name__ == "__main__":
    sys.exit(main())
