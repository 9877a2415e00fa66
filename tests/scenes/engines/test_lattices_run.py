"""Scenes on lattices, run: against an independent integrator, and what the derivation refuses."""

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from longwave.reports.pictures.drawing import field_label
from longwave.reports.pictures.plotting import plot
from longwave.scenes import run
from longwave.scenes.convergence import at_eps, scene_convergence
from longwave.scenes.description.named_scenes import load_scene, scene_of_toml, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import record_scene
from longwave.scenes.starts.lattice_derivation import derivation, lattice_wave, wave_of
from longwave.support.request_limits import request_limits
from tests.families import family

TODA: dict[str, Any] = {
    "name": "toda",
    "lattice": "toda",
    "constants": {"a": 1, "b": 1},
    "wave": "kdv_soliton",
    "parameters": {"kappa": 1},
    "eps": 0.4,
    "slow_times": [0, 0.5, 1],
    "half_width": 6,
    "order": "slaved",
    "tolerance": 1e-3,
}
FPUT = {"K2": 1, "K3": 0, "K4": 1}
PEREGRINE = TODA | {
    "lattice": "fput_strain",
    "constants": FPUT,
    "wave": "nls_peregrine",
    "parameters": {"A": 1},
    "carrier": "pi/2",
    "eps": 0.1,
    "slow_times": [-0.5, 0],
}


def reference(scene: Scene) -> list[np.ndarray]:
    """Compared quantities at all times, by DOP853 on a ring three times the causal length."""
    wave = lattice_wave(scene)
    times = np.array(scene.lattice_times(derivation(scene).slow))
    wave.start(float(times[0]))
    assert scene.half_width is not None
    reach = math.ceil(scene.half_width / scene.eps)
    room = reach + int(3.0 * (times[-1] - times[0])) + 100
    first = round(wave.speed * times[0])
    ring = wave.ring(np.arange(first - room, first + room + 1), float(times[0]))
    shape = (2, *ring.f.shape)

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        f, v = state.reshape(shape)
        return np.array([v, ring.lattice.acceleration(f)]).ravel()

    start = np.array([ring.f, ring.v]).ravel()
    found = solve_ivp(
        rate, (times[0], times[-1]), start, "DOP853", t_eval=times, rtol=1e-12, atol=1e-13
    )
    strains = []
    for t, state in zip(times, found.y.T, strict=True):
        middle = round(wave.speed * t) - first + room
        strain = wave.quantity_values(state.reshape(shape)[0], ring.mean_strain)
        strains.append(strain[:, middle - reach : middle + reach + 1])
    return strains


@pytest.fixture(scope="module")
def toda() -> xr.Dataset:
    return run(Scene.of(**TODA))


@pytest.mark.parametrize(
    "given",
    [
        TODA,
        PEREGRINE,
        TODA | {"lattice": "mass_dimer", "constants": FPUT | {"m1": 1, "m2": 3, "K3": "1/4"}},
    ],
    ids=["toda", "envelope", "dimer"],
)
def test_a_run_is_within_its_estimate_of_another_integrator(given: dict[str, Any]) -> None:
    scene = Scene.of(**given)
    found = run(scene)
    measured = found["strains"].values if "strains" in found else found["strain"].values[:, None]
    difference = (
        float(np.max(np.abs(np.array(reference(scene)) - measured))) / scene.eps**found.power
    )
    assert difference <= found.error_estimate <= scene.tolerance


def test_errors_begin_at_rounding_and_grow_to_the_size_of_the_next_order(toda: xr.Dataset) -> None:
    errors = toda["sup_error"].values
    assert errors[0] < 1e-12
    assert errors[2] == pytest.approx(0.003456, rel=0.02)
    assert toda["error"].values[2] == pytest.approx(errors[2] / 0.956, rel=0.01)
    assert toda["slow_time"].values.tolist() == pytest.approx([0.0, 0.5, 1.0])
    assert toda.energy_drift < 1e-8


def test_a_run_is_a_data_set_with_the_names_of_scenes(toda: xr.Dataset) -> None:
    assert toda["strain"].dims == ("time", "site")
    assert scene_of_toml(toda.attrs["scene"]) == Scene.of(**TODA)
    sup = np.abs(toda["strain"] - toda["analytic"]).max("site") / 0.4**toda.power
    assert sup.values == pytest.approx(toda["sup_error"].values)
    assert toda["site"].values[[0, -1]].tolist() == [-15, 15]
    assert toda["n"].values[2, 0] == round(15.625) - 15


def test_small_constants_and_a_mean_are_formulas() -> None:
    gardner = Scene.of(
        **TODA | {"lattice": "fput", "wave": "gardner_soliton", "constants": FPUT | {"K3": "eps/2"}}
    )
    assert derivation(gardner).equation == "focusing Gardner"
    wave = lattice_wave(gardner)
    assert wave.lattice.bonds[0].force.coefficients == pytest.approx((1.0, 0.2, 1.0))
    rogue = Scene.of(
        **TODA
        | {
            "lattice": "fput_strain",
            "wave": "rational_2",
            "parameters": {},
            "constants": FPUT | {"K3": "1/2"},
            "background": "-K3/(3*K4)",
        }
    )
    assert derivation(rogue).text().startswith("focusing mKdV: ")
    data = lattice_wave(rogue)
    assert data.uniform() == pytest.approx([-1 / 6])
    far = data.background(np.array([0.0]), 0.0)
    assert float(far[0, 0]) == pytest.approx(
        -1 / 6 + rogue.eps * wave_of(rogue).constant_background
    )


@pytest.mark.parametrize(
    ("wave", "parameters", "K4"),
    family(
        [("rational_2", {}, 1), ("rogue_cn", {"k": 0.5}, 1), ("soliton_sech", {"A": 1}, 1)],
        quick=("rogue_cn",),
    ),
)
def test_errors_of_a_wave_mean_the_same_on_the_chain_and_on_any_lattice(
    wave: str, parameters: dict[str, float], K4: float
) -> None:
    """Over the wave's largest deviation from its own background: it was 0.538 here, there 0.672."""
    common: dict[str, Any] = {"name": "one", "wave": wave, "parameters": parameters, "eps": 0.1}
    common |= {"compared": 60, "tolerance": 1e-6}
    chain = Scene.of(**common, t0=-300.0, snapshots=[0.0], K2=4, K4=K4, observables=["strain"])
    constants = {"K2": 4, "K3": 0, "K4": K4}
    any_lattice = Scene.of(
        **common, lattice="fput_strain", constants=constants, times=[-300.0, 0.0]
    )
    one, other = run(chain), record_scene(any_lattice).dataset
    assert float(other["error"][-1]) == pytest.approx(float(one["error"][-1]), rel=1e-4)
    np.testing.assert_allclose(other["background"][-1], one["background"][-1], atol=1e-12)


def test_an_envelope_deviates_from_its_plane_wave() -> None:
    """Far from its crest the Peregrine wave is the plane wave; that itself deviates from 0."""
    given = PEREGRINE | {"eps": 0.05}
    cells, crest = np.arange(4000.0, 4200.0), np.arange(-100.0, 100.0)
    peregrine = Scene.of(**given)
    plane = Scene.of(**given | {"wave": "nls_plane", "parameters": {"A": 1, "q": 0}})
    data = lattice_wave(peregrine)
    away, near = (data.strain(x, 0.0) - data.background(x, 0.0) for x in (cells, crest))
    assert np.abs(away).max() < 1e-3 * np.abs(near).max()
    np.testing.assert_allclose(
        data.background(cells, 7.0), lattice_wave(plane).strain(cells, 7.0), atol=1e-10
    )
    assert not np.any(lattice_wave(plane).background(cells, 7.0))


UNSTABLE = {
    "lattice": "chain",
    "constants": {"K": 1},
    "declared": '{"fields": ["u"], "spring": [{"between": ["u[n]", "u[n+1]"], "force": '
    '"-x + K*x**2"}, {"between": ["u[n]", "u[n+2]"], "force": "x"}]}',
}
DIMER = {"m1": 1, "m2": 2, "K2": 1, "K3": 1, "K4": 0}
DARK = {"wave": "nls_dark", "parameters": {"kappa": 1}, "carrier": 1}
GRANULAR = {"lattice": "granular", "constants": {"A": 1, "d": "1/100"}, "carrier": "pi"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lattice": "todda"}, "lattice must be one of the catalogue or a file, got 'todda'"),
        ({"wave": "kdv_solitn"}, "wave: name must be a closed form of the catalogue"),
        ({"wave": "rational_2"}, "wave must solve the KdV equation, which is derived from toda"),
        (
            {"wave": "nls_bright"},
            "(one of kdv_soliton, kdv_two_soliton, kdv_cnoidal; an envelope needs",
        ),
        (DARK | {"wave": "nls_bright"}, "wave must solve the defocusing NLS equation"),
        ({"lattice": "fput", "constants": FPUT | {"K4": 0}}, "got a linear lattice, fput"),
        ({"constants": {"a": 1}}, "constant b of toda must be given, got none"),
        ({"constants": {"a": 1, "b": 1, "c": 1}}, "constants must be among a, b, got 'c'"),
        ({"constants": {"a": -1, "b": 1}}, "a must satisfy a > 0, got -1"),
        ({"constants": {"a": "9**9**9**9", "b": 1}}, "a: exponents must be at most 1000"),
        ({"constants": {"a": "sqrt(-1)", "b": 1}}, "a must be a finite real number"),
        ({"constants": {"a": "__import__('os')", "b": 1}}, "a: expected a formula"),
        ({"parameters": {"kapa": 1}}, "parameters must be those of kdv_soliton, got kapa"),
        ({"parameters": {"kappa": -1}}, "kappa must satisfy 0 < kappa, got -1"),
        ({"amplitude": 3}, "amplitude and time must balance toda"),
        ({"background": "1/2"}, "background must be 0 on a lattice of displacements"),
        (DARK | {"carrier": 4}, "k must satisfy 0 <= k <= pi, got 4"),
        (DARK | {"branch": "optical", "carrier": 1, "parameters": {"c": 1}}, "got c (it takes"),
        (DARK | {"branch": 1}, "branch must be acoustic, optical or a number below 1, got 1"),
        (
            DARK | {"lattice": "mass_dimer", "constants": DIMER | {"m2": 3}, "carrier": "pi"},
            "k must not be a resonance",
        ),
        (DARK | GRANULAR | {"eps": 1.0, "slow_times": [0, 9]}, "where its force is defined"),
        (UNSTABLE, "constants must make waves of chain stable"),
        ({"eps": 1e-9}, "must fit 2 GB"),
        ({"slow_times": [0, 1e9]}, "must fit 2 GB"),
        ({"slow_times": [0, 1e40]}, "t must leave c t within 2^53 sites"),
        ({"eps": 0.0008}, "must take at most 60 min, got about"),
        ({"half_width": 1e12}, "must fit 2 GB"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_line(changes: dict[str, Any], message: str) -> None:
    scene = Scene.of(**(TODA | changes))
    with request_limits("2G", "1h"), pytest.raises(ValueError, match=r"\w") as raised:
        run(scene)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


KLEIN_GORDON = {"lattice": "klein_gordon", "constants": {"K2": 1, "g1": 1, "g2": 0, "g3": -1}}


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        KLEIN_GORDON | {"carrier": 0},
        {"lattice": "mass_dimer", "constants": DIMER | {"m2": 4, "K3": 0, "K4": 1}}
        | {"carrier": "pi"},
    ],
    ids=["in step", "first field at rest"],
)
def test_carriers_at_the_ends_of_the_zone_run(changes: dict[str, Any]) -> None:
    """Catches: coefficients of another wave, with which the error is of the wave's own size."""
    given = {"wave": "nls_bright", "parameters": {}, "eps": 0.1, "slow_times": [0, 1]}
    found = run(Scene.of(**(TODA | given | changes)))
    assert float(found.error.max()) < 0.02


@pytest.mark.slow
def test_displacements_are_told_and_drawn_as_such() -> None:
    """Ties to the site: the fields are compared, 2 eps h high. Strains stay strains.

    Catches: displacements under the name, unit and axis of strains.
    """
    tied = {"lattice": "klein_gordon", "constants": {"K2": 1, "g1": 1, "g2": 0, "g3": 1}}
    given = {"wave": "nls_bright", "parameters": {}, "eps": 0.1, "slow_times": [0, 0.01]}
    scene = Scene.of(**(TODA | given | tied | {"carrier": "pi/2"}))
    found, form = run(scene), derivation(scene).normal_form
    assert form is not None
    assert float(np.max(np.abs(found.strain))) == pytest.approx(0.2 * float(form.h), rel=1e-3)
    for name in ("strain", "analytic", "background"):
        assert found[name].attrs["units"] == "displacement (lattice units)"
    assert found.strain.attrs["long_name"] == "displacement, on the lattice"
    strains = run(Scene.of(**(TODA | {"slow_times": [0, 0.01]})))
    assert strains.strain.attrs["units"] == "strain (lattice units)"
    assert [field_label(one) for one in (found, found.strain, strains)] == [
        *("displacement", "displacement", "$y_n$"),
    ]
    axes = [ax.get_ylabel() for ax in plot(found, kind="snapshots").get_axes()]
    assert axes[0] == "displacement"


def test_what_came_before_a_blow_up_is_kept() -> None:
    found = run(Scene.of(**TODA | {"parameters": {"kappa": 1e40}}))
    assert found.blow_up.startswith("blow-up: the fields are not finite at t = ")
    assert found["time"].values.tolist() == [0.0]
    assert math.isinf(found.error_estimate)


def test_a_region_that_the_wave_has_left_has_no_rate() -> None:
    far = TODA | {"lattice": "fput_strain", "constants": FPUT, "wave": "soliton_sech"}
    far |= {"parameters": {"A": 127}, "slow_times": [0, 0.2], "half_width": 3, "tolerance": 1e-2}
    with pytest.raises(ValueError, match=r"^half_width must keep some of the wave[^\n]*got 0"):
        scene_convergence(Scene.of(**far), (0.4, 0.3, 0.2))


def test_the_rate_of_a_scene_is_that_of_its_order() -> None:
    study = scene_convergence(Scene.of(**TODA), (0.4, 0.3, 0.2))
    assert study.theory == 4
    assert study.rate.holds(4)
    assert study.rate.value == pytest.approx(4.0, abs=0.15)
    assert study.rate.high - study.rate.low < 0.5
    assert all(point.discretisation < 0.05 * point.error for point in study.points)
    assert [point.eps for point in study.points] == [0.4, 0.3, 0.2]


def test_times_and_cells_are_those_of_the_wave_at_every_eps() -> None:
    given = TODA | {"times": [0, 8, 16], "compared": 20}
    scene = Scene.of(**given | {"slow_times": (), "half_width": None})
    finer = at_eps(scene, 0.5 * scene.eps)
    assert finer.slow_times == pytest.approx((0.0, 0.512, 1.024))
    assert finer.half_width == pytest.approx(8.0)
    chain = load_scene("Y2_eps_0.05")
    assert at_eps(chain, 0.1).snapshots == pytest.approx(
        [t / 8 for t in (chain.t0, *chain.snapshots)]
    )
    assert at_eps(chain, 0.1).compared == 750


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*shipped_scenes("lattices")} - {"dimer_rogue"}))
def test_a_shipped_scene_runs_and_its_error_falls_with_eps(name: str) -> None:
    scene = load_scene(name)
    first, second = (
        float(run(scene.changed(eps=factor * scene.eps))["sup_error"][1:].max())
        for factor in (1.6, 1.0)
    )
    assert second < 0.75 * first
