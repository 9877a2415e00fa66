"""Which engine runs a scene: named, required by what is asked for, or the cheaper one by a model.

The model counts work before any pilot has run: for the stencil, sites times force evaluations, with
steps as long as stability allows; for the spectral ring, points times log2(points) times
evaluations, with steps set by the slow time and the tolerance, on every ring that the search for
the domain goes through. `Rates` holds what was measured.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lattice.schemes.catalogue import scheme_named
from lattice.spectral.exponential import ORDER
from lattice.spectral.ring import ALIKE, telling_step
from solutions import Wave
from verify.comparison.scene import ENGINES, Scene
from verify.comparison.spectral_data import first_density, ring_data
from verify.comparison.stencil import (
    COST,
    PREFERRED,
    domain_kind,
    extent_of,
    least_sites,
    longest_step,
)
from verify.comparison.unfinished import LONG

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
    return min(ENGINES, key=lambda engine: SECONDS[engine](scene, wave))


@dataclass(frozen=True)
class Rates:
    """Measured constants of the model; the seconds hold the planning, too."""

    stencil_start: float = 0.03
    spectral_start: float = 0.08
    """Seconds before the first step."""
    stencil: float = 6e-10
    """Seconds per site and force evaluation."""
    spectral: float = 2.2e-9
    """Seconds per point, log2(points) and evaluation."""
    evaluations: float = 11.0
    """Evaluations per unit of b eps^3 t times peak^3, at tolerance 1."""
    density: float = 1.7
    """Points per site in units of the first density times the peak."""
    tail: float = 20.0
    """What doubling a ring to the circumference L changes, on a constant background, times
    (eps L/2)^3 and per unit of the peak: the absorbed ring's law."""
    apart: float = 400.0
    """Spread of the energies of a ring's lattices, in units of exp(-pi^2/(a |y|)); 250 to 520 for
    solitons of a |y| from 0.35 to 0.6."""
    phase: float = 0.1
    """On a periodic one, times (eps L/2)^2 and per unit of b eps^3 t times peak^3."""


RATES = Rates()

STEPPING = 2.0
"""Runs on the first ring with all longer steps, in units of the last of them."""

FAR_DEARER = 100.0
"""The spectral engine gives up at so many times what the stencil takes, and not before ``LONG``."""

SHARE = 0.6
"""Share of the tolerance that doubling the last ring may change."""


def stencil_seconds(scene: Scene, wave: Wave) -> float:
    """What a window would take, or on a periodic background a ring."""
    scheme, extent = scheme_named(PREFERRED), extent_of(scene, wave)
    steps = (scene.end - scene.t0) / longest_step(scene, scheme, extent)
    sites = least_sites(scene, wave, domain_kind(scene, wave), extent)
    return RATES.stencil_start + RATES.stencil * steps * scheme.stages * sites


def stated_seconds(scene: Scene) -> float:
    """What a scene takes that states its step and its sites, with the runs that measure errors."""
    steps = (scene.end - scene.t0) / scene.step
    runs = 1.0 + sum(COST.get(name, 0.0) for name in scene.observables)
    updates = steps * scene.scheme_table.stages * scene.sites
    return RATES.stencil_start + RATES.stencil * updates * runs


def spectral_seconds(scene: Scene, wave: Wave) -> float:
    """What rings would take; the wave's peak sets their points and steps, as in the mKdV limit."""
    assert scene.tolerance is not None
    peak = float(np.max(np.abs(extent_of(scene, wave).strain))) / scene.eps
    turns = float(wave.normal_form.b) * scene.eps**3 * (scene.end - scene.t0) * peak**3
    evaluations = RATES.evaluations * (1.0 + turns) * scene.tolerance ** (-1.0 / ORDER)
    steepness = float(wave.normal_form.a) * scene.eps * peak
    apart = RATES.apart * math.exp(-(math.pi**2) / steepness) * (1.0 + turns) * peak
    if apart > ALIKE * scene.tolerance:
        step = telling_step(scene.constants.sound_speed())
        evaluations = max(evaluations, (scene.end - scene.t0) / step)
    first, *wider = _circumferences(scene, wave, peak, turns)
    density = RATES.density * peak * first_density(wave, scene.eps)
    points = density * np.array([*[first] * round(STEPPING), 2.0 * first, *wider]) + 2.0
    work = evaluations * float(np.sum(points * np.log2(points)))
    return RATES.spectral_start + RATES.spectral * work


def _circumferences(scene: Scene, wave: Wave, peak: float, turns: float) -> list[float]:
    """Those that are tried: doubled until the law says that it is enough, or until the causal one.

    On a constant background a doubling changes by the tails, which are cut off at the seam; on a
    periodic one by what the wave radiates. A kink's ring is causal.
    """
    assert scene.tolerance is not None
    data = ring_data(
        scene.constants,
        wave,
        scene.eps,
        (scene.t0, *scene.snapshots),
        scene.compared,
        scene.tolerance,
    )
    assert data.causal is not None
    if data.kink:
        return [data.causal.circumference]
    level, power = (RATES.phase * turns, 2) if data.periodic else (RATES.tail * peak, 3)
    tried = [data.smallest]
    while tried[-1] < data.causal.circumference:
        change = level / (scene.eps * tried[-1]) ** power
        tried.append(2.0 * tried[-1])
        if change <= SHARE * scene.tolerance:
            break
    return [min(length, data.causal.circumference) for length in tried]


def most_spectral_work(scene: Scene, wave: Wave) -> float:
    """Points times their log2 times evaluations that rings may take at once.

    A ring on which short waves come round for ever improves ever more slowly. Where that takes long
    and a window needs next to nothing, the ring is no help to anyone.
    """
    return max(LONG, FAR_DEARER * stencil_seconds(scene, wave)) / RATES.spectral


SECONDS: Mapping[str, Callable[[Scene, Wave], float]] = {
    "stencil": stencil_seconds,
    "spectral": spectral_seconds,
}
