"""Running a scene on any lattice: derive, start from the wave, integrate, compare."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.refine import Announce
from longwave.scenes.description import entries
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import enough_steps
from longwave.scenes.engines.domain_plan import STRIDE, ComparedCells, DomainPlan, expected_rings
from longwave.scenes.engines.entry_kinds import CellDomain, WaveEngine, WaveRuns
from longwave.scenes.engines.recorders import MOMENT_BYTES, exact_times
from longwave.scenes.engines.ring_cost import SHOWN, USUAL_RUNS, search_cost
from longwave.scenes.engines.run_record import (
    RunRecord,
    UnfinishedRun,
    error_unit,
    judged,
    searched,
    searched_on_part,
)
from longwave.scenes.engines.site_engine import SiteEngine
from longwave.scenes.engines.spectral_run import run_spectral, spectral_cost
from longwave.scenes.engines.stated_run import run_from, stated_runs
from longwave.scenes.observed.observables import MAP_CELLS, MEASURED, observable_named
from longwave.scenes.starts.background_growth import check_trust, trust_attributes
from longwave.scenes.starts.kept_long_wave import equation_of, scene_lattice_wave
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.scenes.starts.pulse_meter import PULSE_VARIABLES, crest, pulse_track
from longwave.support.request_limits import Announcer, ExpectedCost, check_request

if TYPE_CHECKING:
    from longwave.lattice.refine import Refined
    from longwave.lattice.state import State
    from longwave.lattice.trial import Progress
    from longwave.scenes.engines.ring_spectral import SpectralRuns
    from longwave.scenes.engines.stepped_cells import SteppedCells
    from longwave.scenes.starts.lattice_wave import LatticeWave

ACROSS = 2
"""``Z = eps**2 m``."""


def scene_wave(scene: Scene) -> LatticeWave:
    """The wave of a scene: the paper's without a derivation, any other by its lattice's."""
    return moving_wave(scene) if scene.has_moving_wave else scene_lattice_wave(scene)


def compared_cells(scene: Scene, wave: LatticeWave) -> ComparedCells:
    """The cells of a scene's region; a half-width in X is one in Z, too."""
    powers = (1, *(ACROSS,) * (wave.lattice.dimension - 1))
    return ComparedCells(wave.speed, tuple(map(scene.cells_within, powers)))


def scene_cost(scene: Scene) -> ExpectedCost:
    """What the scene is expected to cost, by its lattice's waves about the rest.

    Raises ValueError as `record_scene` does for what is wrong before anything is run.
    """
    return cells_cost(scene) if scene.tolerance is None else _runs(scene).cost(scene)


def _runs(scene: Scene) -> WaveRuns:
    return entries.table(WaveEngine)[choose_engine(scene)].runs()


def rings_cost(scene: Scene) -> ExpectedCost:
    """Return what the scene is expected to cost on spectral rings."""
    if not scene.has_moving_wave:
        return _spectral_runs(scene).expected
    domains = spectral_cost(scene)
    kept = (2.0 * scene.compared + 1.0) * len({scene.t0, *exact_times(scene)})
    found = search_cost(moving_wave(scene).lattice, 0.0, 0.0, 1, kept)
    found = _with(found, replace(domains, seconds=RINGS * domains.seconds))
    return _with(found, _seen_cost(scene, compared_cells(scene, moving_wave(scene))))


RINGS = 4.0
"""Runs of a search on spectral rings, in units of the first."""


@lru_cache(maxsize=4)
def cells_cost(scene: Scene) -> ExpectedCost:
    """Return what the scene is expected to cost cell by cell."""
    wave = scene_wave(scene)
    timed = in_lattice_times(scene, wave.slow)
    _check_axes(timed, wave)
    compared = compared_cells(scene, wave)
    if scene.tolerance is None:
        found = _stated_cost(timed, wave, compared)
    else:
        found = expected_rings(
            wave, compared, (timed.t0, *timed.snapshots), _window_tolerance(timed)
        )
    return _with(found, _seen_cost(timed, compared))


def _with(cost: ExpectedCost, more: ExpectedCost) -> ExpectedCost:
    """The cost, with the time and the memory that more takes."""
    return replace(
        cost,
        seconds=cost.seconds + more.seconds,
        memory_bytes=cost.memory_bytes + more.memory_bytes,
    )


def _stated_cost(timed: Scene, wave: LatticeWave, compared: ComparedCells) -> ExpectedCost:
    """What is taken by a scene that states its step and its sites, with runs that refine it."""
    stated, runs = timed.discretisation, stated_runs(timed)
    duration = timed.end - timed.t0
    enough_steps(stated.step, duration)
    sites = stated.sites * (2.0 if "domain_error" in timed.observables else 1.0)
    kept = SHOWN * (2.0 * compared.reach[0] + 1.0) * len(timed.snapshots)
    steps = duration / stated.step
    share = runs / USUAL_RUNS * stated.sites / sites
    found = search_cost(wave.lattice, sites, steps * share, stated.table.stages, kept)
    moves = duration * abs(wave.speed) / STRIDE if stated.rules.moves else 0.0
    return replace(
        found,
        seconds=found.seconds + MOVE_SECONDS * moves * runs,
        memory_bytes=found.memory_bytes + MOVE_BYTES * moves,
        steps=steps * runs,
    )


MOVE_SECONDS, MOVE_BYTES = 4e-5, 250.0
"""For each move of a window."""


def _seen_cost(timed: Scene, compared: ComparedCells) -> ExpectedCost:
    """What it takes to look at a run as often as its observables ask, and to keep what they see."""
    entries = [observable_named(name) for name in timed.observables]
    looks = timed.look_points or timed.curve_points
    counts = {"snapshots": len(timed.snapshots), "curve": timed.curve_points, "looks": looks}
    times = {entry.seen: counts.get(entry.seen, 0) for entry in entries}
    width = math.prod(2.0 * reach + 1.0 for reach in compared.reach)
    cells = timed.discretisation.sites if timed.tolerance is None else 0.0
    sizes = {"site": width, "wavenumber": width / 2.0, "map_site": MAP_CELLS, "cell": cells}
    values = sum(
        times[entry.seen] * math.prod(sizes.get(name, 1.0) for name in variable.dimensions)
        for entry in entries
        for variable in entry.variables
    )
    views = float(sum(times.values()))
    return ExpectedCost(
        views * (VIEW_SECONDS + SEEN_SECONDS * width), MOMENT_BYTES * views + VALUE_BYTES * values
    )


VIEW_SECONDS, SEEN_SECONDS = 4e-4, 1e-6
"""To see wave and lattice once, and for each compared cell: 5e-7 to 1.6e-6."""

VALUE_BYTES = 20.0
"""For each number that is kept: in rows, in an array, and as a file's content."""


def _spectral_runs(scene: Scene) -> SpectralRuns:
    from longwave.scenes.engines.ring_spectral import SpectralRuns  # with a library of its own

    return SpectralRuns(*domain_plan(scene))


def wave_size(scene: Scene, t: float, far_field: bool) -> float:
    """The wave's largest deviation from its background (`methods.wave_size`)."""
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
    """The scene with t0 and snapshots in the place of slow times; ``T = eps**slow t``."""
    times = scene.lattice_times(slow)
    timed = scene.changed(t0=times[0], snapshots=times if scene.keeps_start else times[1:])
    if scene.tolerance is None or scene.target.steps_cells or scene.look_points is not None:
        return timed
    return timed.changed(look_points=scene.curve_points)  # it stops nowhere by itself


def _stops(timed: Scene) -> Sequence[float]:
    return sorted({timed.t0, *exact_times(timed)})


def domain_plan(scene: Scene) -> tuple[Scene, DomainPlan]:
    """The scene in the lattice's times, and the domains of its wave from then on."""
    wave = scene_wave(scene)
    timed = in_lattice_times(scene, wave.slow)
    _check_axes(timed, wave)
    compared = compared_cells(scene, wave)
    seen = _seen_cost(timed, compared)
    check_request(timed.name, seen, "take fewer curve_points, look_points or compared cells")
    if scene.tolerance is None:
        stated = _stated_cost(timed, wave, compared)
        check_request(timed.name, stated, "take a larger step or fewer sites, or end earlier")
    wave.start(timed.t0)
    tolerance, is_stated = _window_tolerance(timed), scene.tolerance is None
    closed = not (is_stated and scene.has_moving_wave) or scene.discretisation.rules.ends_meet
    return timed, DomainPlan(wave, compared, _stops(timed), tolerance, closed, is_stated)


def _window_tolerance(timed: Scene) -> float | None:
    """The tolerance of a scene that may be run in a window; None where it needs a ring."""
    needs_ring = any(observable_named(name).needs_ring for name in timed.observables)
    if needs_ring or timed.tolerance is None or not timed.target.steps_cells:
        return None
    return timed.tolerance


def _check_axes(scene: Scene, wave: LatticeWave) -> None:
    """Refuse what lattices of several axes, or without an energy, do not have."""
    if wave.lattice.dimension > 1:
        if scene.tolerance is None:
            raise ValueError(
                f"tolerance must be given on {scene.lattice}, got {scene.numerics} (a step may be "
                "stated on chains alone)"
            )
        for name in scene.observables:
            if observable_named(name).one_axis:
                raise ValueError(
                    f"observables must have no {name} on {scene.lattice}, which has "
                    f"{wave.lattice.dimension} axes (it is for chains)"
                )
    if "energy" in scene.observables and not wave.has_energy:
        raise ValueError(
            f"observables must have no energy on {scene.lattice}, whose equations conserve none "
            "that is known (take a lattice of displacements)"
        )


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """Derive the scene's equation, start its lattice from the wave, and compare at all times.

    ``progress`` is called with the share of the work that is done, ``announce`` with the seconds
    that are expected to pass; ``restart`` is a state of a run of the same scene to begin at. Raises
    ValueError in one line for everything that lattice, wave and ansatz do not admit, for what would
    take too long, and for a lattice that blows up.
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
    except UnfinishedRun as stop:
        _tell(stop.record, scene)
        raise
    _tell(record, scene)
    return record


def stated_cells(timed: Scene, domains: DomainPlan) -> SteppedCells:
    """Return the cells of the domain that a scene states."""
    return entries.table(CellDomain)[timed.discretisation.domain].cells(timed, domains)


CHEAPER = "end earlier, compare fewer sites or see fewer times"


def record_by_rings(scene: Scene, progress: Progress, announce: Announce) -> RunRecord:
    """Run the scene on spectral rings, which for the paper's waves need not be causal.

    A scene that does not ask for rings, and is refused by them, is run cell by cell.
    """
    begun = perf_counter()
    if not scene.has_moving_wave:
        runs = _spectral_runs(scene)
        announce(runs.expected.seconds)
        found = searched(runs.engine, scene, progress, announce, runs.record_of)
        record = _judged(runs.record_of(found.trial), found, scene, runs.times[-1], begun)
        record.scene = scene  # the ring has no sites that say it
        return record
    expected = rings_cost(scene)
    check_request(scene.name, expected, CHEAPER)
    announce(expected.seconds)
    cells = cells_cost(scene.changed(engine="stencil"))
    first = (cells.seconds - cells.once) / USUAL_RUNS
    try:
        return judged(*run_spectral(scene, first, progress, announce), scene, begun)
    except ValueError:
        if scene.target.engine:
            raise
    return record_by_cells(scene, progress, announce)


def choose_engine(scene: Scene) -> str:
    """The engine that a scene names, or the one that its observables need, or the cheaper one.

    Raises ValueError if the named one cannot compute an observable.
    """
    named = scene.target
    if named.engine and (named.steps_cells or not scene.has_moving_wave):
        return named.engine
    needing = [name for name in scene.observables if observable_named(name).all_sites]
    if named.engine and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got {named.engine!r} (it has no ring of "
            "sites)"
        )
    if named.engine:
        return named.engine
    if needing or named.scheme or not scene.has_moving_wave:
        return "stencil"
    is_cheap = cells_cost(scene).seconds <= rings_cost(scene).seconds
    return "stencil" if is_cheap else "spectral"


def _tell(record: RunRecord, scene: Scene) -> None:
    """Tell the equation, the frame, and the unit of errors."""
    wave = scene_wave(scene)
    record.attrs |= {"frame_speed": wave.speed, "power": wave.power}
    if scene.has_moving_wave:
        record.attrs |= trust_attributes(scene)
        return
    record.attrs["equation"], has_displacements = equation_of(scene)
    if "strains" in record.variables:
        told = {"units": "name", "long_name": "what is compared"}
        record.variables["quantity"] = ("quantity",), np.array(wave.quantities), told
    is_moved = has_displacements and not any(" " in q for q in wave.quantities)
    changes = {name: {"long_name": text} for name, text in LONG_NAMES.items()}
    changes |= {name: {"units": error_unit(wave.power)} for name in ("sup_error", *MEASURED)}
    for name in changes.keys() & record.variables.keys():
        dimensions, values, told = record.variables[name]
        record.variables[name] = dimensions, values, told | changes[name]
    if is_moved:
        _tell_displacements(record)


def _tell_displacements(record: RunRecord) -> None:
    """Name displacements in units and long names, where the fields themselves are compared."""
    record.attrs["field_kind"] = DISPLACEMENT
    for name, (dimensions, values, told) in record.variables.items():
        words = {
            key: text.replace("strain", DISPLACEMENT).replace("what is compared", DISPLACEMENT)
            for key, text in told.items()
        }
        record.variables[name] = dimensions, values, words


DISPLACEMENT = "displacement"

LONG_NAMES = {
    "strain": "what is compared, on the lattice",
    "analytic": "the same of the closed-form wave",
    "background": "the same of the wave's background",
}
"""On other lattices it need be no strain."""


def record_by_cells(scene: Scene, progress: Progress, announce: Announce) -> RunRecord:
    """Run the scene cell by cell to its tolerance."""
    begun, engine = perf_counter(), SiteEngine(*domain_plan(scene))
    announce(engine.expected.seconds)
    parts = engine.parts()
    found = parts and searched_on_part(*parts, scene, progress, announce)
    found = found or searched(engine, scene, progress, announce)
    record = _judged(found.trial.payload, found, scene, engine.times[-1], begun)
    _add_pulse(record, engine, found.trial.choices.step)
    if engine.domains.wave.lattice.dimension > 1:
        record.scene = scene  # the ring of a plane has no sites that say it
    return record


def _judged(
    record: RunRecord | None, found: Refined, scene: Scene, end: float, begun: float
) -> RunRecord:
    """Return the record with what the judge says; ValueError where no step follows the lattice."""
    if record is None or (math.isinf(found.error) and not record.attrs["blow_up"]):
        raise ValueError(
            f"times must end before {scene.lattice} blows up, got {end:g} (steps "
            f"down to {found.trial.choices.step:.2g} do not follow it; end earlier or take a "
            "smaller eps)"
        )
    return judged(record, found, scene, begun)


def _add_pulse(record: RunRecord, engine: SiteEngine, step: float) -> None:
    """Add what disorder left of the wave, where it was metered."""
    metered, wave = engine.metered.get(step), engine.domains.wave
    if metered is None or not metered.size:
        return
    assert wave.disorder is not None
    theory = []
    for t in engine.times:
        cells = engine.domains.compared.cells(t)
        theory.append(crest(cells, wave.strain(cells, t)[0] - wave.background(cells, t)[0]))
    columns, numbers = pulse_track(metered, engine.metered_before(step), theory)
    kept = [engine.times.index(t) for t in record.reached]
    for name, values in columns.items():
        units, long_name = PULSE_VARIABLES[name]
        told = {"units": units, "long_name": long_name}
        record.variables[name] = ("time",), values[kept], told
    record.attrs |= numbers
    if not math.isnan(speed := wave.disorder.effective_speed):
        record.attrs["effective_speed"] = speed
