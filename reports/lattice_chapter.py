"""The figures of the report's chapter of other lattices."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.lattice_figures import (
    even_times,
    modulation_figure,
    rate_figure,
    strain_maps,
)
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.sections.lattice_runs import is_map, rate_panels
from longwave.reports.studies.measured_runs import SPLIT
from longwave.reports.studies.scene_runs import SceneRun

if TYPE_CHECKING:
    from longwave.reports.build import Findings

ROGUES = ("alpha_beta_rogue", "dimer_rogue")
"""The scenes beside the paper's `SPLIT`, which is the same wave on its own lattice."""

PEREGRINES = ("fput_peregrine", "dimer_peregrine", "granular_peregrine")

ROGUE_CELLS, PEREGRINE_CELLS, NEAR = 120, 180, 16
"""Cells shown to either side of c t: of rogue waves, of envelopes, and of their carriers."""


def chapter_figures(found: Findings) -> Iterator[tuple[str, Figure]]:
    """Each figure under its name; scenes that did not run are left out."""
    scenes, (plane,) = found.of("scene"), found.all("plane")
    own = snapshots(found.runs.runs[SPLIT], ROGUE_CELLS)
    rogues = [_rogue_row(scenes[name]) for name in ROGUES]
    yield "lattice_rogues", snapshot_panels([own, *filter(None, rogues)], "theory").figure()
    peregrines = [_peregrine_row(scenes[name]) for name in PEREGRINES]
    yield "lattice_peregrines", snapshot_panels(list(filter(None, peregrines)), "theory").figure()
    for name, scene in scenes.items():
        if scene.run is not None and is_map(scene):
            yield f"scene_{name}", strain_maps(scene.run).figure()
    yield "lattice_rates", rate_figure(rate_panels(found.all("rate")))
    yield "modulation", modulation_figure(*plane)


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
