"""Studies of cost on the lattice: methods agree, orders show, shares are those of the step."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from longwave.reports.studies import lattice_cost
from longwave.reports.studies.lattice_cost import (
    REDUCTION,
    SPECTRAL,
    TRUE_ERROR,
    by_scheme,
    fit_power,
    march_seconds,
    measure_at_eps,
    problem_scene,
    rk4_share,
    spectral,
    window_error,
)
from longwave.scenes import run


def test_stencil_and_ring_agree_on_the_smooth_problem() -> None:
    """Each is the other's reference: catches a reference on other sites or at another time."""
    scene = problem_scene("smooth")
    scene = replace(scene, snapshots=(scene.t0 + 50.0,))
    strains = [
        run(variant)["strain"].values[-1]
        for variant in (by_scheme(scene, "kahan_li_8", 0.25), spectral(scene, 1e-7))
    ]
    assert np.max(np.abs(strains[0] - strains[1])) / scene.eps < 2e-7


def test_a_share_of_one_is_stable_on_the_crest() -> None:
    """Catches a limit taken at rest: the crest's stiffness is larger."""
    scene = problem_scene("crest")
    for name in ("rk4", "kahan_li_8"):
        short = replace(by_scheme(scene, name, 0.99), snapshots=(scene.t0 + 20.0,))
        assert run(short).attrs["blow_up"] == ""


def test_rk4_has_its_order_in_the_error_figure() -> None:
    found = {point.x: point.value for point in rk4_share((0.3, 0.15), t0=-200.0)}
    ratio = (found[0.3] - found[0.0]) / (found[0.15] - found[0.0])
    assert 8 < ratio < 40


def test_the_windows_error_falls_with_its_size() -> None:
    first, second = window_error((2048, 4096, 16384), t0=-2000.0)
    assert first.value > 4 * second.value > 0


def test_a_fit_returns_the_power_of_its_data() -> None:
    assert fit_power((x, 7.0 * x**-3.5) for x in (1.0, 2.0, 5.0)) == pytest.approx(-3.5)


def test_the_rings_integration_is_timed_apart_from_its_data(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Catches the ring charged for data that the others have already, or its data forgotten."""
    strain = ("time", "site"), np.zeros((1, 3))
    found = xr.Dataset({"strain": strain}, attrs={"seconds": 0.5})
    monkeypatch.setattr(lattice_cost, "_timed", lambda _: found)
    monkeypatch.setattr(lattice_cost, "march_seconds", lambda *_: 0.125)
    points = lattice_cost.work_precision("periodic")
    times = {(p.series == SPECTRAL): (p.seconds, p.data_seconds) for p in points}
    assert times == {True: (0.125, 0.375), False: (0.5, 0.0)}


def test_the_rings_integration_can_be_repeated() -> None:
    scene = problem_scene("crest")
    ring = spectral(replace(scene, snapshots=(scene.t0 + 10.0,)), 1e-2)
    assert march_seconds(ring, run(ring)) > 0.0


@pytest.mark.slow
def test_each_variant_changes_one_setting() -> None:
    """Catches the wide lattice priced as the window, and an error judged against itself."""
    found = {point.series: point for point in measure_at_eps(0.1, with_reference=True)}
    assert list(found)[:4] == ["RK4, wide lattice", "RK4, window", "order 6, window", "spectral"]
    scaled = [point.scaled for point in found.values()]
    assert scaled == [True, True, True, False, False, False]
    wide = 2 * (2 * round(1.25 / 0.1**3) + 100)
    ratio = found["RK4, wide lattice"].value / found["RK4, window"].value
    assert ratio == pytest.approx(wide / 2048, rel=0.01)
    assert 0.0 < found[TRUE_ERROR].value < 1e-3
    assert found[REDUCTION].value > 0.3


@pytest.mark.slow
def test_waves_around_a_small_ring_do_not_end_the_search() -> None:
    """Its change obeys no law of the step: three shorter ones had not helped, a wider ring does."""
    found = run(spectral(problem_scene("periodic"), 1e-6))
    assert found.attrs["error_estimate"] <= 1e-6
