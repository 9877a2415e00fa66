"""Work and precision: error against seconds, for every scheme and both engines.

Errors are sup errors of y/eps over the compared sites at the scene's end. The stencil is judged by
the spectral ring, the ring by the stencil: never a method by itself. Seconds are those of the march
from data that are there already; what making them takes a ring, whose circumference closes them, is
told beside.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from lattice.spectral.evolution import SpectralRing
from verify.comparison import SCHEMES, Scene, load_scene, run, stability_limit
from verify.comparison.initial_data import build_wave
from verify.comparison.spectral_data import RingPlace, ring_data

Array = NDArray[np.float64]

SHARES = (0.95, 0.6, 0.4, 0.25, 0.15)
"""Steps, as shares of the largest stable one."""

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
FINEST_TOLERANCE = 1e-7
FINEST_SHARE = 0.1
SPECTRAL = "spectral"
COMPARED = 200
SITES = 3072


@dataclass(frozen=True)
class CostPoint:
    """One run: its series, its sup error of y/eps, the seconds of its march.

    ``data_seconds`` is what making the initial data took, if that counts (the spectral ring).
    """

    problem: str
    series: str
    error: float
    seconds: float
    data_seconds: float = 0.0


def smooth() -> Scene:
    """Y2 long before its peak: a weak, wide wave."""
    return _ring("rational_2_eps_0.05", -10000.0, -9750.0)


def crest() -> Scene:
    """Y2 through its peak."""
    return _ring("rational_2_eps_0.05", -125.0, 125.0)


def periodic() -> Scene:
    """The cn rogue wave through its peak."""
    return _ring("rogue_cn_k_0.5", -400.0, 400.0)


PROBLEMS: Mapping[str, Callable[[], Scene]] = {
    "smooth": smooth,
    "crest": crest,
    "periodic": periodic,
}


def _ring(name: str, t0: float, end: float) -> Scene:
    """The shipped scene between two times, on a ring whose seam no compared site hears of."""
    return replace(
        load_scene(name),
        t0=t0,
        snapshots=(end,),
        domain="ring",
        sites=SITES,
        compared=COMPARED,
        observables=("strain",),
    )


def work_precision(problem: str) -> list[CostPoint]:
    """All schemes and the spectral engine on one problem."""
    scene = PROBLEMS[problem]()
    by_stencil = _strain(_timed(by_scheme(scene, "kahan_li_8", FINEST_SHARE)))
    by_ring = _strain(_timed(spectral(scene, FINEST_TOLERANCE)))
    points = []
    for series, variants in (*_stencils(scene), (SPECTRAL, _rings(scene))):
        reference = by_stencil if series == SPECTRAL else by_ring
        for variant in variants:
            found = _timed(variant)
            error = float(np.max(np.abs(_strain(found) - reference))) / scene.eps
            whole = float(found.attrs["seconds"])
            march = march_seconds(variant, found) if series == SPECTRAL else whole
            points.append(CostPoint(problem, series, error, march, max(0.0, whole - march)))
    return points


def _stencils(scene: Scene) -> Iterator[tuple[str, list[Scene]]]:
    for scheme in SCHEMES:
        yield scheme.name, [by_scheme(scene, scheme.name, share) for share in SHARES]


def _rings(scene: Scene) -> list[Scene]:
    return [spectral(scene, tolerance) for tolerance in TOLERANCES]


def by_scheme(scene: Scene, name: str, share: float) -> Scene:
    """The scene with a scheme at a share of its largest stable step."""
    limit = stability_limit(next(scheme for scheme in SCHEMES if scheme.name == name))
    fastest = 2.0 * scene.constants.sound_speed(scene.eps * 5.0)
    return replace(scene, scheme=name, step=share * limit / fastest)


def spectral(scene: Scene, tolerance: float) -> Scene:
    """The scene by the spectral engine, which finds its own step, sampling and circumference."""
    return Scene(
        name=scene.name,
        wave=scene.wave,
        eps=scene.eps,
        t0=scene.t0,
        snapshots=scene.snapshots,
        K2=scene.K2,
        K4=scene.K4,
        compared=scene.compared,
        parameters=scene.parameters,
        observables=("strain",),
        tolerance=tolerance,
        engine="spectral",
    )


@cache
def warmed(scheme: str) -> None:
    """Compile a scheme's kernel (or the ring's), so that no run is charged for it."""
    scene = smooth()
    short = replace(scene, snapshots=(scene.t0 + 1.0,))
    run(by_scheme(short, scheme, SHARES[0]) if scheme else spectral(short, TOLERANCES[0]))


def march_seconds(scene: Scene, found: xr.Dataset) -> float:
    """Seconds of a ring's last march, done once more from data that are there already."""
    task_times = (scene.t0, *scene.snapshots)
    wave, tolerance = build_wave(scene), scene.tolerance or FINEST_TOLERANCE
    data = ring_data(scene.constants, wave, scene.eps, task_times, scene.compared, tolerance)
    ring = RingPlace(float(found.attrs["circumference"]))
    state, step = data.state(ring, int(found.attrs["sites"])), float(found.attrs["step"])
    begun = time.perf_counter()
    SpectralRing(scene.constants, state, step, absorbed=data.absorbed).at(scene.end)
    return time.perf_counter() - begun


def _timed(scene: Scene) -> xr.Dataset:
    """The run, compiled beforehand."""
    warmed(scene.scheme)
    return run(scene)


def _strain(found: xr.Dataset) -> Array:
    """The strains at the end."""
    return np.asarray(found["strain"].values[-1])
