"""Scenes of many cells: data in pieces, a search on a part, and what is too much is said before."""

import tracemalloc
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene, scene_of
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.methods import expected_cost
from longwave.scenes.engines.site_engine import SiteEngine
from longwave.scenes.starts.lattice_derivation import lattice_wave
from longwave.solutions.pieces import PIECE
from longwave.support.request_limits import OverBudgetError

DIMER: dict[str, Any] = {
    "name": "dimer",
    "lattice": "dimer",
    "wave": "kdv_soliton",
    "eps": 0.1,
    "order": "slaved",
    "constants": {"m1": 1, "m2": 2, "K2": 1, "K3": "1/2", "K4": 0, "H2": 2, "H3": 1, "H4": 0},
    "parameters": {"kappa": 1},
}
PEREGRINE: dict[str, Any] = {
    "name": "peregrine",
    "lattice": "mass_dimer",
    "wave": "nls_peregrine",
    "eps": 0.04,
    "order": "slaved",
    "carrier": "pi/2",
    "branch": "optical",
    "constants": {"m1": 1, "m2": 3, "K2": 1, "K3": 0, "K4": 1},
    "parameters": {"A": 1},
}
CHAIN: dict[str, Any] = {
    "name": "chain",
    "wave": "soliton_dn",
    "eps": 0.05,
    "constants": {"K2": 1, "K4": 1},
    "parameters": {"k": 0.7},
}
WAVES = {"dimer": DIMER, "peregrine": PEREGRINE, "chain": CHAIN}


def stated(wave: str, sites: int) -> Scene:
    fields = {"t0": 0, "snapshots": [2.0], "observables": ("strain",), "domain": "ring"}
    return Scene.of(
        **WAVES[wave],
        **fields,
        compared=sites // 2 - 400,
        sites=sites,
        step=0.25,
        scheme="reduced_phase_6",
    )


def to_tolerance(wave: str, cells: int, **changes: Any) -> Scene:
    fields = {"t0": 0, "snapshots": [5.0], "observables": ("strain",), "engine": "stencil"}
    fields |= {"compared": cells // 2, "tolerance": 1e-4}
    return Scene.of(**WAVES[wave], **(fields | changes))


def bytes_a_cell(wave: str) -> float:
    """Return the peak memory per additional cell, in bytes."""
    peaks = []
    for sites in (140_000, 280_000):
        tracemalloc.start()
        run(stated(wave, sites))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    return (peaks[1] - peaks[0]) / 140_000


DARK = {
    "lattice": "granular",
    "wave": "nls_dark",
    "constants": {"A": 1, "d": 1},
    "carrier": "pi/2",
    "parameters": {"kappa": "1/2", "v": 0},
}


@pytest.mark.parametrize("given", [DIMER, DIMER | DARK], ids=["dimer", "dark"])
def test_theory_of_many_cells_is_that_of_few(given: dict[str, Any]) -> None:
    """Catches: a cell beside the last one, or between pieces, that is another."""
    fields = {"t0": 0, "snapshots": [5.0], "compared": 10, "tolerance": 1e-3}
    wave = lattice_wave(Scene.of(**given, **fields))
    cells = np.arange(1.0 - 2.5 * PIECE, 1.0)
    for evaluate in (wave.strain, wave.background):
        whole = evaluate(cells, 5.0)
        for first in (0, PIECE - 50, 2 * PIECE - 50, cells.size - 100):
            few = slice(first, first + 100)
            np.testing.assert_allclose(whole[:, few], evaluate(cells[few], 5.0), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("wave", "most"),
    [
        ("dimer", 200),
        pytest.param("peregrine", 300, marks=pytest.mark.slow),
        pytest.param("chain", 120, marks=pytest.mark.slow),
    ],
)
def test_a_cell_takes_few_bytes(wave: str, most: float) -> None:
    """Catches: jets, panels or rows of all cells at once."""
    run(stated(wave, 20_000))
    assert bytes_a_cell(wave) < most


@pytest.mark.parametrize(
    "wave", ["dimer", pytest.param("peregrine", marks=pytest.mark.slow), "chain"]
)
def test_the_step_of_many_cells_is_found_on_a_part_of_them(
    wave: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a search of all cells, and an error that is told of other steps than the run's."""
    scene = to_tolerance(wave, 110_000)
    monkeypatch.setattr("longwave.scenes.engines.run_record.refine_scene", None)
    found = run(scene)
    plan = scene_of(found)
    finer = run(
        replace(plan, numerics=replace(plan.discretisation, step=0.5 * plan.discretisation.step))
    )
    difference = (
        float(np.max(np.abs(finer["strain"] - found["strain"]))) / scene.eps ** found.attrs["power"]
    )
    assert difference <= found.attrs["error_estimate"] <= 1e-4
    assert found.sizes["site"] == 110_001


def test_a_wave_that_is_not_on_the_part_is_searched_on_all_cells() -> None:
    """Catches: a step by what is flat, where the crest has gone far from the frame."""

    def parts(T: float) -> object:
        scene = to_tolerance("dimer", 150_000).changed(times=(T * 1e3, T * 1e3 + 5.0))
        return SiteEngine(*domain_plan(scene)).parts()

    assert parts(0.0) is not None
    assert parts(30_000.0) is None


@pytest.mark.parametrize("wave", WAVES)
@pytest.mark.parametrize("is_stated", [True, False])
def test_more_cells_than_memory_holds_are_refused_before_any_is_made(
    wave: str, is_stated: bool
) -> None:
    scene = stated(wave, 10**9) if is_stated else to_tolerance(wave, 10**9)
    tracemalloc.start()
    with pytest.raises(OverBudgetError, match=r"^[^\n]* must fit .* GB, got about .* GB \(.*\)$"):
        run(scene)
    assert tracemalloc.get_traced_memory()[1] < 1e8
    tracemalloc.stop()


def test_a_large_scene_of_the_next_order_is_told_its_cost() -> None:
    """Catches: a wave that is solved for, asked for its seam before it begins."""
    scene = load_scene("toda_soliton").changed(order="corrected", half_width=8000.0)
    assert 2 * scene.cells_within(1) > 100_000
    assert 1.0 < expected_cost(scene).seconds < 100.0
