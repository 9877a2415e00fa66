"""Cost of accuracy on the lattice: by scheme and engine, by eps, by sites and by RK4's step.

Errors are sup errors of y/eps over the compared sites at the scene's end. The stencil engine is
compared with the spectral ring and the ring with the stencil, never a method with itself. Seconds
are those of the time integration from existing data. The ring's initial data take extra time,
because its circumference has to close the wave; that time is recorded separately. The error of
the reduction itself is that of Y_j at its peak against eps.
"""

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from statistics import median

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.lattice.schemes import SCHEMES, scheme_named, stability_limit
from longwave.lattice.spectral.evolution import SpectralRing
from longwave.scenes import run
from longwave.scenes.description.named_scenes import EPS, ORDERS, load_scene, rational_family_scenes
from longwave.scenes.description.numerics import Tolerance
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.spectral_data import SpectralDomain, spectral_start
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.support.processes import Job, Key

Array = NDArray[np.float64]

SHARES = (0.95, 0.6, 0.4, 0.25, 0.15)
"""Time steps of the timed runs, as fractions of the scheme's largest stable step."""

RING_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Tolerances of the timed runs on the spectral ring."""

FINEST_TOLERANCE, FINEST_SHARE = 1e-7, 0.1
"""Reference runs: tolerance of the spectral ring, and the stencil's step over the stable one."""

SPECTRAL = "spectral"
"""Series name of the runs on the spectral ring."""

REPEATS = 3
MEDIANS = f"medians of {REPEATS} runs"
"""Words for how repeated timings are summarised."""

COMPARED, SITES = 200, 3072
"""Number of compared sites to either side of c t, and number of sites of the ring."""


@dataclass(frozen=True)
class CostPoint:
    """One run: its series, its sup error of y/eps, and the seconds of its time integration.

    ``data_seconds`` is the time to compute the initial data, for the spectral ring only.
    """

    problem: str
    series: str
    error: float
    seconds: float
    data_seconds: float = 0.0


PROBLEMS = {
    "smooth": ("rational_2_eps_0.05", -10000.0, -9750.0),
    "crest": ("rational_2_eps_0.05", -125.0, 125.0),
    "periodic": ("rogue_cn_k_0.5", -400.0, 400.0),
}
"""Problem -> (shipped scene, start time, end time).

They are Y_2 long before its peak, where it is weak and wide, Y_2 through its peak, and the cn rogue
wave through its peak.
"""


def problem_scene(problem: str) -> Scene:
    """Return a problem's scene on a ring so long that its seam affects no compared site."""
    name, t0, end = PROBLEMS[problem]
    scene = load_scene(name).changed(t0=t0, snapshots=(end,), observables=("strain",))
    return scene.changed(domain="ring", sites=SITES, compared=COMPARED)


def work_precision(problem: str) -> list[CostPoint]:
    """Measure error and seconds of all schemes and the spectral engine on one problem."""
    scene = problem_scene(problem)
    by_stencil = _strain(_timed(by_scheme(scene, "kahan_li_8", FINEST_SHARE)))
    by_ring = _strain(_timed(spectral(scene, FINEST_TOLERANCE)))
    points = []
    series = {s.name: [by_scheme(scene, s.name, share) for share in SHARES] for s in SCHEMES}
    series[SPECTRAL] = [spectral(scene, tolerance) for tolerance in RING_TOLERANCES]
    for name, variants in series.items():
        reference = by_stencil if name == SPECTRAL else by_ring
        for variant in variants:
            result = _timed(variant)
            error = float(np.max(np.abs(_strain(result) - reference))) / scene.eps
            repeats = [result, *(_timed(variant) for _ in range(REPEATS - 1))]
            total = march = median(float(repeat.attrs["seconds"]) for repeat in repeats)
            if name == SPECTRAL:
                march = median(march_seconds(variant, result) for _ in repeats)
            points.append(CostPoint(problem, name, error, march, max(0.0, total - march)))
    return points


def by_scheme(scene: Scene, name: str, share: float) -> Scene:
    """Return the scene with the named scheme at ``share`` times its largest stable step."""
    fastest = 2.0 * scene.model.sound_speed(scene.eps * 5.0)
    return scene.changed(scheme=name, step=share * stability_limit(scheme_named(name)) / fastest)


def spectral(scene: Scene, tolerance: float) -> Scene:
    """Return the scene for the spectral engine, which chooses step, sampling and circumference."""
    return replace(scene, numerics=Tolerance(tolerance, "spectral"), observables=("strain",))


@cache
def warmed(scheme: str) -> None:
    """Compile the kernel of a scheme by a short run; ``scheme`` "" means the spectral ring."""
    scene = problem_scene("smooth")
    short = replace(scene, snapshots=(scene.t0 + 1.0,))
    run(by_scheme(short, scheme, SHARES[0]) if scheme else spectral(short, RING_TOLERANCES[0]))


def march_seconds(scene: Scene, result: xr.Dataset) -> float:
    """Measure the seconds of a ring's time integration, repeated from existing initial data."""
    data = spectral_start(moving_wave(scene), scene.tolerance or FINEST_TOLERANCE)
    ring = SpectralDomain(float(result.attrs["circumference"]))
    state, step = data.state(ring, int(result.attrs["sites"])), float(result.attrs["step"])
    start = time.perf_counter()
    SpectralRing(scene.model, state, step, absorbed=data.absorbed).at(scene.end)
    return time.perf_counter() - start


def _timed(scene: Scene) -> xr.Dataset:
    """Run the scene after compiling its kernels, so that its seconds do not include compilation."""
    warmed("" if scene.tolerance else scene.discretisation.scheme)
    return run(scene)


def _strain(result: xr.Dataset) -> Array:
    """Return the strains at the last snapshot of a run."""
    return np.asarray(result["strain"].values[-1])


SLOW_TIME = 1.25
"""Length in slow time T of the runs over eps, which end at the peak T = 0."""

SPECTRAL_TOLERANCE, FINER_SPECTRAL_TOLERANCE = 1e-3, 1e-4
WINDOW_SCHEME = "reduced_phase_6"
WINDOW_STEP, RK4_STEP = 1.0, 0.1
STEPS = 400
"""Number of steps that are timed if the whole run is too long."""

WINDOW_COMPARED = 400
"""Number of compared sites to either side of c t in the study of window sizes."""

COMPARED_X, WINDOW_X = 10.0, 200.0
"""Half-width of the compared range, and width of the window, in the study over eps; in X."""

FITTED_POINTS = 3
"""Number of points, those of smallest eps, through which a power law is fitted."""

REDUCTION, TRUE_ERROR = "error of the reduction", "error of the spectral run"
"""Series names of the reduction's error, and of the error of the spectral run itself."""


@dataclass(frozen=True)
class ScalingPoint:
    """A quantity at one abscissa; ``scaled`` if it is extrapolated from part of a run.

    ``own`` is its discretisation error, 0 if that has no meaning.
    """

    series: str
    x: float
    value: float
    scaled: bool = False
    own: float = 0.0


def fit_power(points: Iterable[tuple[float, float]]) -> float:
    """Return the exponent of the power law fitted to the points (x, value).

    >>> fit_power([(1.0, 3.0), (2.0, 12.0)])
    2.0
    """
    x, value = np.log(list(points)).T
    return round(float(np.polyfit(x, value, 1)[0]), 12)


def scaling_laws(points: Iterable[ScalingPoint]) -> dict[str, float]:
    """Return each series' exponent at the smallest eps; errors set by a tolerance have none."""
    series: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if point.series != TRUE_ERROR:
            series.setdefault(point.series, []).append((point.x, point.value))
    return {
        name: fit_power(sorted(values, key=lambda pair: max(pair[0], 1 / pair[0]))[-FITTED_POINTS:])
        for name, values in series.items()
    }


def measure_at_eps(eps: float, with_reference: bool) -> list[ScalingPoint]:
    """Measure each method's seconds, and the reduction's error, for Y_2 to its peak at one eps.

    Each method changes one thing: RK4 on as many sites as sound travels (as in the paper), RK4 in a
    window, a scheme of order 6 in that window, the exponential method on the spectral ring. All but
    the last are timed for a number of steps and scaled. ``with_reference`` adds the last one's
    difference to a run with a tenth of its tolerance.
    """
    for scheme in ("", WINDOW_SCHEME, "rk4"):
        warmed(scheme)
    end = SLOW_TIME / eps**3
    base = replace(to_peak(-end), eps=eps, compared=round(COMPARED_X / eps))
    result = run(spectral(base, SPECTRAL_TOLERANCE))
    seconds = float(result.attrs["seconds"] + result.attrs["planning_seconds"])
    wide = 2 * round(base.model.sound_speed() * (base.end - base.t0)) + 2 * base.compared
    sites = max(2048, round(WINDOW_X / eps))
    rk4 = _scaled(base, "rk4", RK4_STEP, sites)
    order_6 = _scaled(base, WINDOW_SCHEME, WINDOW_STEP, sites)
    points = [
        ScalingPoint("RK4, wide lattice", 1 / eps, rk4 * wide / sites, scaled=True),
        ScalingPoint("RK4, window", 1 / eps, rk4, scaled=True),
        ScalingPoint("order 6, window", 1 / eps, order_6, scaled=True),
        ScalingPoint("spectral", 1 / eps, seconds),
        ScalingPoint(REDUCTION, eps, float(result["error"][-1]), own=_own_error(result, eps)),
    ]
    if with_reference:
        change = run(spectral(base, FINER_SPECTRAL_TOLERANCE))["strain"] - result["strain"]
        points.append(ScalingPoint(TRUE_ERROR, eps, float(abs(change).max()) / eps))
    return points


def _own_error(result: xr.Dataset, eps: float) -> float:
    """Return the run's error estimate relative to the wave's height, as relative errors are."""
    height = float(np.max(np.abs(result["analytic"] - result["background"]))) / eps
    return float(result.attrs["error_estimate"]) / height


def _scaled(base: Scene, scheme: str, step: float, sites: int) -> float:
    """Return the seconds of a whole run with that many sites, extrapolated from `STEPS` steps."""
    part = base.changed(scheme=scheme, step=step, snapshots=(base.t0 + STEPS * step,))
    part = part.changed(sites=sites, compared=min(base.compared, 200))
    seconds = float(run(part).attrs["seconds"])
    return seconds * (base.end - base.t0) / (STEPS * step)


def to_peak(t0: float) -> Scene:
    """Return the scene of the rational wave Y_2 at eps = 0.05 from time ``t0`` to its peak."""
    scene = load_scene("rational_2_eps_0.05")
    return replace(scene, t0=t0, snapshots=(0.0,), observables=("strain",))


def window_error(sites: Sequence[int], t0: float = -10000.0) -> list[ScalingPoint]:
    """Return the sup error of y/eps at Y_2's peak by window size, against the largest window."""
    scene = replace(to_peak(t0), compared=WINDOW_COMPARED)
    strains = [run(scene.changed(sites=count))["strain"].values[-1] for count in sites]
    return [
        ScalingPoint("window", count, float(np.max(np.abs(strain - strains[-1]))) / scene.eps)
        for count, strain in zip(sites[:-1], strains[:-1], strict=True)
    ]


def rk4_share(steps: Sequence[float], t0: float = -10000.0) -> list[ScalingPoint]:
    """Return the relative error of Y_2 at t = 0 by RK4's step x (0: an accurate scheme)."""
    scene = to_peak(t0)
    variants = {step: scene.changed(scheme="rk4", step=step) for step in steps}
    return [
        ScalingPoint("error figure", step, float(run(variant)["error"][-1]))
        for step, variant in {**variants, 0.0: scene}.items()
    ]


HALF_WIDTH = 25.0
"""Half-width in X of the compared range, which contains all extrema of Y_2 .. Y_5 in the runs."""

PEAK_TOLERANCES = {2: 1e-4, 3: 2e-4, 4: 1e-3, 5: 2e-3}
"""Order j of Y_j -> tolerance of y/eps; a higher order has a larger error to be measured."""

RESOLVED = 0.1
"""Ratio of discretisation error to measured error below which the latter counts as resolved."""


@dataclass(frozen=True)
class PeakError:
    """Relative sup error of one member of the rational family at T = 0.

    ``own`` is the estimated discretisation error in the same units, ``seconds`` the time of
    the run with its planning. ``fault`` is the reason if there is no value.
    """

    order: int
    eps: float
    value: float = math.nan
    own: float = math.nan
    seconds: float = math.nan
    engine: str = ""
    fault: str = ""

    @property
    def resolved(self) -> bool:
        """Whether the value is the error of the reduction rather than of the discretisation.

        >>> PeakError(2, 0.1, 0.35, 1e-4).resolved, PeakError(2, 0.1, fault="blow-up").resolved
        (True, False)
        """
        return self.own <= RESOLVED * self.value


def peak_scene(order: int, eps: float) -> Scene:
    """Return the scene of rational wave Y_order up to its peak, with the cheaper of two engines."""
    (scene,) = rational_family_scenes((order,), (eps,), PEAK_TOLERANCES[order]).values()
    return replace(scene, snapshots=(0.0,), compared=round(HALF_WIDTH / eps))


def peak_error(order: int, eps: float) -> PeakError:
    """Run the rational wave of that order; a failed run is returned as a record with a fault."""
    scene = peak_scene(order, eps)
    try:
        result = run(scene)
    except ValueError as error:
        return PeakError(order, eps, fault=str(error))
    seconds = float(result.attrs["seconds"] + result.attrs["planning_seconds"])
    engine, fault = str(result.attrs["engine"]), str(result.attrs["blow_up"])
    if fault:
        return PeakError(order, eps, seconds=seconds, engine=engine, fault=fault)
    own = _own_error(result, eps)
    return PeakError(order, eps, float(result["error"][-1]), own, seconds, engine)


def peak_laws(points: Iterable[PeakError]) -> dict[int, float | None]:
    """Return each order's power of eps, fitted to its smallest resolved eps; None if under two."""
    orders: dict[int, list[tuple[float, float]]] = {}
    for point in points:
        orders.setdefault(point.order, []).extend([(point.eps, point.value)] * point.resolved)
    return {
        order: fit_power(sorted(values)[:FITTED_POINTS]) if len(values) > 1 else None
        for order, values in sorted(orders.items())
    }


EPSILONS, MORE_EPSILONS = (0.1, 0.05, 0.025, 0.0125), (0.00625,)
RK4_STEPS, MORE_RK4_STEPS = (0.4, 0.25, 0.125), (0.0625,)
WINDOWS, MORE_WINDOWS = (2048, 4096, 8192), (16384, 32768)
"""Values of eps, RK4 steps and window sizes: in the short report, and added in the full one."""

PEAK_SECONDS, WIDE_PEAK_SECONDS = {2: 5.0, 3: 20.0, 4: 45.0, 5: 75.0}, 3.0
"""Expected seconds of a run to the peak: by order if eps is below `NARROW`, else one number."""

NARROW = 0.02


def lattice_cost_jobs(full: bool) -> dict[Key, Job]:
    """Return the jobs of all cost studies; the errors of the reduction only if ``full``."""
    jobs: dict[Key, Job] = {}
    for problem in PROBLEMS:
        jobs["precision", problem] = Job(work_precision, (problem,), 5.0 * REPEATS)
    for eps in EPSILONS + MORE_EPSILONS * full:
        jobs["scaling", eps] = Job(measure_at_eps, (eps, full), 3.0)
    jobs["rk4", ""] = Job(rk4_share, (RK4_STEPS + MORE_RK4_STEPS * full,), 10.0)
    jobs["windows", ""] = Job(window_error, (WINDOWS + MORE_WINDOWS * full,), 7.0)
    for order, eps in product(ORDERS, EPS) if full else ():
        seconds = PEAK_SECONDS[order] if eps < NARROW else WIDE_PEAK_SECONDS
        jobs["peak", (order, eps)] = Job(peak_error, (order, eps), seconds)
    return jobs
