"""The whole scene of Y2 at tolerance 1e-4 against the direct way.

Scene: K2 = 4, K4 = 1, eps = 0.05, from t = -10000 to 5000, compared at -5000, 0 and 5000. Here: the
co-moving window and the splitting of reduced phase lag. The direct way: RK4 in NumPy on a ring
wide enough to hold the wave's path, at the largest step of a ladder that meets the same tolerance.
Nobody waits for that: its step is found on a short stretch about the crest, where the error is
made, its seconds are those of a few hundred steps on the wide ring, multiplied up; both are said.
"""

import sys
import time
from dataclasses import replace

import numpy as np
from contenders import numpy_rk4, run_numpy_rk4
from problem import DURATION, EPS, Array, error, initial, reference

from verify.lattice import load_scene, run

TOLERANCE = 1e-4
BEGIN, END = -10_000.0, 5_000.0
WINDOW, STEP = 4096, 1.2
CHECK_WINDOW, CHECK_STEP = 8192, 0.5
WIDE, TIMED_STEPS, ROUNDS = 60_000, 200, 3
LADDER = 250 * 2.0 ** (np.arange(24) / 4)
"""RK4 steps over the stretch of 500 time units."""


def strain(sites: int, step: float) -> tuple[float, Array]:
    """Processor seconds of the scene in a window, and y/eps of the compared sites."""
    scene = load_scene("rational_2_eps_0.05")
    scene = replace(
        scene,
        t0=BEGIN,
        snapshots=(-5000.0, 0.0, END),
        scheme="reduced_phase_6",
        sites=sites,
        step=step,
        observables=("strain",),
    )
    begin = time.process_time()
    found = np.asarray(run(scene).strain) / EPS
    return time.process_time() - begin, found


def rk4_steps() -> float:
    """The fewest RK4 steps per unit of time that meet the tolerance about the crest."""
    y, s = initial()
    exact = reference(y, s)
    with np.errstate(all="ignore"):
        for steps in LADDER:
            if error(run_numpy_rk4(steps, y, s)[1], exact) <= TOLERANCE:
                return float(round(steps) / DURATION)
    raise ValueError(f"steps must reach {TOLERANCE:g}, got {LADDER[-1]:g} (lengthen the ladder)")


def rk4_seconds_per_step(h: float) -> float:
    """Processor seconds of one RK4 step on the wide ring; the least of a few rounds."""
    y, s = initial(sites=WIDE, t0=0.0)
    return min(numpy_rk4(h, TIMED_STEPS, y, s)[0] for _ in range(ROUNDS)) / TIMED_STEPS


def main() -> int:
    """Print seconds, errors and the ratio."""
    strain(WINDOW, STEP)
    rate = rk4_steps()
    direct = rk4_seconds_per_step(1.0 / rate) * rate * (END - BEGIN)
    runs = [strain(WINDOW, STEP) for _ in range(ROUNDS)]
    seconds = min(spent for spent, _ in runs)
    difference = np.abs(runs[0][1] - strain(CHECK_WINDOW, CHECK_STEP)[1]).max()
    print(f"window of {WINDOW} sites, step {STEP}: {seconds:.2f} s")
    print(
        f"its distance from {CHECK_WINDOW} sites at step {CHECK_STEP}: {difference:.1e} eps, "
        f"wanted <= {TOLERANCE:g}"
    )
    print(
        f"RK4 in NumPy on {WIDE} sites, step {1.0 / rate:.4f} (error <= {TOLERANCE:g} eps over "
        f"{DURATION:g} time units about the crest): {direct:.0f} s, scaled from "
        f"{TIMED_STEPS} steps; ratio {direct / seconds:.0f}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
