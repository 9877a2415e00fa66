"""What pictures of a run show beside it: its own errors, spectra, and looks of any lattice."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.reports.pictures.animation import animate
from longwave.reports.pictures.drawing import moving_grid
from longwave.reports.pictures.plotting import plot
from longwave.reports.pictures.run_data import (
    envelope,
    error_curves,
    own_error,
    placed,
    spectra,
    with_looks,
)
from longwave.runs.own_error import own_error_at
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.scenes.observed.observables import amplitudes
from longwave.scenes.starts.lattice_derivation import lattice_wave

SCENE = Scene.of(
    name="soliton",
    wave="soliton_sech",
    parameters=(("A", 1),),
    eps=0.2,
    t0=0,
    snapshots=(0, 10, 20),
    K2=1,
    K4=1,
    step=0.5,
    domain="ring",
    sites=512,
    compared=60,
    observables=("strain", "error_curve", "time_step_error", "domain_error"),
    curve_points=6,
)


@pytest.fixture(scope="module")
def stated() -> xr.Dataset:
    return scene_run.run(SCENE)


@pytest.fixture(scope="module")
def to_tolerance() -> xr.Dataset:
    scene = SCENE.changed(
        step=None, domain=None, sites=None, scheme=None, tolerance=1e-3,
        observables=("strain", "error_curve"),
    )  # fmt: skip
    return scene_run.run(scene)


@pytest.fixture(scope="module")
def toda() -> xr.Dataset:
    scene = load_scene("toda_soliton")
    ends = scene.slow_times[0], scene.slow_times[-1]
    return scene_run.run(scene.changed(slow_times=tuple(np.linspace(*ends, 9))))


def test_a_stated_run_has_bars_where_its_errors_were_measured(stated: xr.Dataset) -> None:
    own = own_error(placed(stated))
    measured = 2.0 * (stated.time_step_error.values + stated.domain_error.values)
    assert own is not None
    assert np.allclose(own, 0.2 * measured, atol=0.0)
    ax = plot(stated, kind="errors").get_axes()[0]
    (container,) = ax.containers
    line, _, (columns,) = container
    size = np.abs(stated.analytic - stated.background).max("site").values
    lengths = [np.ptp(segment[:, 1]) for segment in columns.get_segments()]
    assert line.get_xdata().tolist() == [0.0, 10.0, 20.0]
    assert np.allclose(lengths, 2.0 * own / size, rtol=1e-3, atol=1e-15)


def test_a_run_to_a_tolerance_has_a_band(to_tolerance: xr.Dataset) -> None:
    ax = plot(to_tolerance, kind="errors").get_axes()[0]
    (band,) = ax.collections
    size = np.abs(to_tolerance.analytic - to_tolerance.background).max("site").values
    vertices = band.get_paths()[0].vertices
    at_start = vertices[vertices[:, 0] == 0.0][:, 1]
    estimate = 0.2 * to_tolerance.attrs["error_estimate"]
    assert np.isclose(np.ptp(at_start), 2.0 * estimate / size[0], atol=0.0)
    assert "own error" in ax.get_legend().get_texts()[1].get_text()


def test_the_own_error_over_time_is_the_same_without_snapshots(stated: xr.Dataset) -> None:
    """Catches: 1/eps times of it where a scene is run for the error curve alone."""
    bare = stated.drop_vars(["strain", "analytic", "background", "n"])
    for label, curve in error_curves(placed(stated)).items():
        alone = error_curves(placed(bare))[label]
        assert np.array_equal(alone.own, curve.own, equal_nan=True)
        assert np.isfinite(curve.own).sum() == 3


def test_a_run_that_measured_no_error_has_none(stated: xr.Dataset) -> None:
    bare = stated.drop_vars(["time_step_error", "domain_error"])
    assert own_error(placed(bare)) is None
    ax = plot(bare, kind="errors").get_axes()[0]
    assert not ax.containers
    assert not ax.collections
    assert np.isnan(spectra(placed(bare), [0])["own"].values).all()


def test_spectra_are_those_of_lattice_and_wave_with_what_is_below_trust(
    stated: xr.Dataset,
) -> None:
    figure = plot(stated, kind="spectra")
    ax = figure.get_axes()[2]
    lattice, wave, trusted, rounding = ax.lines
    assert np.array_equal(lattice.get_ydata(), amplitudes(stated.strain.values[2]))
    assert np.array_equal(wave.get_ydata(), amplitudes(stated.analytic.values[2]))
    assert lattice.get_xdata()[-1] <= np.pi
    own = 0.4 * (stated.time_step_error.values + stated.domain_error.values)[2]
    assert np.isclose(trusted.get_ydata()[0], 2.0 * own, atol=0.0)
    assert not ax.patches
    assert 0.0 < rounding.get_ydata()[0] < 2.0**-52 * float(abs(stated.strain).max())


def test_rounding_is_as_large_as_its_line_says(stated: xr.Dataset) -> None:
    """Noise of that size put on a strain has the amplitudes of the line, in the mean square."""
    level = float(spectra(placed(stated), [0])["rounding"].values[0])
    size = 2.0**-53 * float(abs(stated.strain[0]).max())
    noise = np.random.default_rng(1).uniform(-size, size, (400, 121))
    found = np.sqrt(np.mean([amplitudes(row)[5:-5] ** 2 for row in noise]))
    assert np.isclose(found, level, rtol=0.1, atol=0.0)


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf, 1e300])
def test_hostile_strains_are_drawn(stated: xr.Dataset, value: float) -> None:
    broken = stated.copy(deep=True)
    broken["strain"].values[1] = value
    figures = [plot(broken, kind=kind) for kind in ("spectra", "snapshots")]
    figures.append(plot(stated.isel(time=[0]), kind="spectra"))
    for axes in (axes for figure in figures for axes in figure.axes):
        assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()


def test_a_lattices_snapshots_make_map_crest_and_errors(toda: xr.Dataset) -> None:
    looked = with_looks(placed(toda))
    speed, unit = looked.attrs["speed"], looked.attrs["unit"]
    assert np.array_equal(looked["error_curve"].values, toda.error)
    top = np.abs(toda.strain).argmax("site").values
    rows = np.arange(9)
    rough = toda.n.values[rows, top] - speed * toda.time.values
    assert np.all(np.abs(looked["crest_position"].values - rough) < 0.6)
    assert np.all(
        np.abs(looked["crest_strain"].values) >= np.abs(toda.strain.values[rows, top]) - 1e-12
    )
    offset = toda.n.values[4] - speed * toda.time.values[4]
    wanted = np.interp(toda.site.values, offset, toda.strain.values[4])
    assert np.allclose(moving_grid(looked)[2][4], wanted)
    apart = unit * toda.sup_error.values[1:] / toda.error.values[1:]
    own = unit * toda.attrs["error_estimate"] / apart
    assert np.allclose(looked["own"].values[1:], own, atol=0.0)


def test_few_snapshots_are_no_curve_unless_it_is_asked_for(toda: xr.Dataset) -> None:
    few = toda.isel(time=[0, 4, 8])
    assert "space_time" not in with_looks(placed(few))
    assert plot(few, kind="errors").get_axes()[0].lines[0].get_xdata().size == 3


def test_of_an_envelope_the_map_holds_moduli(toda: xr.Dataset) -> None:
    looked = with_looks(placed(toda))
    assert float(looked["space_time"].values.min()) < 0.0 or float(toda.strain.min()) >= 0.0
    carried: Any = load_scene("fput_peregrine")
    times = tuple(np.linspace(carried.slow_times[0], carried.slow_times[-1], 8))
    run = scene_run.run(carried.changed(slow_times=times))
    found = with_looks(placed(run))
    assert float(np.nanmin(found["space_time"].values)) >= 0.0
    wave: Any = lattice_wave(carried)
    place = int(np.argmin(np.abs(run.time.values)))
    n, t = run.n.values[place], float(run.time[place])
    A = wave.wave.jets(0.02 * (n - wave.speed * t), 0.02**2 * t, 0)[0]
    assert not wave.carrier.is_displacement
    modulus = 2.0 * 0.02 * np.abs(A)
    drawn = envelope(run.analytic.values[place])
    assert np.abs(drawn - modulus)[100:-100].max() < 0.01 * modulus.max()
    assert np.isclose(float(np.nanmax(found["space_time"].values[place])), modulus.max(), rtol=0.02)
    label = plot(run, kind="space_time").get_axes()[1].get_ylabel()
    assert label == "envelope of $y_n$"


def foreign(run: xr.Dataset) -> Iterator[xr.Dataset]:
    """Data sets that a file may hold in the place of a run."""
    for name in run.variables:
        yield run.drop_vars(name)
    for name in run.data_vars:
        yield run.assign({name: run[name].expand_dims("other")})
        yield run.assign({name: run[name].isel({run[name].dims[0]: 0}, drop=True)})
        yield run.assign({name: run[name].astype(str)})
        yield run.assign({name: run[name].astype(float) * np.inf})
    for name in run.coords:
        yield run.assign_coords({name: run[name].astype(float) * np.inf})
        yield run.assign_coords({name: run[name].astype(str)})
    for name in run.attrs:
        yield run.drop_attrs(deep=False).assign_attrs(run.attrs | {name: "\n[/x]"})
        yield run.assign_attrs({name: np.inf})
    yield run.isel(time=slice(0))
    yield run.isel(site=slice(0))
    yield run.isel(site=slice(1))


@pytest.mark.slow
@pytest.mark.parametrize("of", ["stated", "toda"])
def test_what_is_no_run_is_drawn_or_told_in_one_line(
    of: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    for data in foreign(request.getfixturevalue(of)):
        for draw in (plot, lambda run: animate(run, tmp_path / "film.gif", dpi=30)):
            told = ""
            try:
                draw(data)
            except ValueError as error:
                told = str(error)
            assert len(told.splitlines()) <= 1
            assert len(told) < 400


def test_a_run_whose_estimate_is_lost_has_no_error_of_its_own(toda: xr.Dataset) -> None:
    lost = toda.copy()
    del lost.attrs["error_estimate"]
    assert np.isnan(with_looks(placed(lost), 2)["own"].values).all()


def test_errors_of_any_size_are_read(toda: xr.Dataset) -> None:
    tiny = toda.assign(sup_error=0.0 * toda["sup_error"] + 5e-324, error=1.0 + toda["error"])
    assert not np.isfinite(with_looks(placed(tiny), 2)["own"].values).any()


def test_backgrounds_of_any_size_make_a_map(toda: xr.Dataset) -> None:
    wild = toda.copy(deep=True)
    wild["background"] = xr.full_like(wild["strain"], 0.0)
    wild["background"].values[0, 0], wild["background"].values[1, 0] = np.inf, -np.inf
    with np.errstate(all="warn"):
        assert with_looks(placed(wild), 2).sizes["time"] == toda.sizes["time"]


def test_the_error_curve_of_any_lattice_has_the_runs_own_error() -> None:
    """Catches: the size of a wave on another lattice asked of the paper's chain."""
    scene = load_scene("toda_soliton").changed(eps=0.2, observables=("strain", "error_curve"))
    run = placed(scene_run.run(scene.changed(curve_points=5)))
    (curve,) = error_curves(run).values()
    at = [int(np.flatnonzero(curve.times == t)[0]) for t in run["time"].values]
    unit = scene.eps ** run.attrs["power"]
    sizes = run["sup_error"].values * unit / run["error"].values
    wanted = run.attrs["error_estimate"] * unit / sizes
    assert curve.own is not None
    np.testing.assert_allclose(curve.own[at], wanted, rtol=1e-9)
    assert own_error_at(run, scene, "error_curve", at[1]) == pytest.approx(float(wanted[1]))
