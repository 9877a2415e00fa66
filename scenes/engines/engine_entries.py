"""Domains and engines of longwave; their modules are imported on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

from longwave.scenes.engines.entry_kinds import CellDomain, WaveEngine, WaveRuns

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.domain_plan import DomainPlan
    from longwave.scenes.engines.stepped_cells import SteppedCells


def _window_cells(scene: Scene, domains: DomainPlan) -> SteppedCells:
    from longwave.scenes.engines.stepped_cells import WindowCells

    return WindowCells(scene, domains)


def _ring_cells(scene: Scene, domains: DomainPlan) -> SteppedCells:
    from longwave.scenes.engines.stepped_cells import SteppedCells

    return SteppedCells(scene, domains)


def _by_cells() -> WaveRuns:
    from longwave.scenes.engines import lattice_run

    return WaveRuns(lattice_run.record_by_cells, lattice_run.cells_cost)


def _by_rings() -> WaveRuns:
    from longwave.scenes.engines import lattice_run

    return WaveRuns(lattice_run.record_by_rings, lattice_run.rings_cost)


window = CellDomain(cells=_window_cells, moves=True)
ring = CellDomain(cells=_ring_cells)
closed_ring = CellDomain(cells=_ring_cells, ends_meet=True)
stencil = WaveEngine(runs=_by_cells)
spectral = WaveEngine(runs=_by_rings, steps_cells=False)
