"""How cost and error scale: with eps, with the number of sites, with RK4's time step."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from verify.comparison import Scene, load_scene, relative_sup_error, run
from verify.studies.cost_precision import spectral, warmed

SLOW_TIME = 1.25
"""T runs from minus this to 0, the peak."""

TOLERANCE, FINER_TOLERANCE = 1e-3, 1e-4
WINDOW_SCHEME = "reduced_phase_6"
WINDOW_STEP, RK4_STEP = 1.0, 0.1
STEPS = 400
"""Steps of a run that is timed, where the whole is too long."""

WINDOW_COMPARED = 400
COMPARED_X = 10.0
WINDOW_X = 200.0
"""Half-width compared, and width of a window, in X."""

REDUCTION, TRUE_ERROR = "error of the reduction", "error of the spectral run"


@dataclass(frozen=True)
class ScalingPoint:
    """A quantity at one abscissa; ``scaled`` if only a fraction of the run was timed."""

    series: str
    x: float
    value: float
    scaled: bool = False


@dataclass(frozen=True)
class Law:
    """value = factor * x^exponent, fitted to a series."""

    series: str
    factor: float
    exponent: float


def fit_law(points: Sequence[ScalingPoint]) -> Law:
    """The power law through the points of one series.

    >>> fit_law([ScalingPoint("s", 1.0, 3.0), ScalingPoint("s", 2.0, 12.0)]).exponent
    2.0
    """
    exponent, level = np.polyfit(
        np.log([point.x for point in points]), np.log([point.value for point in points]), 1
    )
    return Law(points[0].series, float(np.exp(level)), round(float(exponent), 12))


def at_eps(eps: float, judged: bool) -> list[ScalingPoint]:
    """Seconds of each way, and the reduction's error, for Y2 to its peak at one eps.

    From one to the next a way changes one thing: RK4 on as many sites as sound travels (the
    paper's), RK4 in a window, a scheme of order 6 in that window, the exponential method on the
    spectral ring. All but the last are timed for a number of steps and scaled. If ``judged``, the
    last one's distance to a run with a tenth of its tolerance is measured, too.
    """
    for scheme in ("", WINDOW_SCHEME, "rk4"):
        warmed(scheme)
    base = _scene(eps)
    found = run(spectral(base, TOLERANCE))
    whole = float(found.attrs["seconds"] + found.attrs["planning_seconds"])
    wide = 2 * round(base.constants.sound_speed() * (base.end - base.t0)) + 2 * base.compared
    sites = max(2048, round(WINDOW_X / eps))
    rk4 = _scaled(base, "rk4", RK4_STEP, sites)
    rows = (found[name].values[-1] for name in ("strain", "analytic", "background"))
    points = [
        ScalingPoint("RK4, wide lattice", 1 / eps, rk4 * wide / sites, scaled=True),
        ScalingPoint("RK4, window", 1 / eps, rk4, scaled=True),
        ScalingPoint(
            "order 6, window", 1 / eps, _scaled(base, WINDOW_SCHEME, WINDOW_STEP, sites), True
        ),
        ScalingPoint("spectral", 1 / eps, whole),
        ScalingPoint(REDUCTION, eps, relative_sup_error(*rows)),
    ]
    if judged:
        finer = run(spectral(base, FINER_TOLERANCE))["strain"] - found["strain"]
        points.append(ScalingPoint(TRUE_ERROR, eps, float(abs(finer).max()) / eps))
    return points


def _scene(eps: float) -> Scene:
    end = SLOW_TIME / eps**3
    return replace(
        load_scene("rational_2_eps_0.05"),
        eps=eps,
        t0=-end,
        snapshots=(0.0,),
        compared=round(COMPARED_X / eps),
        observables=("strain",),
    )


def _scaled(base: Scene, scheme: str, step: float, sites: int) -> float:
    """Seconds of the whole run in a window of ``sites``, from STEPS steps of it."""
    part = base.changed(
        scheme=scheme,
        step=step,
        sites=sites,
        compared=min(base.compared, 200),
        snapshots=(base.t0 + STEPS * step,),
    )
    seconds = float(run(part).attrs["seconds"])
    return seconds * (base.end - base.t0) / (STEPS * step)


def _figure(t0: float) -> Scene:
    """Y2 at eps = 0.05 up to its peak."""
    scene = load_scene("rational_2_eps_0.05")
    return replace(scene, t0=t0, snapshots=(0.0,), observables=("strain",))


def window_error(sites: Sequence[int], t0: float = -10000.0) -> list[ScalingPoint]:
    """Sup error of y/eps at the peak of Y2 by the window's size, against the largest of them."""
    scene = replace(_figure(t0), compared=WINDOW_COMPARED)
    strains = [run(scene.changed(sites=count))["strain"].values[-1] for count in sites]
    return [
        ScalingPoint("window", count, float(np.max(np.abs(strain - strains[-1]))) / scene.eps)
        for count, strain in zip(sites[:-1], strains[:-1], strict=True)
    ]


def rk4_share(steps: Sequence[float], t0: float = -10000.0) -> list[ScalingPoint]:
    """The paper's error figure of Y2 at t = 0 by RK4's step; x = 0 stands for an exact flow."""
    scene = _figure(t0)
    variants = {step: scene.changed(scheme="rk4", step=step) for step in steps}
    points = []
    for step, variant in {**variants, 0.0: scene}.items():
        found = run(variant)
        rows = (found[name].values[-1] for name in ("strain", "analytic", "background"))
        points.append(ScalingPoint("error figure", step, relative_sup_error(*rows)))
    return points
