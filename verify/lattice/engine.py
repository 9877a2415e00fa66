"""Which engine runs a scene: named, required by what is asked for, or the cheaper one by a model.

The model counts work before any pilot has run: for the stencil, sites times force evaluations, with
steps as long as stability allows; for the spectral ring, points times log2(points) times
evaluations, with steps set by the slow time and the tolerance. `Rates` holds what was measured.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from solutions import Wave
from verify.exponential.adams import ORDER
from verify.lattice.domain import least_window
from verify.lattice.extent import extent_of
from verify.lattice.scene import ENGINES, Scene
from verify.lattice.schemes import scheme_named
from verify.lattice.spectral_scale import first_density
from verify.lattice.stability import stability_limit
from verify.lattice.stencil_plan import LIMIT_SHARE, PREFERRED

SITE_BY_SITE = ("energy", "momentum", "state")
"""Observables of all sites of a lattice, which the spectral ring does not have."""


def choose_engine(scene: Scene, wave: Wave) -> str:
    """The engine that the scene names, or the one that its observables need, or the cheaper one.

    Raises ValueError if the named one cannot compute an observable.
    """
    needing = [name for name in scene.observables if name in SITE_BY_SITE]
    if scene.engine == "spectral" and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got 'spectral' (it has no ring of sites)"
        )
    if scene.engine:
        return scene.engine
    if needing or scene.scheme:
        return "stencil"
    if wave.constant_background is None:
        return "spectral"
    return min(ENGINES, key=lambda engine: SECONDS[engine](scene, wave))


@dataclass(frozen=True)
class Rates:
    """Measured constants of the model; the seconds hold the planning, too."""

    stencil: float = 2e-9
    """Seconds per site and force evaluation."""
    spectral: float = 8e-9
    """Seconds per point, log2(points) and evaluation."""
    evaluations: float = 13.0
    """Evaluations per unit of b eps^3 t times peak^3, at tolerance 1."""
    ring: float = 4.0
    """Circumference in units of the compared region."""
    density: float = 2.7
    """Points per site in units of the first density times the peak."""


RATES = Rates()


def stencil_seconds(scene: Scene, wave: Wave) -> float:
    """What a window would take."""
    scheme = scheme_named(PREFERRED)
    limit = stability_limit(scheme) / (2.0 * scene.constants.sound_speed())
    steps = (scene.end - scene.t0) / (LIMIT_SHARE * limit)
    return RATES.stencil * steps * scheme.stages * least_window(scene.compared)


def spectral_seconds(scene: Scene, wave: Wave) -> float:
    """What a ring would take; the wave's peak sets its width and its time, as in the mKdV limit."""
    assert scene.tolerance is not None
    peak = float(np.max(np.abs(extent_of(scene, wave).strain))) / scene.eps
    slow = float(wave.normal_form.b) * scene.eps**3 * (scene.end - scene.t0)
    accuracy = scene.tolerance ** (-1.0 / ORDER)
    evaluations = RATES.evaluations * (1.0 + slow * peak**3) * accuracy
    width = RATES.ring * (2 * scene.compared + 1)
    points = 2.0 + width * RATES.density * peak * first_density(wave, scene.eps)
    return RATES.spectral * evaluations * points * math.log2(points)


SECONDS: Mapping[str, Callable[[Scene, Wave], float]] = {
    "stencil": stencil_seconds,
    "spectral": spectral_seconds,
}
