"""Running a scene on the paper's chain: as it is stated, or to its tolerance by an engine.

Where none is named or required by what is asked for, the cheaper one by a model is taken. What the
spectral engine refuses, though it was not named, is run site by site.
"""

import math
import time

import numpy as np

from longwave.lattice.refine import Announce
from longwave.lattice.state import State
from longwave.lattice.trial import Progress
from longwave.scenes.chain.expected_cost import check_cost
from longwave.scenes.chain.expected_cost import scene_cost as scene_cost  # for `Scene`
from longwave.scenes.chain.sites import ChainSites
from longwave.scenes.chain.spectral_run import run_spectral, spectral_cost
from longwave.scenes.chain.stencil_search import run_stencil, stencil_cost
from longwave.scenes.chain.trust import check_trust, trust_attributes
from longwave.scenes.observables import observable_named
from longwave.scenes.run_record import RunRecord, UnfinishedRun, judged
from longwave.scenes.scene import Scene
from longwave.scenes.stated_run import run_from
from longwave.scenes.view import SiteView
from longwave.support.request_limits import Announcer


def choose_engine(scene: Scene) -> str:
    """The engine that the scene names, or the one that its observables need, or the cheaper one.

    Raises ValueError if the named one cannot compute an observable.
    """
    needing = [name for name in scene.observables if observable_named(name).all_sites]
    named = scene.target
    if named.engine == "spectral" and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got 'spectral' (it has no ring of sites)"
        )
    if named.engine:
        return named.engine
    if needing or named.scheme:
        return "stencil"
    cheap = stencil_cost(scene).seconds <= spectral_cost(scene).seconds
    return "stencil" if cheap else "spectral"


def run_to_tolerance(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> RunRecord:
    """Run a scene that has a tolerance; the record is `judged`.

    Raises ValueError and UnfinishedRun as `scene_run.run` does.
    """
    by_ring = choose_engine(scene) == "spectral"
    told, progress = Announcer(announce or (lambda _: None)), progress or (lambda _: None)
    seconds, found, begun = stencil_cost(scene).seconds, None, time.perf_counter()
    if by_ring:
        told(spectral_cost(scene).seconds)
        try:
            found = run_spectral(scene, seconds, progress, told)
        except ValueError:
            if scene.target.engine:
                raise
    if found is None:
        told(seconds)
        found = run_stencil(scene, progress, told)
    run, refined = found
    return judged(run, scene, refined, begun)


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """The record of a run, with what can be trusted of it, from the start or a state.

    ``progress`` and ``announce`` are as in `scene_run.run`, as is what is raised.
    """
    told = {"frame_speed": scene.model.sound_speed(), "power": 1} | trust_attributes(scene)
    try:
        record = _record(scene, progress, announce, restart)
    except UnfinishedRun as stop:
        stop.record.attrs |= told
        raise
    record.attrs |= told
    return record


def _record(
    scene: Scene, progress: Progress | None, announce: Announce | None, restart: State | None
) -> RunRecord:
    expected = check_cost(scene)
    if scene.tolerance is None:
        Announcer(announce or (lambda _: None))(expected.seconds)
        return run_from(ChainSites(scene, scene.moving_wave), restart, progress)
    check_trust(scene)
    return run_to_tolerance(scene, progress, announce)


def wave_size(scene: Scene, t: float, far_field: bool) -> float:
    """The wave's largest deviation from its background, or its far field (`Scene.wave_size`)."""
    none = np.zeros((1, 0))
    view = SiteView(scene.moving_wave, State(t, none, none))
    found = view.far_field if far_field else view.background
    return math.nan if found is None else float(np.max(np.abs(view.analytic - found)))
