"""The report's chapter of other lattices: its jobs, what they found, its tables and figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import save, snapshot_figure, styled
from longwave.reports.pictures.lattice_figures import (
    even_times,
    map_figure,
    modulation_figure,
    rate_figure,
)
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.sections.lattice_runs import (
    is_map,
    rate_panels,
    rate_table,
    scene_maps,
    scene_table,
)
from longwave.reports.sections.other_lattices import (
    EnvelopeRow,
    ModelRow,
    envelope_table,
    model_jobs,
    model_table,
)
from longwave.reports.studies.lattice_models import modulation_plane
from longwave.reports.studies.measured_rates import MeasuredRate, rate_jobs
from longwave.reports.studies.measured_runs import SPLIT, MeasuredRuns
from longwave.reports.studies.scene_runs import SceneRun, scene_run_jobs
from longwave.support.processes import Job, Key

if TYPE_CHECKING:
    from longwave.scenes.modulation import ModulationGrid

ROGUES = ("alpha_beta_rogue", "dimer_rogue")
"""The scenes beside the paper's `SPLIT`, which is the same wave on its own lattice."""

PEREGRINES = ("fput_peregrine", "dimer_peregrine", "granular_peregrine")

ROGUE_CELLS, PEREGRINE_CELLS, NEAR = 120, 180, 16
"""Cells shown to either side of c t: of rogue waves, of envelopes, and of their carriers."""


@dataclass(frozen=True)
class LatticeChapter:
    """What the chapter shows and had to be computed; ``plane`` is a grid and its K3."""

    models: Sequence[ModelRow]
    envelopes: Sequence[EnvelopeRow]
    plane: tuple[ModulationGrid, NDArray[np.float64]]
    rates: Sequence[MeasuredRate]
    scenes: Mapping[str, SceneRun]

    @property
    def sound(self) -> bool:
        """Whether every scene ran to its tolerance and every rate is the expected one."""
        ran = all(found.kept for found in self.scenes.values())
        return ran and all(rate.reached for rate in self.rates)


def chapter_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the chapter under (kind, subject)."""
    plane: dict[Key, Job] = {("plane", "fput_strain"): Job(modulation_plane, (), 0.5)}
    return model_jobs() | plane | rate_jobs(full) | scene_run_jobs()


def lattice_chapter(found: Mapping[Key, Any]) -> LatticeChapter:
    """The results of the jobs, gathered."""

    def of(kind: str) -> list[Any]:
        return [value for (part, _), value in found.items() if part == kind]

    return LatticeChapter(
        models=list(chain.from_iterable(of("model"))),
        envelopes=of("envelope"),
        plane=of("plane")[0],
        rates=of("rate"),
        scenes={str(name): value for (part, name), value in found.items() if part == "scene"},
    )


CHAPTER_TABLES: Mapping[str, Callable[[LatticeChapter], str]] = {
    "model_table": lambda found: model_table(found.models),
    "envelope_table": lambda found: envelope_table(found.envelopes),
    "scene_table": lambda found: scene_table(found.scenes),
    "scene_maps": lambda found: scene_maps(found.scenes),
    "rate_table": lambda found: rate_table(found.rates),
}
"""The chapter's tables under their templates' names."""


def write_chapter_figures(
    found: LatticeChapter, paper: MeasuredRuns, folder: Path
) -> Iterator[Path]:
    """Draw the chapter's figures, yielding each path when it is written."""
    with styled():
        for name, figure in chapter_figures(found, paper):
            yield save(figure, folder / "figures" / f"{name}.pdf")


def chapter_figures(found: LatticeChapter, paper: MeasuredRuns) -> Iterator[tuple[str, Figure]]:
    """Each figure under its name; scenes that did not run are left out."""
    own = snapshots(paper.runs[SPLIT], ROGUE_CELLS)
    rogues = [_rogue_row(found.scenes[name]) for name in ROGUES]
    yield "lattice_rogues", snapshot_figure([own, *filter(None, rogues)], "theory")
    peregrines = [_peregrine_row(found.scenes[name]) for name in PEREGRINES]
    yield "lattice_peregrines", snapshot_figure(list(filter(None, peregrines)), "theory")
    for name, scene in found.scenes.items():
        if scene.run is not None and is_map(scene):
            yield f"scene_{name}", map_figure(scene.run)
    yield "lattice_rates", rate_figure(rate_panels(found.rates))
    yield "modulation", modulation_figure(*found.plane)


def _rogue_row(found: SceneRun) -> list[xr.Dataset]:
    if found.run is None:
        return []
    return snapshots(found.run, ROGUE_CELLS, even_times(found.run))


def _peregrine_row(found: SceneRun) -> list[xr.Dataset]:
    """The wave at its crest, and its carrier there and at the end."""
    if found.run is None:
        return []
    crest = int(np.argmin(np.abs(found.run["time"].values)))
    wide = snapshots(found.run, PEREGRINE_CELLS, (crest,))
    return [*wide, *snapshots(found.run, NEAR, (crest, -1))]
