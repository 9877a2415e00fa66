"""Sweeps over scenes that measure growth rates: numbers, errors and pictures."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.reports.pictures.growth_plotting import growth_panels
from longwave.reports.pictures.plotting import plot
from longwave.runs import load_run, save_run
from longwave.runs.repeated_run import compare_runs
from longwave.runs.run_file import scene_of_run
from longwave.runs.run_store import RunStore
from longwave.runs.sweep import run_sweep
from longwave.runs.sweep_dataset import cell_run, sweep_dataset, write_sweep
from longwave.runs.sweep_file import load_sweep, shipped_sweeps, sweep_of
from longwave.scenes.description.named_scenes import scene_of_toml
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.support.compiled import cores
from tests.runs.test_runs_sweep import HereWorkers

GROWTH: dict[str, Any] = {
    "lattice": "fput",
    "wave": "perturbed_plane",
    "eps": 0.2,
    "order": "slaved",
    "tolerance": 1e-2,
    "constants": {"K2": 1, "K3": 0.5, "K4": 1},
    "parameters": {"amplitude": 0.3},
    "envelope": {"k": 1},
}
K = [0.5, 2.0, "pi", 3.5]
LATTICES: dict[str, Any] = {
    "lattice": ["fput", "klein_gordon"],
    "constants": [{"K2": 1, "K3": 0.5, "K4": 1}, {"K2": 1, "g1": 2, "g2": 1, "g3": 4}],
}


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, Path]:
    """Run the sweep; return its written data set and its folder."""
    folder = tmp_path_factory.mktemp("growth")
    tables = {"scene": GROWTH, "list": LATTICES, "grid": {"envelope.k": K, "eps": [0.1, 0.2]}}
    sweep, store = sweep_of(tables, "growth"), RunStore(folder / "store")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cores, "_alone", False)
        run_sweep(sweep, store, HereWorkers())
    write_sweep(sweep, store, folder / "growth.nc")
    whole = sweep_dataset(sweep, store)
    assert whole.sideband_size.dims == ("k", "eps", "case", "time")
    again = cell_run(sweep, store, k=1, eps=0, case=0)
    assert scene_of_run(again) == sweep.scene(4).changed(name="scene")
    assert compare_runs(again, scene_run.run(scene_of_run(again))).is_same
    return load_run(folder / "growth.nc"), folder


def test_cells_distinguish_growth_stability_and_missing_runs(
    swept: tuple[xr.Dataset, Path],
) -> None:
    """k = 0.5 is stable on both lattices; 3.5 is no wavenumber, and its message says so."""
    data, _ = swept
    at = data.isel(eps=0)
    assert (at.status == [["done"] * 2] * 3 + [["refused"] * 2]).all()
    assert set(at.message.values[3]) == {"k must satisfy 0 <= k <= pi, got 7/2 (radians a cell)"}
    measured, own, theory = (
        at[name].values for name in ("growth_rate", "growth_rate_error", "growth_rate_theory")
    )
    assert np.isnan(measured[3]).all()
    assert (theory[0] == 0).all()
    assert (np.abs(measured[0]) < own[0]).all()
    assert (measured[1:3] > 10 * own[1:3]).all()
    np.testing.assert_allclose(measured[1:3], theory[1:3], rtol=0.1)
    assert (at.own_error.values[:3] < 0.1).all()
    assert data.error.attrs["long_name"] == "growth rate off theory, over the largest"


def test_the_difference_falls_with_eps_squared(swept: tuple[xr.Dataset, Path]) -> None:
    data, _ = swept
    falls = (data.error.isel(eps=1) / data.error.isel(eps=0)).values[1:3]
    assert np.all((falls > 3.2) & (falls < 4.8))


def test_the_picture_has_the_cells_and_the_map_of_theory(swept: tuple[xr.Dataset, Path]) -> None:
    data, folder = swept
    panels = growth_panels(data, 8)
    assert [panel.title for panel in panels] == ["fput", "klein_gordon"]
    for case, panel in enumerate(panels):
        assert [curve.attrs["label"] for curve in panel.curves] == ["eps = 0.1", "eps = 0.2"]
        assert panel.theory is not None
        curve, (line,) = panel.curves[0], panel.theory.lines.values
        drawn = np.interp(curve.carrier_k[1:3], panel.theory.k, line)
        np.testing.assert_allclose(drawn, data.growth_rate_theory.values[1:3, 0, case], rtol=2e-3)
        assert curve.failed.values.tolist() == [False, False, False, True]
        stable = panel.theory["product"].values <= 0
        assert np.array_equal(stable, line == 0)
        assert stable[np.searchsorted(panel.theory.k, 0.5)]
    figure = plot(folder / "growth.nc", folder / "growth.png")
    left, right = figure.get_axes()[:2]
    assert (left.get_ylabel(), right.get_ylabel()) == (
        "growth rate in $T$",
        r"$\kappa$ of the perturbation",
    )
    hollow = [c[0] for c in left.containers if c[0].get_markerfacecolor() == "white"]
    assert hollow[0].get_xdata()[0] == pytest.approx(0.5, abs=1e-3)
    one = plot(data, at={"case": 0}) if "case" in data.coords else plot(data, at={"eps": 0.1})
    assert one.get_axes()


def test_growth_is_drawn_for_growth_sweeps_only(
    swept: tuple[xr.Dataset, Path],
) -> None:
    data, _ = swept
    assert growth_panels(data.isel(case=0, eps=0), 8)[0].curves[0].attrs["label"] == ""
    with pytest.raises(ValueError, match="growth_map must be of growth rates over envelope"):
        plot(data.isel(k=1), kind="growth_map")
    for lost in (data.drop_vars("growth_rate_error"), data.assign(carrier_k=data.k)):
        with pytest.raises(ValueError, match="growth_map must be of growth rates over envelope"):
            plot(lost, kind="growth_map")
    with pytest.raises(ValueError, match="eps must have at most 1 values beside k, got 2"):
        growth_panels(data, 1)


@pytest.mark.parametrize(
    "output", ["{}", "[]", "nope", json.dumps({"scene": GROWTH | {"wave": "kdv_soliton"}})]
)
def test_a_file_without_its_scene_has_no_map(output: str, swept: tuple[xr.Dataset, Path]) -> None:
    data = swept[0].assign_attrs(sweep=output)
    assert [panel.theory for panel in growth_panels(data, 8)] == [None, None]
    assert plot(data, kind="growth_map").get_axes()


def test_a_scene_is_read_back_and_its_run_is_too(tmp_path: Path) -> None:
    scene = sweep_of({"scene": GROWTH, "grid": {"parameters.share": [0.5, "1/3"]}}).scene(1)
    assert scene_of_toml(scene.toml()) == scene
    assert Scene.from_json(scene.json()) == scene
    run = scene_run.run(scene)
    save_run(run, tmp_path / "run.nc")
    found = load_run(tmp_path / "run.nc")
    assert compare_runs(run, found).is_same
    assert scene_of_run(found) == scene
    (ax,) = plot(found).get_axes()
    assert np.array_equal(ax.lines[0].get_ydata(), run["sideband_size"].values)


def test_a_table_and_a_key_of_it_do_not_both_vary() -> None:
    with pytest.raises(ValueError, match="constants must be given in one table, got it in two"):
        sweep_of({"scene": GROWTH, "grid": {"constants.K4": [1, 2]}, "list": LATTICES})


def test_the_shipped_sweep_has_stable_and_unstable_carriers() -> None:
    assert "growth_over_k" in shipped_sweeps()
    sweep = load_sweep("growth_over_k")
    assert {sweep.scene(cell).lattice for cell in range(3)} == {
        "fput",
        "klein_gordon",
        "mass_dimer",
    }
