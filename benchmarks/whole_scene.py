"""The whole scene of Y2 at tolerance 1e-4 against the direct way.

Scene: K2 = 4, K4 = 1, eps = 0.05, from t = -10000 to 5000, compared at -5000, 0 and 5000. Here:
the run that the tolerance asks for, with the pilots that choose step and window. The direct way:
RK4 in NumPy on a ring wide enough to hold the wave's path, at the largest step of a ladder that
meets the same tolerance. Nobody waits for that: its step is found in a window about the crest, its
seconds are those of a few hundred steps on the wide ring, multiplied up.

NumPy uses one core, the run all: both are timed on one core, and the elapsed time on all is printed
as well. (Where two cores of the machine are two threads of one, processor seconds of both together
are no measure of either.)
"""

import os
import sys
import time
from dataclasses import replace

import numpy as np
import xarray as xr
from contenders import numpy_rk4
from problem import EPS, PROBLEMS, Array, initial

from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene

TOLERANCE = 1e-4
BEGIN, END = -10_000.0, 5_000.0
SCENE = replace(
    load_scene("rational_2_eps_0.05"),
    t0=BEGIN,
    snapshots=(-5000.0, 0.0, END),
    observables=("strain",),
)
CHECK_WINDOW, CHECK_STEP = 8192, 0.25
WIDE, TIMED_STEPS, ROUNDS = 60_000, 200, 3
LADDER = 0.1 * 2.0 ** (-np.arange(16) / 8)
"""Steps of RK4."""


def timed_run(cores: set[int]) -> tuple[float, xr.Dataset]:
    """Run the scene on those cores to the tolerance; return seconds with pilots, and the run."""
    usable = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    begin = time.perf_counter()
    found = run(SCENE.with_tolerance(TOLERANCE))
    seconds = time.perf_counter() - begin
    os.sched_setaffinity(0, usable)
    return seconds, found


def strain(**changes: object) -> Array:
    """Return y/eps of the compared sites, with scheme, step and window stated."""
    return np.asarray(run(SCENE.changed(**changes)).strain) / EPS  # type: ignore[arg-type]


def rk4_step() -> float:
    """Return RK4's longest step of a ladder that meets the tolerance about the crest."""
    crest = {"sites": 1024, "compared": 200}
    exact = strain(scheme="kahan_li_8", step=CHECK_STEP, **crest)
    for step in LADDER:
        if np.abs(strain(scheme="rk4", step=step, **crest) - exact).max() <= TOLERANCE:
            return float(step)
    raise ValueError(f"steps must reach {TOLERANCE:g}, got {LADDER[-1]:g} (lengthen the ladder)")


def rk4_seconds_per_step(h: float) -> float:
    """Return processor seconds of one RK4 step on the wide ring; the least of a few rounds."""
    y, s = initial(sites=WIDE, t0=0.0)
    return (
        min(numpy_rk4(PROBLEMS["fput_strain"], h, TIMED_STEPS, y, s)[0] for _ in range(ROUNDS))
        / TIMED_STEPS
    )


def main() -> int:
    """Print seconds, errors and the ratio."""
    cores = os.sched_getaffinity(0)
    timed_run(cores)
    step = rk4_step()
    direct = rk4_seconds_per_step(step) * (END - BEGIN) / step
    waited = min(timed_run(cores)[0] for _ in range(ROUNDS))
    runs = [timed_run({min(cores)}) for _ in range(ROUNDS)]
    seconds = min(spent for spent, _ in runs)
    found = runs[0][1]
    finer = strain(scheme="kahan_li_8", sites=CHECK_WINDOW, step=CHECK_STEP)
    difference = np.abs(found.strain / EPS - finer).max()
    cost = found.attrs
    print(
        f"tolerance {TOLERANCE:g}: {seconds:.2f} s on one core, {waited:.2f} s on {len(cores)}, "
        f"pilots included ({cost['scheme']}, {cost['steps']} steps, {cost['sites']} sites)"
    )
    print(
        f"distance from {CHECK_WINDOW} sites, kahan_li_8, step {CHECK_STEP}: {difference:.1e} eps; "
        f"estimated {cost['error_estimate']:.1e}"
    )
    print(
        f"RK4 in NumPy on {WIDE} sites, step {step:.4f} (the longest within {TOLERANCE:g} eps): "
        f"{direct:.0f} s, scaled from {TIMED_STEPS} steps; ratio {direct / seconds:.0f} on one, "
        f"{direct / waited:.0f} to what is waited for"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
