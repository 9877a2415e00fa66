"""A scene with a tolerance by the stencil: pilots, then the run, in a window wide enough."""

import math
import time

import xarray as xr

from solutions import Wave
from verify.lattice.discretisation import StrainSamples
from verify.lattice.estimate import Estimate
from verify.lattice.recording import Progress
from verify.lattice.scene import Scene
from verify.lattice.stencil_plan import StencilPlan, plan_stencil
from verify.lattice.stencil_run import run_from

ATTEMPTS = 6
"""Most windows tried."""

PLANNING_SHARE = 0.4
"""Share of the progress that the pilots are taken to be."""


def run_stencil(scene: Scene, wave: Wave, progress: Progress) -> tuple[xr.Dataset, Estimate, float]:
    """The run of a scene to its tolerance, the estimated error, and the seconds of planning.

    Runs in windows that turned out too small count as planning. If the last window tried is too
    small as well, the estimate says so. Raises ValueError for what wave or lattice do not admit.
    """
    begun = time.perf_counter()
    plan = plan_stencil(scene, wave, lambda share: progress(PLANNING_SHARE * share))
    done = PLANNING_SHARE
    for _ in range(ATTEMPTS):
        planned = time.perf_counter() - begun
        run, space = _attempt(plan, _rest(progress, done))
        if plan.settled(space):
            break
        plan, done = plan.wider(space), 0.5 * (1.0 + done)
    return run, Estimate(plan.time, space, plan.next_decade), planned


def _attempt(plan: StencilPlan, progress: Progress) -> tuple[xr.Dataset, float]:
    """The run as planned, and its domain's error."""
    seen = StrainSamples(plan.pilots.times)
    run = run_from(plan.scene, None, progress, [seen])
    return run, math.inf if run.attrs["blow_up"] else plan.space(seen.samples)


def _rest(progress: Progress, done: float) -> Progress:
    """The progress of what is left when a share is done."""
    return lambda share: progress(done + (1.0 - done) * share)
