"""Catches: figures that are the step's or the domain's, effects nobody asked for, lost data."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from longwave.lattice.state import BlowUp, State
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene, scene_of
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import domain_plan, stated_cells
from longwave.scenes.engines.spectral_run import view_of
from longwave.scenes.engines.stated_run import refined
from longwave.scenes.starts.moving_wave import moving_wave

Y2 = replace(load_scene("rational_2_eps_0.05"), observables=("strain",), snapshots=(0.0,))


def test_Y2_error_at_its_crest() -> None:
    """The target figure; a site offset, a wrong background or a coarse step all miss it."""
    measured = run(replace(Y2, observables=("strain", "time_step_error")))
    assert float(measured.error[0]) == pytest.approx(0.1014, abs=0.0002)
    assert 1e-5 < float(measured.time_step_error[0]) < 1e-4
    site = int(measured.strain[0].argmax("site"))
    assert int(measured.site[site]) == 0
    assert int(measured.n[0, site]) == 0


@pytest.mark.slow
def test_rk4_step_pollutes_the_figure() -> None:
    measured = run(Y2.changed(scheme="rk4", step=0.25))
    assert float(measured.error[0]) == pytest.approx(0.119, abs=0.0005)


def test_Y3_stays_below_a_fifth_at_all_times_shown() -> None:
    scene = replace(load_scene("rational_3_eps_0.05"), observables=("error_curve",))
    measured = run(replace(scene, curve_points=61))
    assert 0.15 < float(measured.error_curve.max()) < 0.20


@pytest.mark.parametrize(
    ("name", "absolute"),
    [("breather_sn_k_0.5", 1.5e-5), ("breather_sn_k_0.6", 2.5e-5), ("breather_sn_k_0.7", 3.9e-5)],
)
def test_dark_breather_against_the_independent_measurement(name: str, absolute: float) -> None:
    scene = load_scene(name)
    measured = run(replace(scene, observables=("strain", "domain_error", "time_step_error")))
    deviation = np.max(np.abs(measured.strain[-1] - measured.analytic[-1])) / scene.eps
    assert float(deviation) == pytest.approx(absolute, rel=0.05)
    assert float(measured.domain_error.max()) < 1e-12
    assert float(measured.time_step_error.max()) < 1e-10


@pytest.mark.parametrize("name", ["soliton_dn_k_0.7", "rogue_cn_k_0.5"])
def test_the_true_far_field_doubles_the_denominator(name: str) -> None:
    measured = run(replace(load_scene(name), observables=("strain", "domain_error")))
    ratio = measured.error[1:] / measured.error_far_field[1:]
    assert np.all(np.abs(ratio - 2.0) < 0.05)
    assert float(measured.domain_error.max()) < 1e-12


def test_each_side_has_its_own_far_field() -> None:
    """The dark breather shifts the sn wave: the two sides exchanged are off by order eps."""
    scene = load_scene("breather_sn_k_0.7")
    moving = moving_wave(scene)
    sites = moving.compared_sites(moving.t0)
    state = State(moving.t0, *moving.state(sites, moving.t0), int(sites[0]))
    comparison = view_of(moving, state)
    ends = np.abs(comparison.sites - comparison.sites.mean()) > 300
    deviation = np.abs(comparison.analytic - comparison.far_field)
    assert np.max(deviation[ends]) < 1e-6 * scene.eps
    assert np.max(deviation) > 0.5 * scene.eps


@pytest.mark.parametrize(
    ("measure", "changed"),
    [("time_step_error", {"step": 0.25}), ("domain_error", {"sites": 4096})],
)
def test_refinements_are_finer(measure: str, changed: dict[str, float]) -> None:
    scene = load_scene("breather_sn_k_0.7")
    assert refined(scene, measure) == scene.changed(observables=(), **changed)  # type: ignore[arg-type]


def test_run_agrees_with_dop853(ring_scene: Callable[..., Scene]) -> None:
    """An independent integrator, on all sites in the lab frame."""
    scene = ring_scene(step=0.25, snapshots=(0.0,), observables=("strain",))
    sites = np.arange(-210, 191)
    state = np.concatenate(moving_wave(scene).state(sites, scene.t0)).ravel()

    def rate(_: float, values: np.ndarray) -> np.ndarray:
        y, s = np.split(values, 2)
        f = y + y**3
        return np.concatenate([s, np.roll(f, -1) - 2.0 * f + np.roll(f, 1)])

    solved = solve_ivp(rate, (-20.0, 0.0), state, "DOP853", rtol=1e-13, atol=1e-15)
    expected = solved.y[: sites.size, -1][(sites >= -50) & (sites <= 50)]
    numeric = run(scene).strain[0]
    assert np.max(np.abs(np.asarray(numeric) - expected)) < 1e-9 * scene.eps


@pytest.mark.parametrize(
    ("observables", "expected"),
    [
        ((), set()),
        (("strain",), {"strain", "analytic", "background", "n", "error", "error_far_field"}),
        (("error_curve",), {"error_curve", "error_curve_far_field"}),
        (("energy",), {"energy"}),
        (("domain_error",), {"domain_error"}),
    ],
)
def test_only_what_was_asked_for_is_there(
    ring_scene: Callable[..., Scene], observables: tuple[str, ...], expected: set[str]
) -> None:
    measured = run(ring_scene(observables=observables))
    assert set(measured.data_vars) == expected


def test_the_curve_passes_through_the_snapshots(ring_scene: Callable[..., Scene]) -> None:
    measured = run(ring_scene(snapshots=(-7.3, 0.0, 20.0)))
    assert measured.curve_time.values.tolist() == [-20.0, -10.0, -7.3, 0.0, 10.0, 20.0]
    shared = measured.error_curve.sel(curve_time=measured.time.values)
    assert shared.values.tolist() == measured.error.values.tolist()


def test_the_dataset_says_what_was_run(ring_scene: Callable[..., Scene]) -> None:
    seen: list[float] = []
    measured = run(ring_scene(), seen.append)
    assert isinstance(measured, xr.Dataset)
    assert measured.strain.dims == ("time", "site")
    assert scene_of(measured).wave == "rogue_cn"
    assert "numba" in measured.attrs["versions"]
    assert measured.attrs["force_evaluations"] == 17 * measured.attrs["steps"]
    assert measured.attrs["blow_up"] == ""
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_energy_of_a_commensurate_ring(ring_scene: Callable[..., Scene]) -> None:
    """A bare sn wave that closes up exactly: eps is chosen so that 4 K is 100 sites."""
    scene = ring_scene(wave="wave_sn", K4=-1.0, sites=500, observables=("energy",), look_points=5)
    wavelength = moving_wave(scene).wave.wavelength
    assert wavelength is not None
    measured = run(replace(scene, eps=float(wavelength) / 100.0, snapshots=(20.0,)))
    energy = measured.energy.values
    assert energy.size == 5
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-9


def test_blow_up_keeps_what_came_before(ring_scene: Callable[..., Scene]) -> None:
    """A steep sn wave, 7 sites long: its strains pass 1/sqrt(3), where the lattice goes soft."""
    scene = ring_scene(wave="wave_sn", parameters=(("k", 0.9),), K4=-1.0, sites=1680, t0=-20.0)
    wavelength = moving_wave(scene).wave.wavelength
    assert wavelength is not None
    scene = replace(scene, eps=float(wavelength) / 7.0, snapshots=(-20.0, -10.0, 200.0))
    measured = run(replace(scene, observables=("strain", "time_step_error")))
    text = measured.attrs["blow_up"]
    assert text.startswith("blow-up: a bond is stretched to where waves grow at t = ")
    assert 30.0 < float(text.split("t = ")[1].split(",")[0]) < 90.0
    assert measured.time.values.tolist() == [-20.0, -10.0]
    assert measured.strain.shape == (2, 101)
    assert np.all(np.isfinite(measured.strain))


def test_blow_up_is_found_to_the_step(ring_scene: Callable[..., Scene]) -> None:
    """A chunk of 64 steps ends in NaN here: without repeating it the criterion would be lost."""
    scene = ring_scene(wave="wave_sn", parameters=(("k", 0.9),), K4=-1.0, sites=1680, t0=-20.0)
    wavelength = moving_wave(scene).wave.wavelength
    assert wavelength is not None
    scene = replace(scene, eps=float(wavelength) / 6.0, snapshots=(-20.0, 200.0))
    measured = run(replace(scene, observables=("strain",)))
    assert measured.attrs["blow_up"].startswith(
        "blow-up: a bond is stretched to where waves grow at t = "
    )


def test_a_blow_up_at_the_start_keeps_nothing(ring_scene: Callable[..., Scene]) -> None:
    scene = ring_scene(wave="wave_sn", parameters=(("k", 0.9),), K4=-1.0, eps=0.9)
    measured = run(scene)
    assert "at t = -20," in measured.attrs["blow_up"]
    assert measured.sizes["time"] == 0


@pytest.mark.parametrize(("sites", "closes"), [(400, False), (407, True)])
def test_a_blow_up_at_the_seam_is_told_from_one_of_the_wave(sites: int, closes: bool) -> None:
    """A dark breather's ring that does not close breaks at once; one that does runs on."""
    scene = Scene.of(
        name="seam",
        wave="breather_sn",
        eps=0.7,
        t0=-10.0,
        snapshots=(-10.0, -9.0, -5.0, 0.0, 10.0),
        K2=1,
        K4=-1,
        compared=10,
        step=0.2,
        domain="ring",
        sites=sites,
        parameters=(("k", 0.5), ("alpha", "K/2")),
        curve_points=50,
    )
    measured = run(scene)
    assert ("0 sites from the ring's seam" in measured.attrs["blow_up"]) is not closes
    assert measured.sizes["time"] == (5 if closes else 2)


def test_a_blow_up_far_from_the_seam_does_not_blame_it(ring_scene: Callable[..., Scene]) -> None:
    stepper, _ = stated_cells(*domain_plan(scene := ring_scene())).stepper(None)
    state, domain = stepper.state, stepper.domain
    middle = BlowUp("broken", scene.t0, state.size // 2)
    assert domain.locate(middle, state).from_seam is None
    assert domain.locate(replace(middle, site=3), state).from_seam == 3


@pytest.mark.parametrize("engine", ["stencil", "spectral"])
def test_a_scene_of_its_start_alone_is_its_data(
    ring_scene: Callable[..., Scene], engine: str
) -> None:
    """Catches: a plan that asks for what changes until the second of the times."""
    scene = ring_scene(t0=3.0, snapshots=(3.0,), observables=("strain",)).with_tolerance(1e-6)
    found = run(scene.changed(engine=engine))
    assert found.strain.shape == (1, 101)
    assert float(np.max(np.abs(found.strain - found.analytic))) < 1e-6 * scene.eps
