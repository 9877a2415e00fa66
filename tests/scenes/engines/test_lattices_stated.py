"""Scenes on any lattice have observables, stated steps, and are gone on with, as on the chain.

Of each kind of lattice there is one: displacements, two masses and an envelope, strains, a plane.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.runs.repeated_run import compare_runs
from longwave.runs.run_file import load_run, save_run
from longwave.scenes import load_scene, resume, run
from longwave.scenes.description.named_scenes import scene_of, scene_of_toml
from longwave.scenes.description.numerics import Discretisation
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.run_record import UnfinishedRun
from longwave.scenes.observed.observables import OBSERVABLES
from longwave.support.request_limits import request_limits
from tests.families import family

ASKED = tuple(name for name, entry in OBSERVABLES.items() if entry.measured_at != "refinement")
TODA = load_scene("toda_soliton").changed(eps=0.2, curve_points=11)
DIMER = load_scene("dimer_peregrine").changed(eps=0.1, curve_points=11)
STRAINS = load_scene("alpha_beta_rogue").changed(eps=0.2, slow_times=(-0.2, 0, 0.1), half_width=6)


@pytest.fixture(scope="module", params=[TODA, DIMER], ids=["toda", "dimer"])
def whole(request: pytest.FixtureRequest) -> xr.Dataset:
    scene: Scene = request.param
    return run(scene.changed(observables=ASKED))


def test_every_observable_is_there(whole: xr.Dataset) -> None:
    expected = {v.name for name in ASKED for v in OBSERVABLES[name].variables if not v.optional}
    assert expected <= {*whole.variables}
    assert np.all(np.isfinite(whole["energy"]))
    assert np.ptp(whole["energy"].values) < 1e-3 * abs(whole["energy"].values[0])
    assert np.ptp(whole["mean_velocity"].values) < 1e-12


def test_observables_mean_the_same_at_the_same_times(whole: xr.Dataset) -> None:
    errors = dict(zip(whole["curve_time"].values, whole["error_curve"].values, strict=True))
    assert [errors[t] for t in whole["time"].values] == whole["error"].values.tolist()
    difference = whole["strain"] - whole["background"]
    np.testing.assert_array_equal(whole["background_difference"], difference)


def test_the_split_of_the_error_is_exact_at_first_and_small_later(whole: xr.Dataset) -> None:
    parts = sum(whole[f"error_{part}"] for part in ("position", "amplitude", "shape"))
    assert np.all(whole["error"] <= parts + 1e-12)
    assert whole["error_shape"][0] < 1e-10


def test_a_plan_has_the_bits_of_the_search_that_made_it(whole: xr.Dataset) -> None:
    """Catches: a view of the state kept in the place of its values, which go on."""
    plan = scene_of(whole)
    assert isinstance(plan.numerics, Discretisation)
    again = run(plan)
    for name in whole.variables:
        np.testing.assert_array_equal(whole[name], again[name], err_msg=str(name))
    first = whole["strain"].values[0] - whole["analytic"].values[0]
    assert np.max(np.abs(first)) < 1e-12


def test_a_run_is_gone_on_with_to_the_bit(whole: xr.Dataset) -> None:
    t = float(whole["time"].values[1])
    rest = resume(whole, at=t)
    assert rest["time"].values.tolist() == whole["time"].values[2:].tolist()
    for name in ("strain", "error", "state_y", "state_s"):
        np.testing.assert_array_equal(rest[name], whole[name][2:])


def test_finer_steps_and_wider_rings_change_no_more_than_was_estimated(whole: xr.Dataset) -> None:
    measured = scene_of(whole).changed(observables=("strain", "time_step_error", "domain_error"))
    found = run(measured)
    changes = found["time_step_error"] + found["domain_error"]
    assert 0.0 < changes.values.max() <= whole.error_estimate
    assert found["time_step_error"].units == found["sup_error"].units


@pytest.mark.parametrize(
    ("scene", "changes", "message"),
    [
        (TODA, {"engine": "spectral", "observables": ["state"]}, "engine must be 'stencil' for s"),
        (TODA, {"observables": ["strain", "strain"]}, "observables must have each name once, got"),
        (TODA, {"observables": ["energ"]}, "observables must be a known one, got 'energ'"),
        (TODA, {"observables": ["domain_error"]}, "observables must have no refinement with a"),
        (
            STRAINS,
            {"observables": ["energy"]},
            "observables must not include energy on fput_strain",
        ),
        (
            load_scene("square_lump"),
            {"observables": ["state"]},
            "observables must not include state",
        ),
    ],
)
def test_what_a_lattice_does_not_have_is_refused(
    scene: Scene, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=rf"^{message}[^\n]*$"):
        run(scene.changed(**changes))


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ((9.0, "ring", 4096), "step must satisfy step <= "),
        ((1.0, "ring", 64), r"sites must satisfy sites >= \d+ on this ring, got 64"),
        ((1e-12, "ring", 4096), "step must satisfy step >= "),
        ((0.1, "ring", 10**9), "toda_soliton must fit 2 GB"),
        ((1e-7, "ring", 4096), "toda_soliton must take at most 60 min"),
    ],
)
def test_a_stated_discretisation_is_checked(stated: Any, message: str) -> None:
    given = dict(zip(("step", "domain", "sites"), stated, strict=True))
    limits = request_limits("2G", "1h")
    with limits, pytest.raises(ValueError, match=rf"^{message}[^\n]*$"):
        run(TODA.changed(tolerance=None, **given))


def test_what_was_recorded_before_ctrl_c_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if share > 0.3:
            raise KeyboardInterrupt

    plan = scene_of(run(TODA)).changed(observables=("strain", "error_curve"))
    with pytest.raises(UnfinishedRun) as stopped:
        run(plan, stop)
    left = stopped.value.run
    assert 0 < left.sizes["time"] < len(plan.snapshots)
    assert left.unfinished.startswith("Ctrl-C after t = ")
    assert left.equation.startswith("KdV: ")


def test_a_refined_run_has_the_stops_of_the_run_itself() -> None:
    """Catches: steps that the curve's times shorten to little more than half of the stated one.

    Half the stated step was then hardly shorter, and the measured error a tenth of the true one.
    """
    given = {"step": 1.24, "domain": "ring", "sites": 800, "tolerance": None, "curve_points": 201}
    requested = ("strain", "error_curve", "time_step_error", "domain_error")
    scene = TODA.changed(**given, observables=requested)
    found, exact = run(scene), run(TODA.changed(tolerance=1e-10))
    true = np.abs(found["strain"] - exact["strain"]).max("site") / scene.eps**found.power
    assert np.all(true <= 2.0 * found["time_step_error"] + 1e-10)
    assert np.all(found["domain_error"] < 1e-11)


@pytest.mark.parametrize(
    ("name", "quantities"),
    family(
        [
            ("dimer_peregrine", ["v[n] - u[n]", "u[n+1] - v[n]"]),
            ("dimer_rogue", ["u[n+1] - u[n]", "v[n+1] - v[n]"]),
            ("toda_soliton", None),
        ],
        quick=("dimer_peregrine",),
    ),
)
def test_quantities_have_labels_also_in_files(
    name: str, quantities: list[str] | None, tmp_path: Path
) -> None:
    found = run(load_scene(name).changed(eps=0.1))
    if quantities is None:
        assert "quantity" not in found.dims
        return
    assert found["quantity"].values.tolist() == quantities
    assert found["strains"].sel(quantity=quantities[0], drop=True).equals(found["strain"])
    save_run(found, tmp_path / "run.nc")
    assert compare_runs(load_run(tmp_path / "run.nc"), found).is_same


@pytest.mark.parametrize("scene", [TODA, load_scene("rogue_cn_k_0.5")], ids=["toda", "chain"])
def test_a_scheme_of_ones_own_is_stated_in_the_scene(scene: Scene) -> None:
    """Verlet's by its weights: the same numbers as by its name, but for rounding."""
    short = scene.with_tolerance(1e-2).changed(observables=("strain",), compared=200)
    short = short.changed(times=(0.0, 60.0))
    own, named = (
        run(short.changed(scheme=name, engine="stencil"))
        for name in ("verlet, order 2: drifts 1/2, kicks 1", "stoermer_verlet")
    )
    assert own.scheme == "verlet, order 2: drifts 1/2, kicks 1"
    assert own.steps == named.steps
    np.testing.assert_allclose(own["strain"], named["strain"], atol=1e-13)
    plan = scene_of(own)
    np.testing.assert_array_equal(run(plan)["strain"], own["strain"])
    assert Scene.from_json(plan.json()) == scene_of_toml(plan.toml()) == plan
