"""Running a scene on any lattice: derive, start from the wave, integrate, compare."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.refine import Announce, refine
from longwave.lattice.trial import Progress
from longwave.scenes.chain.observables import RATIO, SITES, STRAIN, TIME
from longwave.scenes.lattice_derivation import LatticeDerivation, derivation, lattice_wave
from longwave.scenes.lattice_wave import LatticeWave
from longwave.scenes.pulse_meter import PULSE_VARIABLES, PulseTrack, crest, pulse_track
from longwave.scenes.ring_cost import BEGIN_SECONDS
from longwave.scenes.ring_runs import (
    SCHEME,
    ComparedCells,
    RingRecord,
    RingRuns,
    expected_rings,
)
from longwave.scenes.scene import Scene
from longwave.support.checkpoint import spared_seconds
from longwave.support.provenance import provenance
from longwave.support.request_limits import ExpectedCost

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

ACROSS = 2
"""``Z = eps**2 m``."""


@dataclass(frozen=True)
class LatticeRun:
    """A scene that was run: lattice and theory on the compared cells at all ``times``.

    ``cells``, (time, sites) or (time, axes, *sites); ``measured``, ``theory``, ``background``:
    (time, quantities, *sites). All are what is compared, as it stands; errors are in units of
    eps to the ``power``. ``error_estimate`` is how far the lattice is estimated to be from the
    infinite one. ``pulse`` is what disorder left of the wave.
    """

    scene: Scene
    derived: LatticeDerivation
    times: tuple[float, ...]
    speed: float
    power: int
    cells: Array
    measured: Array
    theory: Array
    background: Array
    error_estimate: float
    cost: dict[str, Any]
    pulse: PulseTrack | None = None

    @property
    def scale(self) -> float:
        """The unit of errors."""
        return float(self.scene.eps**self.power)

    @cached_property
    def errors(self) -> Array:
        """sup |lattice - theory| at each time, in units of the scale."""
        return self._largest(self.measured - self.theory) / self.scale

    @cached_property
    def relative_errors(self) -> Array:
        """The same in units of the wave's largest deviation from its background."""
        sizes = np.where(self.sizes > 0.0, self.sizes, math.nan)
        return np.asarray(self.errors * self.scale / sizes)

    @cached_property
    def sizes(self) -> Array:
        """The wave's largest deviation from its background at each time."""
        return self._largest(self.theory - self.background)

    @property
    def unit(self) -> str:
        """The scale in words: the power of eps with which what is compared is small."""
        return "eps" if self.power == 1 else f"eps^{self.power}"

    @property
    def slow_times(self) -> Array:
        """T at each time."""
        return np.array(self.times) * self.scene.eps**self.derived.slow

    def _largest(self, values: Array) -> Array:
        return np.asarray(np.max(np.abs(values), axis=tuple(range(1, values.ndim))))

    @cached_property
    def dataset(self) -> xr.Dataset:
        """The run as a data set: what a `Scene`'s run has, with ``quantity`` where there are more.

        The first of several quantities is called ``strain``; all are in ``strains``.
        """
        import xarray as xr

        places = ("time", "site", "row")[: self.theory.ndim - 1]
        middles = np.rint(self.speed * np.array(self.times)).astype(np.int64)
        along = self.cells if self.cells.ndim == 2 else self.cells[:, 0, :, 0]
        offset = (along[0] - middles[0]).astype(np.int64)
        values: dict[str, tuple[Any, Array]] = {
            "strain": (places, self.measured[:, 0]),
            "analytic": (places, self.theory[:, 0]),
            "background": (places, self.background[:, 0]),
            "n": (("time", "site"), along.astype(np.int64)),
            "error": (("time",), self.relative_errors),
            "sup_error": (("time",), self.errors),
            "slow_time": (("time",), self.slow_times),
            "site": (("site",), offset),
        }
        if self.measured.shape[1] > 1:
            values["strains"] = (("time", "quantity", *places[1:]), self.measured)
            values["analytics"] = (("time", "quantity", *places[1:]), self.theory)
        if len(places) == 3:
            values["row"] = (("row",), self.cells[0, 1, 0].astype(np.int64))
        pulse = {} if self.pulse is None else self.pulse.columns
        values |= {name: (("time",), column) for name, column in pulse.items()}
        told = {name: (*value, self._attributes(name)) for name, value in values.items()}
        axes = {name: told.pop(name) for name in ("site", "row") if name in told}
        attributes = {
            "title": self.scene.title or self.scene.name,
            "scene": self.scene.toml(),
            "equation": self.derived.text(),
            "frame_speed": self.speed,
            "error_estimate": self.error_estimate,
            "tolerance": self.scene.target.tolerance,
            **self.cost,
            **({} if self.pulse is None else self.pulse.numbers),
            **provenance(),
        }
        made = xr.Dataset(told, {"time": ("time", list(self.times), TIME), **axes}, attributes)
        return made if self.scene.keeps_start else made.isel(time=slice(1, None))

    def _attributes(self, name: str) -> dict[str, str]:
        """Unit and long name of a variable."""
        units, long_name = (VARIABLES | PULSE_VARIABLES)[name]
        return {"units": self.unit if name == "sup_error" else units, "long_name": long_name}


VARIABLES = {
    "strain": (STRAIN, "what is compared, on the lattice"),
    "analytic": (STRAIN, "the same of the closed-form wave"),
    "background": (STRAIN, "the same of the wave's background"),
    "strains": (STRAIN, "all quantities that are compared, on the lattice"),
    "analytics": (STRAIN, "the same of the closed-form wave"),
    "n": (SITES, "cell on the lattice"),
    "error": (RATIO, "sup error over the wave's largest deviation from its background"),
    "sup_error": ("", "sup error"),
    "slow_time": ("slow time", "T, the wave's own time"),
    "site": (SITES, "offset from the cell nearest to c t"),
    "row": (SITES, "cell along the second axis"),
}
"""Unit and long name of each variable; that of ``sup_error`` is a power of eps."""


def compared_cells(scene: Scene, wave: LatticeWave) -> ComparedCells:
    """The cells of a scene's region; a half-width in X is one in Z, too."""
    powers = (1, *(ACROSS,) * (wave.lattice.dimension - 1))
    return ComparedCells(wave.speed, tuple(map(scene.cells_within, powers)))


PROCESS_SECONDS = BEGIN_SECONDS
"""The part of the expected seconds that a process takes once."""


def run_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """`run_lattice_scene` as a data set."""
    return run_lattice_scene(scene, progress, announce).dataset


def scene_cost(scene: Scene) -> ExpectedCost:
    """What the scene is expected to cost, by its lattice's waves about the rest.

    Raises ValueError as `run_lattice_scene` does for what is wrong before anything is run.
    """
    wave = lattice_wave(scene)
    times = scene.lattice_times(wave.slow)
    return expected_rings(wave, compared_cells(scene, wave), times)


def run_lattice_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> LatticeRun:
    """Derive the scene's equation, start its lattice from the wave, and compare at all times.

    ``progress`` is called with the share of the work that is done, ``announce`` with the seconds
    that are expected to pass. Raises ValueError in one line for everything that lattice, wave and
    ansatz do not admit, for what would take too long, and for a lattice that blows up.
    """
    begun = perf_counter()
    derived = derivation(scene)
    wave = lattice_wave(scene)
    times = scene.lattice_times(derived.slow)
    wave.start(times[0])
    compared = compared_cells(scene, wave)
    engine = RingRuns(wave, compared, times)
    announce = announce or (lambda _: None)
    announce(engine.expected.seconds)
    found = refine(engine, scene.target.tolerance, progress or (lambda _: None), announce)
    if math.isinf(found.error):
        raise ValueError(
            f"times must end before {scene.lattice} blows up, got {times[-1]:g} (no step follows "
            "it; end earlier or take a smaller eps)"
        )
    record: RingRecord = found.trial.payload
    cells = [compared.cells(t) for t in times]
    made = LatticeRun(
        scene,
        derived,
        times,
        wave.speed,
        wave.power,
        np.array(cells),
        np.array(record.measured) * wave.scale,
        np.array([wave.strain(place, t) for place, t in zip(cells, times, strict=True)]),
        np.array([wave.background(p, t) for p, t in zip(cells, times, strict=True)], dtype=float),
        found.error,
        _cost(record, found.trial.seconds, perf_counter() - begun + spared_seconds(), wave),
    )
    return made if not record.metered.size else replace(made, pulse=_track(made, record, engine))


def _track(run: LatticeRun, record: RingRecord, engine: RingRuns) -> PulseTrack:
    wave = zip(run.cells, run.theory[:, 0] - run.background[:, 0], strict=True)
    before = engine.metered_before(record)
    track = pulse_track(record.metered, before, [crest(*at) for at in wave])
    speed = engine.wave.effective_speed
    told = {} if math.isnan(speed) else {"effective_speed": speed}
    return replace(track, numbers={**track.numbers, **told})


def _cost(record: RingRecord, seconds: float, whole: float, wave: LatticeWave) -> dict[str, Any]:
    found: dict[str, Any] = {
        "engine": "stencil",
        "scheme": SCHEME.name,
        "steps": record.steps,
        "sites": record.sites,
        "force_evaluations": record.steps * SCHEME.stages,
        "seconds": seconds,
        "planning_seconds": whole - seconds,
    }
    begin, end = record.energies
    told = wave.lattice.conserves_energy or record.metered.size
    if told and math.isfinite(begin):
        found["energy_drift"] = abs(end - begin) / abs(begin) if begin else 0.0
    return found
