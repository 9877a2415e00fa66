"""Run a scene on any lattice: derive its equation, start from the wave, integrate and compare."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.refine import Announce, Refined
from longwave.scenes.description import entries
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import enough_steps
from longwave.scenes.engines import ring_cost, run_record
from longwave.scenes.engines.domain_plan import MOVE_CELLS, ComparedCells, DomainCost, DomainPlan
from longwave.scenes.engines.entry_kinds import CellDomain, WaveEngine, WaveRuns
from longwave.scenes.engines.recorders import MOMENT_BYTES, exact_times
from longwave.scenes.engines.site_engine import SiteEngine
from longwave.scenes.engines.spectral_run import run_spectral, spectral_cost
from longwave.scenes.engines.stated_run import REFINED_COST, refinements, run_from
from longwave.scenes.observed.observables import MAP_CELLS, MEASURED, observable_named
from longwave.scenes.starts.background_growth import check_trust, trust_attributes
from longwave.scenes.starts.cached_long_wave import equation_of, scene_lattice_wave
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.scenes.starts.pulse_meter import PULSE_VARIABLES, crest, pulse_track
from longwave.support.request_limits import Announcer, ExpectedCost, check_request

if TYPE_CHECKING:
    from longwave.lattice.state import State
    from longwave.lattice.trial import Progress
    from longwave.scenes.engines.ring_spectral import SpectralRuns
    from longwave.scenes.engines.stepped_cells import SteppedCells
    from longwave.scenes.starts.lattice_wave import LatticeWave

TRANSVERSE_POWER = 2
"""Power of eps in the transverse slow variable ``Z = eps**2 m`` of the second cell number m."""


def scene_wave(scene: Scene) -> LatticeWave:
    """Return the wave of a scene, which is derived from the lattice unless `has_moving_wave`."""
    return moving_wave(scene) if scene.has_moving_wave else scene_lattice_wave(scene)


def compared_cells(scene: Scene, wave: LatticeWave) -> ComparedCells:
    """Return the cells that a scene compares; its half-width in X is also the half-width in Z."""
    powers = (1, *(TRANSVERSE_POWER,) * (wave.lattice.dimension - 1))
    return ComparedCells(wave.speed, tuple(map(scene.cells_within, powers)))


def scene_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a scene; ValueError if it is refused before any run."""
    return cells_cost(scene) if scene.tolerance is None else _runs(scene).cost(scene)


def _runs(scene: Scene) -> WaveRuns:
    return entries.table(WaveEngine)[choose_engine(scene)].runs()


def rings_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a scene on spectral rings."""
    if not scene.has_moving_wave:
        return _spectral_runs(scene).expected
    domains, wave = spectral_cost(scene), moving_wave(scene)
    values = (2.0 * scene.compared + 1.0) * len({scene.t0, *exact_times(scene)})
    cost = ring_cost.search_cost(wave.lattice, 0.0, 0.0, 1, values)
    cost = ring_cost.enlarged(cost, RING_SEARCH_COST * domains.seconds, domains.memory_bytes)
    observation = _observation_cost(scene, compared_cells(scene, wave))
    return ring_cost.enlarged(cost, observation.seconds, observation.memory_bytes)


RING_SEARCH_COST = 4.0
"""Cost of a whole search on spectral rings, in units of one run on each ring (`spectral_cost`)."""


@lru_cache(maxsize=4)
def cells_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a scene run cell by cell."""
    wave = scene_wave(scene)
    timed = in_lattice_times(scene, wave.slow)
    _check_axes(timed, wave)
    compared = compared_cells(scene, wave)
    if scene.tolerance is None:
        cost = _stated_cost(timed, wave, compared)
    else:
        # the cells blended to close a ring are negligible for other waves
        times, is_closed = (timed.t0, *timed.snapshots), wave.watches_strains
        domains = DomainCost(wave, compared, times, _window_tolerance(timed), is_closed)
        frequency, signals = domains.at_rest()
        cost = domains.cost(frequency, signals, domains.window_size(signals))[1]
    observation = _observation_cost(timed, compared)
    return ring_cost.enlarged(cost, observation.seconds, observation.memory_bytes)


def _stated_cost(timed: Scene, wave: LatticeWave, compared: ComparedCells) -> ExpectedCost:
    """Return the expected cost of a scene with stated step and sites, refinement runs included."""
    # a refined run has half the step or twice the sites
    stated, runs = timed.discretisation, 1.0 + REFINED_COST * len(refinements(timed))
    duration = timed.end - timed.t0
    enough_steps(stated.step, duration)
    sites = stated.sites * (2.0 if "domain_error" in timed.observables else 1.0)
    values = ring_cost.SINGLE_RUN_FRACTION * (2.0 * compared.reach[0] + 1.0) * len(timed.snapshots)
    steps, stages = duration / stated.step, stated.table.stages
    searched_steps = steps * (runs / ring_cost.USUAL_RUNS * stated.sites / sites)
    cost = ring_cost.search_cost(wave.lattice, sites, searched_steps, stages, values)
    moves = duration * abs(wave.speed) / MOVE_CELLS if stated.rules.moves else 0.0
    cost = ring_cost.enlarged(cost, MOVE_SECONDS * moves * runs, MOVE_BYTES * moves)
    return replace(cost, steps=steps * runs)


MOVE_SECONDS, MOVE_BYTES = 4e-5, 250.0
"""Seconds and bytes for each move of a window."""


def _observation_cost(timed: Scene, compared: ComparedCells) -> ExpectedCost:
    """Return the expected cost of measuring and storing a scene's observables."""
    entries = [observable_named(name) for name in timed.observables]
    looks = timed.look_points or timed.curve_points
    counts = {"snapshots": len(timed.snapshots), "curve": timed.curve_points, "looks": looks}
    times = {entry.measured_at: counts.get(entry.measured_at, 0) for entry in entries}
    width = math.prod(2.0 * reach + 1.0 for reach in compared.reach)
    cells = timed.discretisation.sites if timed.tolerance is None else 0.0
    sizes = {"site": width, "wavenumber": width / 2.0, "map_site": MAP_CELLS, "cell": cells}
    values = sum(
        times[entry.measured_at] * math.prod(sizes.get(name, 1.0) for name in variable.dimensions)
        for entry in entries
        for variable in entry.variables
    )
    views = float(sum(times.values()))
    return ExpectedCost(
        views * (VIEW_SECONDS + CELL_SECONDS * width), MOMENT_BYTES * views + VALUE_BYTES * values
    )


VIEW_SECONDS, CELL_SECONDS = 4e-4, 1e-6
"""Seconds to evaluate wave and lattice once, and additional seconds per cell (5e-7 to 1.6e-6)."""

VALUE_BYTES = 20.0
"""Bytes per stored number, for its copies in the recorder's rows, in an array and in the file."""


def _spectral_runs(scene: Scene) -> SpectralRuns:
    from longwave.scenes.engines.ring_spectral import SpectralRuns  # imported only when needed

    return SpectralRuns(*domain_plan(scene))


def wave_size(scene: Scene, t: float, far_field: bool) -> float:
    """Return the wave's largest deviation from background or far field (`methods.wave_size`)."""
    wave = _started_wave(scene)
    cells = compared_cells(scene, wave).cells(t)
    far = wave.far_field(cells.astype(np.int64), t) if far_field else wave.background(cells, t)
    return math.nan if far is None else float(np.max(np.abs(wave.strain(cells, t) - far)))


@lru_cache(maxsize=4)
def _started_wave(scene: Scene) -> LatticeWave:
    wave = scene_wave(scene)
    wave.start(in_lattice_times(scene, wave.slow).t0)
    return wave


def in_lattice_times(scene: Scene, slow: int) -> Scene:
    """Return the scene with slow times converted to lattice times, ``T = eps**slow t``."""
    times = scene.lattice_times(slow)
    keeps_start = scene.slow_times or scene.t0 in scene.snapshots
    timed = scene.changed(t0=times[0], snapshots=times if keeps_start else times[1:])
    if scene.tolerance is None or scene.target.steps_cells or scene.look_points is not None:
        return timed
    return timed.changed(look_points=scene.curve_points)  # a spectral run has no stops of its own


def domain_plan(scene: Scene) -> tuple[Scene, DomainPlan]:
    """Return the scene in lattice times and the domains of its wave.

    Raises ValueError for observables the lattice does not have and for a scene that would take
    too long or too much memory.
    """
    wave = scene_wave(scene)
    timed = in_lattice_times(scene, wave.slow)
    _check_axes(timed, wave)
    compared = compared_cells(scene, wave)
    observation = _observation_cost(timed, compared)
    check_request(timed.name, observation, "take fewer curve_points, look_points or compared cells")
    if scene.tolerance is None:
        stated = _stated_cost(timed, wave, compared)
        check_request(timed.name, stated, "take a larger step or fewer sites, or end earlier")
    wave.start(timed.t0)
    tolerance, is_stated = _window_tolerance(timed), scene.tolerance is None
    closed = not (is_stated and scene.has_moving_wave) or scene.discretisation.rules.ends_meet
    stops = sorted({timed.t0, *exact_times(timed)})
    return timed, DomainPlan(wave, compared, stops, tolerance, closed, is_stated)


def _window_tolerance(timed: Scene) -> float | None:
    """Return the scene's tolerance if it may be run in a window; None if it may not."""
    needs_ring = any(observable_named(name).needs_ring for name in timed.observables)
    if needs_ring or timed.tolerance is None or not timed.target.steps_cells:
        return None
    return timed.tolerance


def _check_axes(scene: Scene, wave: LatticeWave) -> None:
    """Raise ValueError for observables or a stated step that the lattice does not admit."""
    if wave.lattice.dimension > 1:
        if scene.tolerance is None:
            raise ValueError(
                f"tolerance must be given on {scene.lattice}, got {scene.numerics} (only chains "
                "accept a stated step)"
            )
        for name in scene.observables:
            if observable_named(name).one_axis:
                raise ValueError(
                    f"observables must not include {name} on {scene.lattice}, which has "
                    f"{wave.lattice.dimension} axes (it is for chains only)"
                )
    if "energy" in scene.observables and not wave.has_energy:
        raise ValueError(
            f"observables must not include energy on {scene.lattice}, which has no known energy "
            "(take a lattice of displacements)"
        )


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> run_record.RunRecord:
    """Derive the scene's equation, run its lattice from the wave, and compare the two over time.

    ``progress`` is called with the completed fraction, ``announce`` with the expected seconds;
    ``restart`` is a state of an earlier run of the same scene. Raises ValueError for a
    scene that lattice, wave or ansatz do not admit, for one that would take too long, and for a
    lattice that blows up.
    """
    announce, progress = Announcer(announce or (lambda _: None)), progress or (lambda _: None)
    if scene.has_moving_wave:
        check_trust(scene)
    try:
        if scene.tolerance is None:
            timed, domains = domain_plan(scene)
            announce(_stated_cost(timed, domains.wave, domains.compared).seconds)
            record = run_from(stated_cells(timed, domains), restart, progress)
        else:
            record = _runs(scene).record(scene, progress, announce)
    except run_record.UnfinishedRun as stop:
        _add_attributes(stop.record, scene)
        raise
    _add_attributes(record, scene)
    return record


def stated_cells(timed: Scene, domains: DomainPlan) -> SteppedCells:
    """Build the cells of the domain (ring or window) that a scene states."""
    return entries.table(CellDomain)[timed.discretisation.domain].cells(timed, domains)


def record_by_rings(scene: Scene, progress: Progress, announce: Announce) -> run_record.RunRecord:
    """Run a scene on spectral rings, which need not be causal for the paper's waves.

    If the spectral engine refuses a scene that does not name it, the scene is run cell by cell.
    """
    begun = perf_counter()
    if not scene.has_moving_wave:
        runs = _spectral_runs(scene)
        announce(runs.expected.seconds)
        result = run_record.refine_scene(runs.engine, scene, progress, announce, runs.record_of)
        record = _checked_record(runs.record_of(result.trial), result, scene, runs.times[-1], begun)
        record.scene = scene  # a scene file cannot state a spectral ring
        return record
    expected = rings_cost(scene)
    check_request(scene.name, expected, "end earlier, compare fewer sites or take fewer times")
    announce(expected.seconds)
    cells = cells_cost(scene.changed(engine="stencil"))
    first = (cells.seconds - cells.once) / ring_cost.USUAL_RUNS
    try:
        record, result = run_spectral(scene, first, progress, announce)
        return run_record.add_error_estimate(record, result, scene, begun)
    except ValueError:
        if scene.target.engine:
            raise
    return record_by_cells(scene, progress, announce)


def choose_engine(scene: Scene) -> str:
    """Return the name of the engine: the stated one, one the observables need, or the cheaper one.

    Raises ValueError if the observables exclude the named engine.
    """
    named = scene.target
    if named.engine and (named.steps_cells or not scene.has_moving_wave):
        return named.engine
    needing = [name for name in scene.observables if observable_named(name).all_sites]
    if named.engine and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got {named.engine!r} (it computes only "
            "the compared sites)"
        )
    if named.engine:
        return named.engine
    if needing or named.scheme or not scene.has_moving_wave:
        return "stencil"
    is_cheap = cells_cost(scene).seconds <= rings_cost(scene).seconds
    return "stencil" if is_cheap else "spectral"


def _add_attributes(record: run_record.RunRecord, scene: Scene) -> None:
    """Add the equation, the frame's speed, units and long names to a record."""
    wave = scene_wave(scene)
    record.attrs |= {"frame_speed": wave.speed, "power": wave.power}
    if scene.has_moving_wave:
        record.attrs |= trust_attributes(scene)
        return
    record.attrs["equation"], has_displacements = equation_of(scene)
    if "strains" in record.variables:
        attributes = {"units": "name", "long_name": "what is compared"}
        record.variables["quantity"] = ("quantity",), np.array(wave.quantities), attributes
    compares_displacements = has_displacements and not any(" " in q for q in wave.quantities)
    units = {"units": run_record.error_unit(wave.power)}
    changes = {name: {"long_name": text} for name, text in LONG_NAMES.items()}
    changes |= dict.fromkeys(("sup_error", *MEASURED), units)
    for name in changes.keys() & record.variables.keys():
        dimensions, values, attributes = record.variables[name]
        record.variables[name] = dimensions, values, attributes | changes[name]
    if not compares_displacements:
        return
    record.attrs["field_kind"] = word = "displacement"
    for name, (dimensions, values, attributes) in record.variables.items():
        texts = {
            key: text.replace("strain", word).replace("what is compared", word)
            for key, text in attributes.items()
        }
        record.variables[name] = dimensions, values, texts


LONG_NAMES = {
    "strain": "what is compared, on the lattice",
    "analytic": "the same of the closed-form wave",
    "background": "the same of the wave's background",
}
"""Long names of variables on lattices whose compared quantity need not be a strain."""


def record_by_cells(scene: Scene, progress: Progress, announce: Announce) -> run_record.RunRecord:
    """Run a scene cell by cell to its tolerance."""
    begun, engine = perf_counter(), SiteEngine(*domain_plan(scene))
    announce(engine.expected.seconds)
    parts = engine.parts()
    result = parts and run_record.refine_on_part(*parts, scene, progress, announce)
    result = result or run_record.refine_scene(engine, scene, progress, announce)
    record = _checked_record(result.trial.payload, result, scene, engine.times[-1], begun)
    _add_pulse(record, engine, result.trial.choices.step)
    if engine.domains.wave.lattice.dimension > 1:
        record.scene = scene  # a scene file cannot state the ring of a plane
    return record


def _checked_record(
    record: run_record.RunRecord | None, result: Refined, scene: Scene, end: float, begun: float
) -> run_record.RunRecord:
    """Return the record with its search's error estimate; ValueError if no step is short enough."""
    if record is None or (math.isinf(result.error) and not record.attrs["blow_up"]):
        raise ValueError(
            f"times must end before {scene.lattice} blows up, got {end:g} (steps "
            f"down to {result.trial.choices.step:.2g} do not follow it; end earlier or take a "
            "smaller eps)"
        )
    return run_record.add_error_estimate(record, result, scene, begun)


def _add_pulse(record: run_record.RunRecord, engine: SiteEngine, step: float) -> None:
    """Add peak, delay and energy of a wave in a disordered lattice to its record, if measured."""
    readings, wave = engine.metered.get(step), engine.domains.wave
    if readings is None or not readings.size:
        return
    assert wave.disorder is not None
    theory = []
    for t in engine.times:
        cells = engine.domains.compared.cells(t)
        theory.append(crest(cells, wave.strain(cells, t)[0] - wave.background(cells, t)[0]))
    columns, numbers = pulse_track(readings, engine.metered_before(step), theory)
    rows = [engine.times.index(t) for t in record.reached]
    for name, values in columns.items():
        attributes = dict(zip(("units", "long_name"), PULSE_VARIABLES[name], strict=True))
        record.variables[name] = ("time",), values[rows], attributes
    record.attrs |= numbers
    if not math.isnan(speed := wave.disorder.effective_speed):
        record.attrs["effective_speed"] = speed
